"""A campaign's file, as it stands."""
