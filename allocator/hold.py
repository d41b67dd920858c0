"""The hold near saturation: while a demand is too near its limit, all commands keep their last values.
Tests: tests/allocator/test_block.py.

Requirement: AL-2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .vector import Array

FRACTION_CAP = 1e6
"""Largest demand over limit that is reported, and what is reported where the allocation is singular."""


class Commands(NamedTuple):
    """dipole (3,) A m2 along the rods' axes; wheel_torque, dl_w/dt in N m."""

    dipole: Array
    wheel_torque: float


NONE = Commands(np.zeros(3), 0.0)
"""The commands that are held before any other has been given."""
NONE.dipole.flags.writeable = False


def choose(fraction: float, hold_fraction: float, wanted: Commands, last: Commands) -> tuple[Commands, bool]:
    """The commands to give, and whether they are held: `last` while fraction >= hold_fraction, else `wanted`.

    All are held together, the ones far from their limits too.
    """
    if fraction < hold_fraction:
        return wanted, False
    return last, True
