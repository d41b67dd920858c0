"""A block takes each parameter at either end of its limits: its check refuses no more than the interface says.

A proof over what a check lets through (evidence/proofs) would be worth nothing of a check that refuses nearly all.

Shows FC-1.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from evidence.proofs.coverage import FLIGHT
from fmus.interface import Variable, load

from .driver import running

RELATED = {
    "K0": "0 is excluded",
    "wheel_torque_max": "0 is no wheel: it has no torque and no momentum",
    "wheel_momentum_max": "0 is no wheel: it has no torque and no momentum",
    "rate_lost": "not below rate_acquire",
    "gravitational_parameter": "the start orbit is closed",
}
"""Parameters whose lower limit another one excludes, and why."""
STRONG = "controller_planned: dipole_max"
"""At the upper limit of 1e6 A m2 no control period is short enough."""


def ends(block: str) -> Iterator[tuple[Variable, float]]:
    """Each parameter that is a number with a limit of it, but for axes and those of a relation."""
    for v in load(block).of("parameter"):
        if v.type in ("real", "integer") and not is_turned(v):
            for limit in (v.min, v.max):
                related = limit == v.min and v.name in RELATED
                if limit is not None and not related and (f"{block}: {v.name}" != STRONG or limit == v.min):
                    yield v, limit


def is_turned(v: Variable) -> bool:
    """Whether its rows are axes, or it is a rotation."""
    return v.name in ("R_d0", "boresight_B") or v.name.endswith(("_axes", "_axis", "_axis_B"))


@pytest.mark.parametrize("block", FLIGHT)
def test_a_block_takes_each_parameter_at_each_of_its_limits(block: str) -> None:
    for v, limit in ends(block):
        value = int(limit) if v.type == "integer" else limit
        with running(block, **{v.name: np.full(v.shape, value) if v.shape else value}):
            pass


@pytest.mark.parametrize("block", FLIGHT)
def test_a_block_takes_axes_of_any_direction(block: str) -> None:
    for v in filter(is_turned, load(block).of("parameter")):
        for turn in Rotation.random(20, random_state=53).as_matrix():
            start = np.asarray(v.start, dtype=float).reshape(-1, 3)
            with running(block, **{v.name: (start @ turn.T).reshape(v.shape)}):
                pass
