"""Times that several parts take alike: how long a flight stays settled, and a radian of the orbit.

Tests: tests/design/test_rank.py.
"""

from __future__ import annotations

LASTING = 1.0 / 6.0
"""Of its duration: half an orbit of three. One that comes below a limit in that part, at its end, has not settled."""

RADIAN = 1000.0
"""s: a radian of the orbit, over which the estimator without a gyro is told of a torque as a random walk."""
