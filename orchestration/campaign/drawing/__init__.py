"""The values of each run: distributions, their samples, expressions, the design."""
