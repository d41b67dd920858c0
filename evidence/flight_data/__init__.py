"""What makes docs/evidence/flight_data.md: the project's models beside the records of a satellite that flew."""
