"""What the rows say: verdicts, sensitivities, the worst case."""
