"""The ranges of inputs: samples of each, and the bound over each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ..samples import random_rotations
from . import exact, operations
from .bound import Bound, Bounds, Doubles, octaves
from .flight_code import FlightCode

Table = dict[str, list[Any]]
SKEW = 1.5e-5
"""Of each element of a rotation matrix: R^T R - I stays below the 1e-4 that the blocks accept."""


def _rotations(rng: np.random.Generator, n: int) -> Any:
    return random_rotations(rng, n) + rng.uniform(-SKEW, SKEW, (n, 3, 3))


def _directions(rng: np.random.Generator, n: int) -> Any:
    v = rng.standard_normal((n, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


def _spread(rng: np.random.Generator, n: int, low: float, high: float) -> Any:
    """Evenly in the logarithm."""
    return np.exp(rng.uniform(math.log(low), math.log(high), n))


@dataclass(frozen=True)
class OfController:
    """A range of the controller's inputs, in SI units."""

    title: str
    r: tuple[float, float]
    v: tuple[float, float]
    sine: float
    """Least sine of the angle between position and velocity."""
    rate: float
    """Largest |element| of a rate, and of a reference's dOmega_ref in rad/s2."""
    given: bool = False
    """Whether a reference is connected."""
    changes: tuple[dict[str, Any], ...] = tuple({"phi": phi} for phi in ("linear", "logarithm", "square_root"))
    block = "controller"

    def samples(self, code: FlightCode, n: int, rng: np.random.Generator) -> Any:
        u = code.inputs(n)
        towards, other = _directions(rng, n), _directions(rng, n)
        normal = np.cross(towards, other)
        across = np.cross(normal / np.linalg.norm(normal, axis=1)[:, None], towards)
        sine = _spread(rng, n, 1.01 * self.sine, 1.0)
        along = np.sqrt(1.0 - np.minimum(sine, 1.0) ** 2) * rng.choice([-1.0, 1.0], n)
        u["r_N"] = towards * _spread(rng, n, *self.r)[:, None]
        u["v_N"] = (across * sine[:, None] + towards * along[:, None]) * _spread(rng, n, *self.v)[:, None]
        u["omega_B"] = _spread(rng, n, 1e-6, self.rate)[:, None] * rng.uniform(-1.0, 1.0, (n, 3))
        wanted = operations.lvlh(_PLAIN, u["r_N"].T, u["v_N"].T, self.r, self.v, self.sine)[0]
        desired: Any = np.moveaxis(np.array(wanted), -1, 0)
        if self.given:
            desired = u["R_ref"] = _rotations(rng, n)
            u["Omega_ref"] = _spread(rng, n, 1e-6, self.rate)[:, None] * rng.uniform(-1.0, 1.0, (n, 3))
            u["dOmega_ref"] = _spread(rng, n, 1e-9, self.rate)[:, None] * rng.uniform(-1.0, 1.0, (n, 3))
        # Any attitude, and some next to the desired one or to half a turn away from it.
        small = _spread(rng, n, 1e-12, 1e-2)
        angle = np.choose(rng.integers(0, 3, n), [rng.uniform(0.0, math.pi, n), small, math.pi - small])
        turn = Rotation.from_rotvec(angle[:, None] * _directions(rng, n)).as_matrix()
        u["R_NB"] = desired @ turn + (rng.uniform(-SKEW, SKEW, (n, 3, 3)) if not self.given else 0.0)
        return u

    def _of(self, a: Any, p: Any, u: Any, first: Any, span: Any) -> Table:
        R_d = self._desired(a, u, span)
        e = operations.errors(a, u.R_NB, u.omega_B, R_d)
        e_0 = operations.errors(a, first.R_NB, first.omega_B, self._desired(a, first, span))
        latched = (e_0[1], a.norm(e_0[2]))
        return operations.controller(a, p, u.R_NB, u.omega_B, u.r_N, span[0], e, latched)

    def _desired(self, a: Any, u: Any, span: Any) -> Any:
        if self.given:
            return u.R_ref, u.Omega_ref, u.dOmega_ref
        r, v = span
        return operations.lvlh(a, u.r_N, u.v_N, r, v, self.sine)

    def bound(self, p: Any) -> Table:
        one = [[Bound(1.0001)] * 3] * 3
        rate = [Bound(self.rate)] * 3
        tables = None
        for r in octaves(*self.r):
            for v in [self.v] if self.given else octaves(*self.v):
                u = SimpleNamespace(R_NB=one, omega_B=rate, r_N=[Bound(r[1])] * 3, v_N=[Bound(v[1])] * 3)
                u.R_ref, u.Omega_ref, u.dOmega_ref = one, rate, rate
                table = self._of(Bounds, p, u, u, (r, v))
                tables = table if tables is None else larger_table(tables, table)
        assert tables is not None
        return tables

    def doubles(self, a: Doubles, p: Any, u: Any) -> Table:
        now, before = (_by_element(x) for x in (u[1:], u[:-1]))
        return self._of(a, p, now, before, (self.r, self.v))

    def exact(self, p: Any, u: Any, i: int) -> Table:
        return exact.controller(p, u[i + 1], u[i])


@dataclass(frozen=True)
class OfAllocator:
    """A range of the allocator's inputs, in SI units; demands for which no command is held."""

    title: str
    B: tuple[float, float]
    b_wheel: float
    """Least |b_wheel|."""
    rate: float
    changes: tuple[dict[str, Any], ...] = ({},)
    block = "allocator"

    def samples(self, code: FlightCode, n: int, rng: np.random.Generator) -> Any:
        """Demands made of dipoles and wheel torques within the limits; some along the field, or next to it."""
        _, p = code.parameters()
        u = code.inputs(n)
        share = _spread(rng, n, 1.01 * self.b_wheel, 1.0) * rng.choice([-1.0, 1.0], n)
        about = rng.uniform(0.0, 2.0 * math.pi, n)
        rest = np.sqrt(1.0 - np.minimum(share**2, 1.0))
        b = np.column_stack((share, rest * np.cos(about), rest * np.sin(about)))  # the wheel's axis is x
        B = _spread(rng, n, 1.01 * self.B[0], 0.99 * self.B[1])
        u["b_B"] = b * B[:, None]
        u["omega_B"] = _spread(rng, n, 1e-6, self.rate)[:, None] * rng.uniform(-1.0, 1.0, (n, 3))
        u["h_w"] = rng.uniform(-0.99, 0.99, n) * p.wheel_momentum_max
        axis, U = np.asarray(p.wheel_axis), np.asarray(p.rod_axes)
        most = p.hold_fraction * rng.uniform(0.0, 1.0, n)
        dipole = rng.uniform(-1.0, 1.0, (n, 3)) * (most * p.dipole_max)[:, None]
        dh_w = rng.uniform(-1.0, 1.0, n) * most * p.wheel_torque_max
        spin = np.cross(u["omega_B"], axis) * u["h_w"][:, None]
        tau = np.cross(dipole @ U, u["b_B"]) - dh_w[:, None] * axis - spin
        # Next to the field's direction: what the basis across the field has to be taken from is small.
        beside = _spread(rng, n, 1e-14, 1.0) * np.linalg.norm(tau, axis=1)
        along = b * np.sum(tau * b, axis=1)[:, None] + beside[:, None] * np.cross(b, _directions(rng, n))
        u["tau_cmd_B"] = np.where((rng.random(n) < 0.5)[:, None], tau, along)
        return u

    def _of(self, a: Any, p: Any, u: Any, B: tuple[float, float]) -> Table:
        U = [a.direction(a.norm(row), row, 0.999) for row in p.rod_axes]
        axis = a.direction(a.norm(p.wheel_axis), p.wheel_axis, 0.999)
        law = SimpleNamespace(U=U, axis=axis, det_least=det_least(p))
        return operations.allocator(a, p, law, u.tau_cmd_B, u.b_B, u.omega_B, u.h_w, B, self.b_wheel)

    def bound(self, p: Any) -> Table:
        tables = None
        rate = [Bound(self.rate)] * 3
        for B in octaves(*self.B):
            # The most that rods and wheel can give while nothing is held.
            wheel = p.hold_fraction * p.wheel_torque_max + p.wheel_momentum_max * self.rate * math.sqrt(3.0)
            tau = [Bound(wheel + 3.0 * p.hold_fraction * p.dipole_max * B[1])] * 3
            u = SimpleNamespace(tau_cmd_B=tau, b_B=[Bound(B[1])] * 3, omega_B=rate, h_w=Bound(p.wheel_momentum_max))
            table = self._of(Bounds, p, u, B)
            tables = table if tables is None else larger_table(tables, table)
        assert tables is not None
        return tables

    def doubles(self, a: Doubles, p: Any, u: Any) -> Table:
        return self._of(a, p, _by_element(u[1:]), self.B)

    def exact(self, p: Any, u: Any, i: int) -> Table:
        return exact.allocator(p, u[i + 1])


def det_least(p: Any) -> float:
    """Of A^T A over all directions of the field: det = sum ((u_i x u_j).b)^2 (Cauchy-Binet), at least the smallest
    eigenvalue of sum (u_i x u_j)(u_i x u_j)^T; less a millionth for the rounding of this line."""
    u = np.asarray(p.rod_axes)
    w = np.array([np.cross(u[0], u[1]), np.cross(u[1], u[2]), np.cross(u[2], u[0])])
    return float(np.linalg.eigvalsh(w.T @ w)[0]) * (1.0 - 1e-6)


def larger_table(x: Table, y: Table) -> Table:
    return {name: [Bounds.larger(*pair) for pair in zip(x[name], y[name], strict=True)] for name in x}


def _by_element(u: Any) -> Any:
    """An array of structures as vectors and matrices of arrays."""
    return SimpleNamespace(**{name: np.moveaxis(u[name], 0, -1) for name in u.dtype.names})


_PLAIN = Doubles(np.arctan2, np.log1p)
_FAST = 2.07e4
"""m/s, of a velocity at the limit in each component."""
_ORBIT: dict[str, Any] = {"r": (6.5e6, 1.73e8), "v": (1e3, _FAST), "sine": 0.5, "rate": 1.0}
_ANY: dict[str, Any] = {"r": (6.3e6, 1.73e8), "v": (1e-3, _FAST), "sine": 1e-9, "rate": 100.0}
CASES: tuple[OfController | OfAllocator, ...] = (
    OfController("in orbit, reference LVLH", **_ORBIT),
    OfController("in orbit, reference connected", **_ORBIT, given=True),
    OfController("above the ground, reference LVLH", **_ANY),
    OfController("above the ground, reference connected", **_ANY, given=True),
    OfController("whole range, reference LVLH", **{**_ANY, "r": (1.0, 1.73e8)}),
    OfAllocator("in orbit", (1e-5, 1e-4), 0.01, 1.0),
    OfAllocator("whole range", (1e-12, math.sqrt(3.0) * 1e-3), 1e-9, 100.0),
)
