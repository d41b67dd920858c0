"""The plant in C. `tables` writes its tables at build time; nothing here runs inside an FMU."""
