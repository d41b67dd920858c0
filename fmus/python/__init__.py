"""The Python flavour: PythonFMU packages a block, and a shell in C goes round its library."""
