"""Random tumbles, V.B, V.C and long holds in SI units: docs/evidence/flight.md."""
