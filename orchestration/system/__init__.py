"""A scenario held against its blocks: wiring, order, clock, starts, signals, faults."""
