"""The planned controller: acquisition and hold within the actuators' limits. Native only: its C is in `native/`."""
