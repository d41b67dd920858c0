"""Rods, sensors and wheels that fail in flight, and what becomes of it: docs/evidence/failures.md."""
