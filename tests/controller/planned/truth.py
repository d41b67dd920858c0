"""A satellite for the controller to measure: the equations of motion flown by SciPy, apart from the plant and from the
C."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from . import core, motion

Array = NDArray[np.float64]
RADIUS = 6.971e6
SPEED = math.sqrt(core.MU / RADIUS)
NORMAL = np.array([0.0, -math.cos(math.radians(8.0)), -math.sin(math.radians(8.0))])
"""Of a circular orbit of 98 degrees inclination through the x axis."""
E_X = np.array([1.0, 0.0, 0.0])
ALONG = np.cross(NORMAL, E_X)
DAYS = 3508.5  # 2009-08-10T00:00:00Z


def orbit(t: float) -> tuple[Array, Array]:
    angle = SPEED / RADIUS * t
    c, s = math.cos(angle), math.sin(angle)
    return RADIUS * (c * E_X + s * ALONG), SPEED * (c * ALONG - s * E_X)


def turned(z: Array) -> Array:
    """The rotation (3, 3) about z (3,) by its length, rad: Rodrigues' formula. SciPy's takes thirty times as long."""
    a = float(np.linalg.norm(z))
    s, c = (math.sin(a) / a, (1.0 - math.cos(a)) / (a * a)) if a > 1e-4 else (1.0 - a * a / 6.0, 0.5 - a * a / 24.0)
    x, y, z_ = z.tolist()
    Z = np.array(((0.0, -z_, y), (z_, 0.0, -x), (-y, x, 0.0)))
    turn: Array = np.eye(3) + s * Z + c * (Z @ Z)
    return turn


@dataclass
class Truth:
    """J (3, 3) kg m2; rods (3, 3): rows, dipole for a control of 1, A m2; the state follows."""

    J: Array
    rods: Array
    d_B: Array = field(default_factory=lambda: np.zeros(3))
    R: Array = field(default_factory=lambda: np.eye(3))
    Omega: Array = field(default_factory=lambda: np.zeros(3))
    h_w: float = 0.0
    own_dipole: Array = field(default_factory=lambda: np.zeros(3))
    t: float = 0.0

    def field_N(self, t: float) -> Array:
        return core.field_at("igrf14", DAYS, 10, orbit(t)[0], t)

    def fly(self, u: Array, dl: float, h: float) -> None:
        """On by h under rods' controls u (3,) and motor dl, N m."""
        r = orbit(self.t + 0.5 * h)[0]
        s = motion.Surroundings(self.J, self.field_N(self.t + 0.5 * h), r / RADIUS, core.MU / RADIUS**3, self.d_B)
        m_B, start = u @ self.rods + self.own_dipole, self.R

        def rates(t: float, y: Array) -> list[float]:
            R = start @ turned(y[:3])
            w, z = y[3:6], y[:3]
            a = float(np.linalg.norm(z))
            bend = 1.0 / 12.0 if a < 1e-4 else (1.0 - 0.5 * a / math.tan(0.5 * a)) / (a * a)
            zw = motion.cross(z, w)
            dz = w + 0.5 * zw + bend * motion.cross(z, zw)
            return [*dz, *motion.rate_of_change(s, R, w, y[6], m_B, dl), dl]

        end = solve_ivp(rates, (0.0, h), [0.0, 0.0, 0.0, *self.Omega, self.h_w], rtol=1e-7, atol=1e-10, first_step=h).y[
            :, -1
        ]
        self.R = Rotation.from_matrix(start @ turned(end[:3])).as_matrix()  # which makes it a rotation again
        self.Omega, self.h_w, self.t = end[3:6], float(end[6]), self.t + h

    def measured(self, rng: np.random.Generator | None = None, rate_noise: float = 0.0) -> dict[str, Any]:
        """The controller's inputs but for u_applied."""
        r, v = orbit(self.t)
        noise = rng.normal(size=3) * rate_noise if rng is not None else np.zeros(3)
        return {
            "R_NB": self.R,
            "omega_B": self.Omega + noise,
            "r_N": r,
            "v_N": v,
            "h_w": self.h_w,
            "b_B": self.R.T @ self.field_N(self.t),
        }
