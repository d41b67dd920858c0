"""`orchestrate review`: what a design review asks of a satellite, computed from its scenario."""
