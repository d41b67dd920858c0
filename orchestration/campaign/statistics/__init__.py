"""Statistics of the rows: verdicts, sensitivities, the worst case."""
