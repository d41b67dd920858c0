"""Records in the place of FMUs: read, held against the scenario, and packed as an FMU that plays them back."""
