"""The co-simulation master: exchange, step loop in Python and C, recording, fault injection."""
