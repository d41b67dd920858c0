"""Reaction wheels: the momentum of each over a step, in closed form, within its limits.

l_w is I_w times the wheel's speed relative to the body, so with motor torque tau, viscous friction
c and Coulomb friction d

    dl_w/dt = tau - (c/I_w) l_w - d sign(l_w).

Over a step tau is constant. The step is divided where a wheel reaches its momentum limit, or (with Coulomb friction)
stands still, so that each l_w is smooth in each part: without that a composed integrator falls back to order 1.
Departures from the paper: friction and the limit, # not in the paper: it takes the wheel as ideal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from .so3 import Array


@dataclass(frozen=True)
class Wheel:
    """Limits and friction of the wheel."""

    inertia: float
    """I_w about its axis, kg m2."""
    momentum_max: float
    """N m s."""
    torque_max: float
    """N m."""
    viscous_friction: float = 0.0
    """N m s/rad."""
    coulomb_friction: float = 0.0
    """N m."""
    breakaway_friction: float = 0.0
    """N m: the motor torque at rest above which it turns, where it is above Coulomb friction."""
    gain: float = 1.0
    """The motor's torque over its command, which is clipped first."""


class Segment(NamedTuple):
    """A part of a step in which l_w moves smoothly: dl_w/dt = drive - decay l_w, from l_start."""

    duration: float
    l_start: float
    l_end: float
    drive: float
    decay: float

    def momentum(self, s: float) -> float:
        """l_w at time s after the segment's start, N m s; s may lie outside the segment."""
        return _momentum(self.l_start, self.drive, self.decay, s)

    def cut(self, duration: float) -> Segment:
        """Its start, of this duration, s."""
        return self._replace(duration=duration, l_end=self.momentum(duration))

    def mean(self, s: float, duration: float) -> float:
        """Mean of l_w over [s, s + duration], N m s; the duration may be negative."""
        # The rate at s from that at the start: drive - decay l_w(s) would cancel where friction is strong.
        rate = (self.drive - self.decay * self.l_start) * math.exp(-self.decay * s)
        return self.momentum(s) + rate * duration * _phi2(self.decay * duration)


class Part(NamedTuple):
    """A part of a step in which every l_w of the wheels moves smoothly."""

    duration: float
    segments: tuple[Segment, ...]
    """Of each wheel, all of this duration."""

    def ends(self) -> list[float]:
        """l_w of each wheel at the part's end, N m s."""
        return [segment.l_end for segment in self.segments]

    def momentum(self, s: float) -> Array:
        """l_w (n,) at time s after the part's start, N m s."""
        return np.array([segment.momentum(s) for segment in self.segments])

    def mean(self, s: float, duration: float) -> Array:
        """Means (n,) of l_w over [s, s + duration], N m s."""
        return np.array([segment.mean(s, duration) for segment in self.segments])


def motor_torque(command: float, wheel: Wheel) -> float:
    """The motor's torque, N m: the command within the motor's limit, times the drive's gain."""
    return wheel.gain * min(max(command, -wheel.torque_max), wheel.torque_max)


def net_torque(momentum: float, command: float, wheel: Wheel) -> float:
    """dl_w/dt, N m, at this momentum: motor and friction; zero where it would pass the momentum limit."""
    drive, decay = _law(momentum, motor_torque(command, wheel), wheel)
    rate = drive - decay * momentum
    return 0.0 if _at_limit(momentum, rate, wheel) else rate


def momentum_saturated(momentum: float, command: float, wheel: Wheel) -> bool:
    """Returns whether the wheel is at its momentum limit and the command, less friction, would drive it further."""
    drive, decay = _law(momentum, motor_torque(command, wheel), wheel)
    rate = drive - decay * momentum
    return rate != 0.0 and _at_limit(momentum, rate, wheel)


def parts(momenta: Sequence[float], commands: Sequence[float], h: float, wheels: Sequence[Wheel]) -> Iterator[Part]:
    """The parts of a step of length h in which every l_w is smooth, from momenta, N m s, at constant commands, N m."""
    left = h
    while left > 0.0:
        first = tuple(map(partial(_first_segment, h=left), momenta, commands, wheels))
        duration = min((segment.duration for segment in first), default=left)
        part = Part(duration, tuple(one if one.duration == duration else one.cut(duration) for one in first))
        if duration > 0.0:
            yield part
        momenta, left = part.ends(), left - duration


def _first_segment(momentum: float, command: float, wheel: Wheel, h: float) -> Segment:
    """Until the law changes, or for h s."""
    drive, decay = _law(momentum, motor_torque(command, wheel), wheel)
    rate = drive - decay * momentum
    if rate == 0.0 or _at_limit(momentum, rate, wheel):
        return Segment(h, momentum, momentum, 0.0, 0.0)
    target = _next_event(momentum, rate, wheel)
    until = _time_to(target, momentum, rate, decay)
    if until >= h:
        return Segment(h, momentum, _momentum(momentum, drive, decay, h), drive, decay)
    return Segment(until, momentum, target, drive, decay)


def _momentum(l_start: float, drive: float, decay: float, s: float) -> float:
    """l_w after a time s, N m s."""
    return l_start + (drive - decay * l_start) * s * _phi1(decay * s)


def _law(momentum: float, torque: float, wheel: Wheel) -> tuple[float, float]:
    """(drive, decay) of dl_w/dt = drive - decay l_w on this side of standstill."""
    friction = wheel.coulomb_friction
    decay = wheel.viscous_friction / wheel.inertia
    breakaway = max(friction, wheel.breakaway_friction)
    if breakaway == 0.0:
        return torque, decay
    if momentum == 0.0:
        return math.copysign(abs(torque) - friction if abs(torque) > breakaway else 0.0, torque), decay
    return torque - math.copysign(friction, momentum), decay


def _at_limit(momentum: float, rate: float, wheel: Wheel) -> bool:
    return abs(momentum) >= wheel.momentum_max and rate * momentum >= 0.0


def _next_event(momentum: float, rate: float, wheel: Wheel) -> float:
    """The momentum, ahead in the direction of `rate`, where the law changes: standstill or the limit."""
    if (wheel.coulomb_friction > 0.0 or wheel.breakaway_friction > 0.0) and momentum * rate < 0.0:
        return 0.0
    return math.copysign(wheel.momentum_max, rate)


def _time_to(target: float, momentum: float, rate: float, decay: float) -> float:
    """Returns when l_w reaches `target`; infinite where friction stops it before."""
    share = (target - momentum) / rate
    if decay == 0.0:
        return share
    return -math.log1p(-decay * share) / decay if decay * share < 1.0 else math.inf


def _phi1(x: float) -> float:
    """(1 - exp(-x))/x."""
    return -math.expm1(-x) / x if x != 0.0 else 1.0


def _phi2(x: float) -> float:
    """(x - 1 + exp(-x))/x^2; a series where that cancels."""
    if abs(x) < 0.05:
        return 0.5 - x / 6.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0 * (1.0 - x / 8.0)))))
    return (x + math.expm1(-x)) / (x * x)
