"""Requirements and what shows them: `make trace` (python -m evidence trace)."""
