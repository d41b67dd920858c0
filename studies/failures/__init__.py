"""Rods, sensors and wheels that fail in flight, and what becomes of it: docs/failures.md."""
