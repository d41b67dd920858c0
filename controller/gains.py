"""Scales of the gains: K = k K0, L = l L0 [9].

Requirement: CT-2.
"""

from __future__ import annotations

SCHEDULES = ("error", "constant")


def attitude_scale(kappa0: float, a1: float, a2: float, angle: float, angle_0: float) -> float:
    """k = kappa0 (a1 + |zeta(t)|)/(a2 + |zeta(0)|) [10]; angles in rad."""
    return kappa0 * (a1 + angle) / (a2 + angle_0)


def rate_scale(lambda0: float, c1: float, c2: float, rate: float, rate_0: float) -> float:
    """l = lambda0 (c1 + |omega(t)|)/(c2 + |omega(0)|) [10]; rates in rad/s."""
    return lambda0 * (c1 + rate) / (c2 + rate_0)
