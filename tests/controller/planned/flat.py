"""What the planned controller's C functions take and give: numpy arrays and dataclasses as flat C structures."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_double, c_int32
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

MU = 3.986004418e14
U3 = 1.0 / np.sqrt(3.0)
RODS = np.array([[U3, U3, -U3], [U3, -U3, U3], [0.0, 0.0, 1.0]])

Array = NDArray[np.float64]


def doubles(x: ArrayLike) -> Any:
    """A C array of the values. Keep it while C uses it."""
    flat = np.ravel(np.asarray(x, float))
    return (c_double * flat.size)(*flat)


def room_for(*shape: int) -> tuple[Any, Any]:
    """A C array to be written to, and its values in this shape."""
    room = (c_double * int(np.prod(shape)))()
    return room, lambda: np.array(room).reshape(shape)


class FlatModel(ctypes.Structure):
    _fields_ = (
        *((name, c_double * 9) for name in ("J", "rods")),
        ("wheel_axis", c_double * 3),
        *((name, c_double) for name in ("wheel_torque_max", "wheel_momentum_max")),
        *((name, c_double * 3) for name in ("disturbance_B", "residual_B")),
        *((name, c_double) for name in ("dipole_max", "semi_major_axis")),
    )


class FlatAround(ctypes.Structure):
    _fields_ = (("B_N", c_double * 3), ("r_hat_N", c_double * 3), ("rate_squared", c_double))


class FlatMotion(ctypes.Structure):
    _fields_ = (("R", c_double * 9), ("Omega", c_double * 3), ("h_w", c_double))


class FlatAhead(ctypes.Structure):
    _fields_ = (
        *((name, c_double) for name in ("t", "mu")),
        *((name, c_double * 3) for name in ("r_N", "v_N")),
        ("days", c_double),
        ("bias_N", c_double * 3),
        ("bias_t", c_double),
        ("R_d0", c_double * 9),
        *((name, c_int32) for name in ("model", "degree", "target")),
    )


class _Flat:
    """What is given to C as a structure whose fields have the names of its attributes."""

    _structure: ClassVar[type[ctypes.Structure]]

    def c(self) -> Any:
        values = {name: getattr(self, name) for name, *_ in self._structure._fields_}
        flat = {name: doubles(v) if np.ndim(v) else v for name, v in values.items()}
        return byref(self._structure(**flat))


@dataclass(frozen=True)
class Satellite(_Flat):
    """J (3, 3) kg m2, rods (3, 3): rows, dipoles at the limit, A m2; N m; N m s; N m; A m2."""

    _structure = FlatModel
    J: Array = field(default_factory=lambda: np.diag([2.13, 3.04, 3.09]))
    rods: Array = field(default_factory=lambda: 25.0 * RODS)
    wheel_axis: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    wheel_torque_max: float = 3e-3
    wheel_momentum_max: float = 0.03
    disturbance_B: Array = field(default_factory=lambda: np.zeros(3))
    residual_B: Array = field(default_factory=lambda: np.zeros(3))
    dipole_max: float = 25.0
    """From which, with J and the orbit, the units of the plan follow."""
    semi_major_axis: float = 6971e3


@dataclass(frozen=True)
class Around(_Flat):
    """B_N (3,) T, r_hat_N (3,), rate_squared 1/s2."""

    _structure = FlatAround
    B_N: Array
    r_hat_N: Array
    rate_squared: float


@dataclass(frozen=True)
class Motion(_Flat):
    """R (3, 3) N from B, Omega (3,) rad/s, h_w N m s."""

    _structure = FlatMotion
    R: Array
    Omega: Array
    h_w: float

    @staticmethod
    def of(m: Any) -> Motion:
        return Motion(np.array(m.R).reshape(3, 3), np.array(m.Omega), float(m.h_w))


@dataclass(frozen=True)
class Ahead(_Flat):
    """Orbit through r_N, v_N at t, field of a model on a day; target 1: LVLH, 2: R_d0 at rest."""

    _structure = FlatAhead
    r_N: Array
    v_N: Array
    t: float = 0.0
    days: float = 3508.5
    model: int = 1
    degree: int = 10
    target: int = 1
    R_d0: Array = field(default_factory=lambda: np.eye(3))
    bias_N: Array = field(default_factory=lambda: np.zeros(3))
    mu: float = MU

    @property
    def bias_t(self) -> float:
        """When the bias was measured, s."""
        return self.t
