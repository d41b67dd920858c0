"""Wheels of a set that do not give what is commanded, by their telemetry alone; the native flavour looks at the
body, too, and learns friction. Tests: tests/native/test_allocator_failed_wheels.py."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .box import Array
from .parameters import Parameters

FORGOTTEN = 300.0
"""s, in which what a wheel gave is forgotten."""
FRICTION = 0.05
"""Of a wheel's limit: what friction may take of a command."""
TRUST_TORQUE, TRUST_TIME = 0.02, 20.0
"""Of a wheel's limit beyond friction, and s: commands below say nothing of it."""
CONFIRMED = 2.0
"""s, for which this is found before a wheel counts as failed: telemetry may be a sample old."""
RETRY = 3000.0
"""s, after which a wheel that failed is tried again."""
PROBE_TORQUE, PROBE_TIME = 0.2, 2.0
"""Of its limit, and s: the command by which it is tried, forth and back."""
AT_LIMIT = 0.99
"""Of its momentum's limit: a trial that moves it no further says nothing."""
WORKS = 0.5
"""Of its command: a wheel that gives more as it is tried is used, by the sign with which it does."""


@dataclass(frozen=True)
class Watch:
    """What the wheels (4,) have given of their commands."""

    h_w: Array
    """N m s, of the last sample."""
    command: Array
    """N m."""
    given: Array
    """Sum of what friction cannot take of the command, times change of momentum, forgotten."""
    asked: Array
    """Sum of what friction cannot take of the command, squared, times time, forgotten."""
    failed_for: Array
    """s since it gave less than half; below 0: not yet confirmed; 0: it gives more."""

    expected: Array
    """N m s, at the next sample; 0 of wheels that are not there."""
    tried: Array
    """What each gave of its command as it was last tried; 0: never."""

    @staticmethod
    def begun(h_w: Array, command: Array, p: Parameters) -> Watch:
        """Returns the watch at the start, with the first commands (4,) N m."""
        none = np.zeros(len(h_w))
        return Watch(h_w, command, none, none, none, np.where(np.arange(len(h_w)) < p.wheels, h_w, 0.0), none)

    def after(self, h_w: Array, h: float, p: Parameters) -> Watch:
        """Returns what is known h s later, when the momenta are h_w (4,) N m s."""
        kept = 1.0 / (1.0 + h / FORGOTTEN)
        trust = (TRUST_TORQUE * p.wheel_torque_max) ** 2 * TRUST_TIME
        most = FRICTION * p.wheel_torque_max
        forth = self.sign(p)
        command = forth * np.copysign(np.maximum(abs(self.command) - most, 0.0), self.command)
        counts = (self.failed_for <= 0.0) | (self.failed_for > RETRY)
        end = AT_LIMIT * p.wheel_momentum_max
        stopped = (self.failed_for > RETRY) & (abs(self.h_w) > end) & (abs(h_w) > end)
        command = np.where(stopped, 0.0, command)
        given = np.where(counts, kept * self.given + command * (h_w - self.h_w), 0.0)
        asked = np.where(counts, kept * self.asked + command**2 * h, 0.0)
        there = np.arange(len(h_w)) < p.wheels
        confirmed = (self.failed_for < 0.0) & (h - self.failed_for > CONFIRMED)
        later = np.where(confirmed, RETRY + h, self.failed_for - h)
        found = np.where(there & (given + trust < 0.5 * (asked + trust)), later, 0.0)
        ends = self.failed_for + 0.5 * h > RETRY + PROBE_TIME
        whole = asked / (1.0 - FRICTION / PROBE_TORQUE)
        share = forth * np.clip(np.divide(given, whole, out=np.zeros_like(given), where=whole > 0.0), -1.0, 1.0)
        tried = np.where(ends, share, self.tried)
        longer = np.where(ends, np.where(abs(tried) > WORKS, 0.0, h), self.failed_for + h)
        failed_for = np.where(self.failed_for <= 0.0, found, longer)
        forgets = ends | ((self.failed_for <= 0.0) & (failed_for > RETRY))
        given, asked = np.where(forgets, 0.0, given), np.where(forgets, 0.0, asked)
        return replace(self, given=given, asked=asked, failed_for=failed_for, tried=tried)

    def probing(self, torque: Array, h_w: Array, p: Parameters) -> Array:
        """Returns the commands (wheels,) N m for preferred torques; those of wheels that are tried are their probes."""
        since = self.failed_for[: p.wheels] - RETRY
        forth = since < 0.5 * (PROBE_TIME + p.command_period)
        first = np.where(p.of_wheels(h_w) > 0.5 * p.wheel_momentum_max[: p.wheels], -PROBE_TORQUE, PROBE_TORQUE)
        probe = np.where(forth, first, -first) * p.wheel_torque_max[: p.wheels]
        return np.where(p.find_failures & (since > 0.0), probe, self.sign(p)[: p.wheels] * torque)

    def by_trial(self, h_w: Array, p: Parameters) -> Array:
        """Returns what wheels (wheels,) that are tried give, N m, as the last trial showed."""
        tried = np.where(self.failed_for > RETRY, self.tried, 0.0)[: p.wheels]
        return tried * self.probing(np.zeros(p.wheels), h_w, p)

    def is_tried(self, p: Parameters) -> NDArray[np.bool_]:
        """Returns whether each wheel (wheels,) is tried now."""
        return p.find_failures & (self.failed_for[: p.wheels] > RETRY)

    def sign(self, p: Parameters) -> Array:
        """Returns -1 of each wheel (4,) that is reversed, 1 of the others."""
        return np.where(self.reversed(p), -1.0, 1.0)

    def reversed(self, p: Parameters) -> NDArray[np.bool_]:
        """Returns whether each wheel (4,) gives the opposite of its commands, as its trial showed."""
        return p.find_failures & (self.tried < -WORKS)

    def rows(self) -> Array:
        """Returns the watch as an array (7, 4), as a state can hold it."""
        return np.stack((self.h_w, self.command, self.given, self.asked, self.failed_for, self.expected, self.tried))

    def keeping(self, h_w: Array, command: Array, gains: Array, p: Parameters) -> Watch:
        """Returns the watch with what the next sample is compared with; gains (4,): of the wheels' commands."""
        there = np.arange(len(h_w)) < p.wheels
        expected = np.where(there, h_w + p.command_period * gains * command, 0.0)
        return replace(self, h_w=h_w, command=command, expected=expected)

    def failed(self, p: Parameters) -> NDArray[np.bool_]:
        """Returns whether each wheel (4,) is one that failed, where that is looked for."""
        return p.find_failures & (self.failed_for > 0.0)
