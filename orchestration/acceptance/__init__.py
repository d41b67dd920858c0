"""Finds out whether another team's FMU fits: by its files, test vectors, and back to back with ours."""
