"""Runs of the plant for the tests: the block itself, or its bare integrator."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import plant
from plant.attitude import COMPOSITIONS, Body, lgvi_step
from tests.blocks import inputs, parameters

FULL_INERTIA = np.array([[2.53, 0.21, -0.17], [0.21, 3.04, 0.11], [-0.17, 0.11, 2.89]])
"""kg m2: products of inertia that are not small, all principal moments apart."""


def checked(**changes):
    """The plant's parameters with changes, checked. Without drag, whose plates make the moment's slope jump, unless
    asked for."""
    p = parameters("plant", **{"drag": False, **changes})
    plant.check(p)
    return p


def command(dipole_cmd=(0.0, 0.0, 0.0), wheel_torque_cmd=0.0) -> plant.Inputs:
    return inputs("plant", dipole_cmd=list(dipole_cmd), wheel_torque_cmd=wheel_torque_cmd)


def fly(p, u: plant.Inputs, h: float, n: int, x: plant.State | None = None) -> list[plant.State]:
    """The states after 0, 1, .. n steps of length h."""
    states = [plant.start(p, u) if x is None else x]
    for _ in range(n):
        states.append(plant.step(states[-1], u, p, h)[0])
    return states


def no_moment(R, t, Omega):
    return np.zeros(3)


def bare(
    order: int,
    h: float,
    n: int,
    R: np.ndarray,
    Omega: np.ndarray,
    J: np.ndarray,
    moment=no_moment,
    wheel: Callable[[float], float] = lambda t: 0.0,
    wheel_mean: Callable[[float, float], float] = lambda t0, t1: 0.0,
    rate_dependent: bool = False,
    seen: Callable[[np.ndarray, np.ndarray], None] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """R and Omega after n composed steps of the integrator alone, with l_w and its mean given as functions of time."""
    body = Body(J, np.linalg.inv(J), rate_dependent)
    e1 = np.array([1.0, 0.0, 0.0])
    Pi = J @ Omega + wheel(0.0) * e1
    tau = moment(R, 0.0, Omega)
    for i in range(n):
        t = i * h
        for share in COMPOSITIONS[order]:
            s = share * h
            R, Pi, tau = lgvi_step(R, Pi, tau, moment, body, t, s, wheel_mean(t, t + s) * e1, wheel(t + s) * e1)
            t += s
        if seen:
            seen(R, Pi)
    return R, body.J_inverse @ (Pi - wheel(n * h) * e1)


def measured_order(errors: dict[float, float]) -> float:
    """Slope of log error over log step, by least squares."""
    return float(np.polyfit(np.log(list(errors)), np.log(list(errors.values())), 1)[0])
