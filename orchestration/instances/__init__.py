"""A running FMU: in this process, or in a process of its own."""
