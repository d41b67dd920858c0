"""The expectations of a scenario, and whether a run met them."""
