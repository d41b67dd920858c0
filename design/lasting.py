"""For how long at least a flight stays settled that has settled for good. Tests: tests/design/test_rank.py."""

from __future__ import annotations

LASTING = 1.0 / 6.0
"""Of its duration: half an orbit of three. One that comes below a limit in that part, at its end, has not settled."""
