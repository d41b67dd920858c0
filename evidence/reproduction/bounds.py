"""Least times of the two manoeuvres round the Earth, by the balance of momentum."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from design.loop import read
from design.momentum import MomentumBalance, Verdict

from ..paper import LIMITS, SCENARIOS, Array, constants, node

NODES = np.arange(0.0, 360.0, 10.0)
"""Longitudes of the ascending node, deg east."""


@dataclass(frozen=True)
class Times:
    """Least times at NODES, s; NaN beyond the horizon."""

    least: Array
    simple: Array
    at_claim: list[Verdict]
    """For the paper's own time and dipole."""


def bounds(which: str, dipole_max: float, mass: float = 1.0) -> Times:
    """The momentum bound of a manoeuvre with rods of `dipole_max`, A m2, and inertia divided by `mass`."""
    loop = read(SCENARIOS[which]).loop.change(constants(mass=mass))
    least, simple, at_claim = [], [], []
    for longitude in NODES:
        p = loop.change(node(float(longitude)))
        balance = MomentumBalance(p.plant, p.controller, dipole_max, horizon=1500.0)
        bound = balance.least_time()
        least.append(math.nan if bound.least is None else bound.least)
        simple.append(math.nan if bound.simple is None else bound.simple)
        at_claim.append(balance.at(LIMITS[which][1]))
    return Times(np.array(least), np.array(simple), at_claim)
