"""Parameters of the bounded allocator, their check, and what follows from them alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .allocation import INDEPENDENT_MIN, null_space
from .box import Array

OfWheels = Any
"""A number for one wheel, an array (4,) for a set of them."""
UNIT_TOLERANCE = 1e-6
"""max ||u| - 1| of the axes of rods and wheel."""
ROD_LIMIT_MIN = 0.01
ROD_WEIGHT_MIN = 1e-8
"""T. Below it the preference along the field would drown in rounding."""
WHEEL_WEIGHT_MIN = 1e-4
"""Of several wheels; below it, their null space would drown in rounding."""


@dataclass(frozen=True)
class Parameters:
    """rod_axes (3, 3) by rows, wheel_axis (3,), or (4, 3) of a set. Units, frames and limits are those of
    fmus/interfaces/allocator_bounded.toml."""

    rod_axes: Array
    dipole_max: float
    rod_limits: Array
    wheel_axis: Array
    wheel_torque_max: OfWheels
    wheel_momentum_max: OfWheels
    command_period: float
    desaturation_time: float
    rod_weight: float
    wheel_weight: float
    wheel_weight_ff: float
    wheels: int = 1
    """How many of a set are there, and of the rods."""
    rods: int = 3
    wheel_momentum_target: OfWheels = 0.0
    null_space_momentum: float = 0.0
    J_B: Array | None = None
    """Of a set: (3, 3), or zeros where it is not known. The native flavour alone looks at it."""
    find_failures: bool = False

    @property
    def is_set(self) -> bool:
        """Returns whether the block is that for a set of wheels."""
        return self.wheel_axis.ndim == 2

    def of_wheels(self, value: OfWheels) -> Array:
        """A parameter or an input of the wheels that are there, (wheels,)."""
        return np.atleast_1d(np.asarray(value, np.float64))[: self.wheels]

    @cached_property
    def U(self) -> Array:
        """(rods,3): rod_axes with unit rows, of the rods that are there."""
        axes = self.rod_axes[: self.rods]
        return axes / np.linalg.norm(axes, axis=1, keepdims=True)

    @cached_property
    def axes(self) -> Array:
        """(wheels,3): unit axes of the wheels that are there; for one wheel the paper's e1."""
        axes = np.atleast_2d(self.wheel_axis)[: self.wheels]
        return axes / np.linalg.norm(axes, axis=1, keepdims=True)

    @cached_property
    def null_space(self) -> Array | None:
        """(4,): torques of four wheels that cancel on the body."""
        return null_space(self.axes)


def check(p: Parameters) -> None:
    """Raises ValueError for parameters that the allocation cannot work with."""
    for name, count, most in (
        ("rods", p.rods, len(p.rod_axes)),
        ("wheels", p.wheels, len(np.atleast_2d(p.wheel_axis))),
    ):
        if not 0 <= count <= most:
            raise ValueError(f"{name}: expected 0 to {most}, found {count}")
    _check_rods(p.rod_axes[: p.rods])
    _check_wheels(p)
    for name in ("dipole_max", "command_period", "desaturation_time"):
        if not 0.0 < (value := getattr(p, name)) < math.inf:
            raise ValueError(f"{name}: expected a finite number above 0, found {value!r}")
    if not ((p.rod_limits >= ROD_LIMIT_MIN) & (p.rod_limits <= 1.0)).all():
        raise ValueError(f"rod_limits: expected {ROD_LIMIT_MIN:g} to 1, found {p.rod_limits.tolist()}")
    if p.J_B is not None and p.J_B.any():
        moments = np.linalg.eigvalsh(p.J_B) if np.isfinite(p.J_B).all() else np.zeros(3)
        symmetric = np.abs(p.J_B - p.J_B.T).max() <= 1e-9 * np.abs(p.J_B).max()
        if not (symmetric and moments[0] > 0.0 and moments[2] <= (moments[0] + moments[1]) * (1.0 + 1e-9)):
            raise ValueError(f"J_B: expected the inertia of a body, or zeros, found {p.J_B.tolist()}")
    wheel_weight_min = WHEEL_WEIGHT_MIN if p.wheels > 1 else 0.0
    for name, least in (
        ("rod_weight", ROD_WEIGHT_MIN),
        ("wheel_weight", wheel_weight_min),
        ("wheel_weight_ff", wheel_weight_min),
    ):
        if not least <= (value := getattr(p, name)) < math.inf:
            raise ValueError(f"{name}: expected a finite number of at least {least:g}, found {value!r}")


def _check_rods(rod_axes: Array) -> None:
    """Raises ValueError for axes (n,3) that are not of unit length, or three of them in one plane."""
    if not np.isfinite(rod_axes).all():
        raise ValueError(f"rod_axes: expected finite numbers, found {rod_axes.tolist()}")
    for i, length in enumerate(np.linalg.norm(rod_axes, axis=1).tolist(), start=1):
        if abs(length - 1.0) > UNIT_TOLERANCE:
            raise ValueError(
                f"rod_axes: expected rows of unit length to {UNIT_TOLERANCE:g}, "
                f"found |u{i}| = {length:.9g}: {rod_axes.tolist()}"
            )
    if len(rod_axes) == 3 and not abs(volume := float(np.linalg.det(rod_axes))) > INDEPENDENT_MIN:
        raise ValueError(
            f"rod_axes: expected linearly independent axes, |det| above {INDEPENDENT_MIN:g}, "
            f"found {volume:.3g}: {rod_axes.tolist()}"
        )


def _check_wheels(p: Parameters) -> None:
    for i, axis in enumerate(np.atleast_2d(p.wheel_axis)[: p.wheels]):
        of = f"[{i + 1}]" if p.is_set else ""
        if not abs((length := float(np.linalg.norm(axis))) - 1.0) <= UNIT_TOLERANCE:
            raise ValueError(
                f"wheel_axis{of}: expected a vector of unit length to {UNIT_TOLERANCE:g}, found {length:.9g}: "
                f"{axis.tolist()}"
            )
        for name in ("wheel_torque_max", "wheel_momentum_max"):
            if not 0.0 < (value := float(p.of_wheels(getattr(p, name))[i])) < math.inf:
                raise ValueError(f"{name}{of}: expected a finite number above 0, found {value!r}")
        most = float(p.of_wheels(p.wheel_momentum_max)[i])
        if p.is_set and not abs(target := float(p.of_wheels(p.wheel_momentum_target)[i])) <= most:
            raise ValueError(f"wheel_momentum_target{of}: expected within wheel_momentum_max, found {target!r}")
        if not 2.0 * p.null_space_momentum <= most:
            found = p.null_space_momentum
            raise ValueError(f"null_space_momentum: expected at most half of wheel_momentum_max{of}, found {found!r}")
