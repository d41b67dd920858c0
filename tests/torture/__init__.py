"""Long trials with random numbers, as commands that print counts: `python -m tests.torture`."""
