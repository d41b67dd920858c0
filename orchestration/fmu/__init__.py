"""An FMU as a file and as a model of its variables."""
