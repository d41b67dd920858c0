"""What a scenario expects of a run, and whether the run met it."""
