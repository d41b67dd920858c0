"""Turns the blocks into FMI 2.0 co-simulation FMUs: ports and FMI, no physics."""
