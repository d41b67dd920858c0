"""The Python flavour: PythonFMU packages a block, and a shell in C encloses its library."""
