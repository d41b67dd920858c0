"""Another team's FMU in the place of one of ours: ports fitted, adapter."""
