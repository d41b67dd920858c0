"""References for the plant's motion that share no code with its integrator.

The equations are the paper's in the body rate, [1] and [2] with the wheel's torque [14]; the plant
integrates momentum. `rk4` is the classical Runge-Kutta method at a fixed step, for comparisons of
cost; `truth` is SciPy's DOP853 at its tightest tolerance. Tests: tests/evidence/verification/test_cost.py.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import plant

Moment = Callable[[np.ndarray, float, np.ndarray], np.ndarray]
"""External moment in body axes of R, t, Omega."""
WheelTorque = Callable[[float], float]
"""dl_w/dt of l_w."""


def derivative(t: float, y: np.ndarray, J: np.ndarray, moment: Moment, wheel_torque: WheelTorque) -> np.ndarray:
    """dy/dt of y = (R row by row, Omega, l_w)."""
    R, (p, q, r), l_w = y[:9].reshape(3, 3), y[9:12], y[12]
    Omega = y[9:12]
    dl_w = wheel_torque(l_w)
    tau_RW = np.array([-dl_w, -r * l_w, q * l_w])  # [14]
    L = J @ Omega
    gyroscopic = np.array([q * L[2] - r * L[1], r * L[0] - p * L[2], p * L[1] - q * L[0]])
    skew = np.array([[0.0, -r, q], [r, 0.0, -p], [-q, p, 0.0]])
    dOmega = np.linalg.solve(J, moment(R, t, Omega) + tau_RW - gyroscopic)
    return np.concatenate([(R @ skew).ravel(), dOmega, [dl_w]])


def rk4(y: np.ndarray, t: float, h: float, *system: Any) -> np.ndarray:
    """One step of the classical fourth-order method."""
    k1 = derivative(t, y, *system)
    k2 = derivative(t + h / 2, y + h / 2 * k1, *system)
    k3 = derivative(t + h / 2, y + h / 2 * k2, *system)
    k4 = derivative(t + h, y + h * k3, *system)
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def truth(y: np.ndarray, t0: float, t1: float, *system: Any) -> np.ndarray:
    """y at t1."""
    solution = solve_ivp(derivative, (t0, t1), y, method="DOP853", rtol=3e-14, atol=1e-16, args=system)
    assert solution.success, solution.message
    return np.asarray(solution.y[:, -1])


def pack(R: np.ndarray, Omega: np.ndarray, l_w: float) -> np.ndarray:
    return np.concatenate([R.ravel(), Omega, [l_w]])


def environment(p: plant.Parameters, dipole_B: np.ndarray) -> Moment:
    """Rods' and gravity-gradient moment, from the plant's orbit and field as functions of time alone."""
    J = p.J_B + p.J_error_B
    dipole_B = np.asarray(dipole_B, dtype=float)

    def moment(R: np.ndarray, t: float, Omega: np.ndarray) -> np.ndarray:
        b = R.T @ p.field.at(t)
        r = R.T @ p.orbit.position_velocity(t)[0]
        d2 = float(r @ r)
        return np.cross(dipole_B, b) + 3.0 * p.gravitational_parameter / d2**2.5 * np.cross(r, J @ r)

    return moment


def angle_between(A: np.ndarray, B: np.ndarray) -> float:
    """Angle of A^T B, rad; exact for small angles too."""
    return 2.0 * float(np.arcsin(min(np.linalg.norm(A - B) / np.sqrt(8.0), 1.0)))
