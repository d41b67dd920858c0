"""A scenario's system as a file for other tools: SSP archive or container FMU."""
