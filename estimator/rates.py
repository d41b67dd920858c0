"""How the attitude turns over a step: by the measured rate, or, without a gyro, by the equations of motion.
Tests: tests/estimator/test_estimator.py."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .so3 import Array, cross, exp, hat

STEP = 0.5
"""Longest step of the integration, s."""


@dataclass(frozen=True)
class Torques:
    """The torques on a satellite of inertia J (3,3), kg m2, over a step."""

    J: Array
    J_inverse: Array
    dipole_B: Array
    """A m2"""
    field_N: Array
    """T"""
    nadir_N: Array
    """sqrt(3 mu/r^3) times the unit position, 1/s: the gravity gradient is nadir x J nadir."""
    wheel_B: Array
    """dl/dt of all wheels, N m"""
    disturbance_B: Array
    """N m"""

    def acceleration(self, R: Array, omega: Array, momentum_B: Array) -> Array:
        """dω/dt (3,): J dω/dt = (J ω + l) × ω + m × Rᵀ B + nadir × J nadir - dl/dt + d."""
        nadir, field = R.T @ self.nadir_N, R.T @ self.field_N
        torque = cross(self.J @ omega + momentum_B, omega) + cross(self.dipole_B, field)
        torque = torque + self.disturbance_B
        return self.J_inverse @ (torque + cross(nadir, self.J @ nadir) - self.wheel_B)

    def growth(self, omega: Array, momentum_B: Array) -> Array:
        """The derivative (3,3), 1/s, of dω/dt with ω."""
        return self.J_inverse @ (hat(self.J @ omega + momentum_B) - hat(omega) @ self.J)


def turn_by_gyro(before: Array, now: Array, h: float, since: float) -> Array:
    """The turn (3,), rad, of a step of h s by the rates (3,), rad/s, of the last measurement and of this one.

    They are `since` s apart, over which the rate is linear; the steps between, which had the last one alone, are made
    up for.
    """
    return h * before + 0.5 * since * (now - before) + h * h / 12.0 * cross(before, now)


def turn_by_dynamics(
    R: Array, omega: Array, momentum_B: Array, torques: Torques, h: float
) -> tuple[Array, Array, Array]:
    """Attitude (3,3), its turn (3,) in all and rate (3,) after h s; Runge and Kutta, order 4, for the rate."""
    steps = max(1, math.ceil(h / STEP))
    dt = h / steps
    whole = np.zeros(3)
    for _ in range(steps):
        half_R, half_l = R @ exp(0.5 * dt * omega), momentum_B + 0.5 * dt * torques.wheel_B
        next_R, next_l = R @ exp(dt * omega), momentum_B + dt * torques.wheel_B
        a1 = torques.acceleration(R, omega, momentum_B)
        a2 = torques.acceleration(half_R, omega + 0.5 * dt * a1, half_l)
        a3 = torques.acceleration(half_R, omega + 0.5 * dt * a2, half_l)
        a4 = torques.acceleration(next_R, omega + dt * a3, next_l)
        following = omega + dt / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
        turn = 0.5 * dt * (omega + following) + dt * dt / 12.0 * (cross(omega, following) + a1 - a4)
        R, omega, momentum_B, whole = R @ exp(turn), following, next_l, whole + turn
    return R, whole, omega
