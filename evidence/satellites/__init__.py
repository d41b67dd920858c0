"""Satellites from 1U to 500 kg, flown by their data alone: docs/evidence/satellites.md."""
