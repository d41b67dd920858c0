"""Wrong signs, axes, units and attitudes at every port of a loop: what shows each of them, and what mends one."""
