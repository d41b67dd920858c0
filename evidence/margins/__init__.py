"""Stability margins of the holds: docs/evidence/margins.md."""
