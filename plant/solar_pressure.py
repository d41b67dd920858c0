"""Moment of sunlight on a body of flat plates. Not in the paper.

Each plate that faces the Sun absorbs a part of the light, and reflects parts as a mirror and as a matt surface does:

    F_i = -p A_i max(0, n_i.s) [(1 - specular) s + 2 (specular n_i.s + diffuse/3) n_i],    M = sum (r_i - c) x F_i

with s the unit vector to the Sun, p the pressure of absorbed light at its distance times the part of its disc that the
Earth leaves visible, and plates as in drag.py (Wertz, Spacecraft Attitude Determination and Control, 17.2.2).
"""

from __future__ import annotations

import numpy as np

from .drag import Plates
from .so3 import Array
from .sun import AU

PRESSURE = 1361.0 / 299792458.0
"""N/m2, one astronomical unit from the Sun: the nominal total solar irradiance (IAU 2015 resolution B3) over c."""


def at_distance(distance: float) -> float:
    """The pressure p, N/m2, at a distance, m, from the Sun."""
    return PRESSURE * (AU / distance) ** 2


class SolarPressure:
    """Moment on plates about a centre of mass (3,), m from the geometric centre."""

    def __init__(self, plates: Plates, center_of_mass_B: Array, specular: float, diffuse: float) -> None:
        """specular, diffuse: the parts of the light that are reflected so; the rest is absorbed."""
        self.plates, self.specular, self.diffuse = plates, specular, diffuse
        self.arms = plates.centres - center_of_mass_B

    def moment(self, sun_B: Array, pressure: float) -> Array:
        """(3,) N m in body axes about the centre of mass; sun_B (3,) unit vector to the Sun, pressure p, N/m2."""
        lit = np.maximum(self.plates.normals @ sun_B, 0.0)
        along_sun = (1.0 - self.specular) * sun_B
        along_normal = (2.0 * self.specular * lit + 2.0 / 3.0 * self.diffuse)[:, None] * self.plates.normals
        forces = -pressure * (self.plates.areas * lit)[:, None] * (along_sun + along_normal)
        return np.asarray(np.cross(self.arms, forces).sum(axis=0))
