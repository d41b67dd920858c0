"""Wheels of a set that do not give what is commanded. Tests: tests/native/test_allocator_wheels.py."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .box import Array
from .parameters import Parameters

FORGOTTEN = 300.0
"""s, in which what a wheel gave is forgotten."""
TRUST_TORQUE, TRUST_TIME = 0.02, 100.0
"""Of a wheel's limit, and s: commands below say nothing of it."""
RETRY = 3000.0
"""s, after which a wheel that failed is tried again."""


@dataclass(frozen=True)
class Watch:
    """What the wheels (4,) have given of their commands."""

    h_w: Array
    """N m s, of the last sample."""
    command: Array
    """N m."""
    given: Array
    """Sum of command times change of momentum, forgotten."""
    asked: Array
    """Sum of command squared times time, forgotten."""
    failed_for: Array
    """s since it was found to give less than half; 0: it was not."""

    @staticmethod
    def begun(h_w: Array, command: Array) -> Watch:
        """Returns the watch at the start, with the first commands (4,) N m."""
        return Watch(h_w, command, *np.zeros((3, len(h_w))))

    def after(self, h_w: Array, h: float, p: Parameters) -> Watch:
        """Returns what is known h s later, when the momenta are h_w (4,) N m s."""
        kept = 1.0 / (1.0 + h / FORGOTTEN)
        trust = (TRUST_TORQUE * p.wheel_torque_max) ** 2 * TRUST_TIME
        given = kept * self.given + self.command * (h_w - self.h_w)
        asked = kept * self.asked + self.command**2 * h
        there, already = np.arange(len(h_w)) < p.wheels, self.failed_for > 0.0
        found = there & (given + trust < 0.5 * (asked + trust))
        longer = np.where(self.failed_for + h > RETRY, 0.0, self.failed_for + h)
        return replace(
            self,
            given=np.where(already, 0.0, given),
            asked=np.where(already, 0.0, asked),
            failed_for=np.where(already, longer, np.where(found, h, 0.0)),
        )

    def rows(self) -> Array:
        """Returns the watch as an array (5, 4), as a state can hold it."""
        return np.stack((self.h_w, self.command, self.given, self.asked, self.failed_for))

    def keeping(self, h_w: Array, command: Array) -> Watch:
        """Returns the watch with what the next sample is compared with."""
        return replace(self, h_w=h_w, command=command)

    def failed(self, p: Parameters) -> NDArray[np.bool_]:
        """Whether each wheel (4,) is one that failed, where that is looked for."""
        return p.find_failures & (self.failed_for > 0.0)
