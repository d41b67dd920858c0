"""Satellites with three and four wheels under the planned controller: docs/evidence/wheels.md."""
