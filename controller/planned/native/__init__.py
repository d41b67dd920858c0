"""The planned controller in C. `tables` writes its field models at build time; nothing here runs inside an FMU."""
