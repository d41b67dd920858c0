"""Whether another team's FMU fits: its files, test vectors, back to back with ours."""
