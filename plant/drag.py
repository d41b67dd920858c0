"""Aerodynamic moment of a body of flat plates in free molecular flow.

The molecules' mean free path at orbital heights is far beyond the body's size, and their thermal speed far
below orbital speed, so each plate that faces the flow takes the momentum of what strikes it:

    F_i = -1/2 rho C_d A_i max(0, v.n_i) v,        M = sum (r_i - c) x F_i

with v the velocity relative to the air, n_i the outward normal, r_i the plate's pressure centre and c the
centre of mass. Plates do not shade each other, as those of a convex body never do. The part of v from the
body's own rotation, Omega x r, is left out: 0.1 m/s of 7500, so the moment depends on R and t only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .so3 import Array

AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Plates:
    """Outward unit normals (n,3), areas (n,) m2 and pressure centres (n,3) m, in body axes from the geometric
    centre."""

    normals: Array
    areas: Array
    centres: Array


def octagonal_cylinder(width: float, length: float, axis: str) -> Plates:
    """Eight sides and two ends; width across the flats, length along the body axis "x", "y" or "z", m.

    The normals of four sides lie along the two other body axes.
    """
    turn = math.pi / 4.0 * np.arange(8)
    sides = np.column_stack((np.zeros(8), np.cos(turn), np.sin(turn)))
    ends = np.array(((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)))
    edge = (math.sqrt(2.0) - 1.0) * width
    # From (along, across, across) to body axes, keeping their cyclic order.
    normals = np.roll(np.vstack((sides, ends)), AXES.index(axis), axis=1)
    areas = np.array(8 * [edge * length] + 2 * [2.0 * edge * width])
    distances = np.array(8 * [0.5 * width] + 2 * [0.5 * length])
    return Plates(normals, areas, distances[:, None] * normals)


class Drag:
    """Moment on plates about a centre of mass (3,), m from the geometric centre.

    `normals` (n,3) are those of the plates, `arms` (n,3), m3, their lever arms times 1/2 C_d A.
    """

    def __init__(self, plates: Plates, center_of_mass_B: Array, coefficient: float) -> None:
        """coefficient: C_d, with any factor on the moment."""
        self.normals = plates.normals
        self.arms = (0.5 * coefficient * plates.areas)[:, None] * (plates.centres - center_of_mass_B)

    def moment(self, v_B: Array, density: float) -> Array:
        """(3,) N m in body axes about the centre of mass; v_B (3,) m/s relative to the air, density kg/m3."""
        a, b, c = np.maximum(self.normals.dot(v_B), 0.0).dot(self.arms).tolist()
        x, y, z = (-density * v_B).tolist()
        return np.array((b * z - c * y, c * x - a * z, a * y - b * x))
