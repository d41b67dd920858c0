"""From a scenario file to a Result: read, open, plan, execute."""
