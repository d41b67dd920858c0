"""The guard through which the planned controller's commands leave it.

Shows FC-4.
"""

from __future__ import annotations

import math
import sys
from ctypes import POINTER, byref, c_double, c_ubyte

import pytest

from .core import library

RODS, TORQUE = (9.0, 4.5, 0.09), 1e-3
LARGEST = sys.float_info.max


def guarded(commands):
    """What leaves, and the first letter of the output that is refused, or None."""
    given, refused = (c_double * 7)(*commands), c_ubyte()
    library().probe_guard((c_double * 3)(*RODS), c_double(TORQUE), given, byref(refused))
    return list(given), chr(refused.value) if refused.value else None


@pytest.fixture(autouse=True)
def _types():
    library().probe_guard.argtypes = [POINTER(c_double), c_double, POINTER(c_double), POINTER(c_ubyte)]


def test_commands_within_their_limits_keep_each_bit():
    for commands in ([9.0, -4.5, 0.09, -1e-3, LARGEST, -LARGEST, 5e-324], [-0.0, 5e-324, 0.089, 0.0, -0.0, 1.0, 2.0]):
        left, refused = guarded(commands)
        assert refused is None
        assert [math.copysign(1.0, x) for x in left] == [math.copysign(1.0, x) for x in commands]
        assert left == commands


def test_a_command_beyond_the_limit_of_its_rod_or_wheel_is_brought_to_it():
    just = [math.nextafter(limit, math.inf) for limit in (*RODS, TORQUE)]
    limits = [*RODS, TORQUE]
    assert guarded([*just, 1.0, 2.0, 3.0]) == ([*limits, 1.0, 2.0, 3.0], None)
    assert guarded([*(-x for x in just), 0, 0, 0]) == ([*(-x for x in limits), 0, 0, 0], None)
    assert guarded([LARGEST] * 4 + [LARGEST] * 3) == ([*limits, *[LARGEST] * 3], None)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", range(7))
def test_a_command_that_is_no_finite_number_is_refused_by_name(bad, place):
    commands = [0.01, 0.01, 0.01, 1e-4, 1e-4, 1e-4, 1e-4]
    commands[place] = bad
    assert guarded(commands)[1] == ("d", "d", "d", "w", "t", "t", "t")[place]
