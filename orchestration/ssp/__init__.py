"""Reading SSP archives."""
