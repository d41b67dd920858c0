"""Attitude, rate and orbit of a run, told by the names of its signals, in an inertial frame of choice."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orchestration.errors import InputError, Place, Problem
from orchestration.rotation import quaternions

from .frames import from_N
from .instants import Instants
from .recorded import Recorded

Floats = NDArray[np.float64]
_ORTHONORMAL = 1e-4
"""How far a matrix of attitude may be from a rotation, as the blocks take it."""
_UNITS = {"rate": "rad/s", "position": "m", "velocity": "m/s"}


@dataclass(frozen=True)
class Ports:
    """The names of what a format needs; the defaults are those of the project's plant."""

    attitude: str = "plant.R_NB"
    """Matrix (3, 3), x_N = R x_B, or unit quaternion (4,), scalar first. Zeros: there is no attitude."""
    rate: str = "plant.omega_B"
    """Body rate in B, rad/s."""
    position: str = "plant.r_N"
    """m."""
    velocity: str = "plant.v_N"
    """m/s."""
    epoch: str = "plant.epoch"
    """Parameter with the UTC at t = 0, or that UTC itself."""


@dataclass(frozen=True)
class Motion:
    """The motion of one body in a frame A: EME2000, GCRF or N."""

    frame: str
    instants: Instants
    q: Floats
    """(n, 4) unit quaternion, scalar first: x_A = q x_B q*; consecutive ones on the same side."""
    rate: Floats | None
    """(n, 3) rad/s, of B relative to A, in B."""
    position: Floats | None
    """(n, 3) m, in A."""
    velocity: Floats | None
    """(n, 3) m/s, in A."""
    without: int = 0
    """Samples that were left out since they have no attitude."""

    @property
    def R(self) -> Floats:
        """(n, 3, 3), x_A = R x_B."""
        return rotations(self.q)


def epoch_of(data: Recorded, name: str) -> str:
    """Returns the UTC of t = 0: a date, or that of a parameter. Raises InputError."""
    if name[:1].isdigit():
        return name
    block, _, parameter = name.partition(".")
    value = data.parameters.get(block, {}).get(parameter)
    if not isinstance(value, str):
        raise InputError(
            Problem(
                f"the run has no parameter {name} with a date",
                remedy="--epoch 2009-08-10T00:00:00, the UTC at t = 0",
                place=Place("--epoch"),
            )
        )
    return value


def motion(data: Recorded, frame: str, ports: Ports) -> Motion:
    """Returns the motion of a run in a frame. Raises InputError where a port is missing or is no attitude."""
    values = data.signal(ports.attitude, "--attitude")
    if values.shape[1:] == (4,):
        values = rotations(values / np.maximum(np.linalg.norm(values, axis=1, keepdims=True), 1e-300))
    if values.shape[1:] != (3, 3):
        expected, found = "a matrix (3, 3) or a quaternion (4,)", f"the shape {values.shape[1:]}"
        raise InputError(Problem(expected=expected, found=found, place=Place("--attitude", name=ports.attitude)))
    apart = np.abs(values @ values.swapaxes(1, 2) - np.eye(3)).max(axis=(1, 2))
    kept = (apart <= _ORTHONORMAL) & (np.diff(data.time, prepend=-np.inf) > 0.0)
    if not kept.any():
        found = "no sample with a rotation"
        raise InputError(Problem(expected="attitude", found=found, place=Place("--attitude", name=ports.attitude)))
    instants = Instants(epoch_of(data, ports.epoch), data.time[kept], "--epoch")
    turn = from_N(frame, instants.tt0)
    default = Ports()

    def vector(option: str) -> Floats | None:
        name = getattr(ports, option)
        if name == getattr(default, option) and name not in data.signals:
            return None  # a default that is not there is left out; what a user names must be there
        found = data.signal(name, f"--{option}")
        if found.shape[1:] != (3,):
            expected = "a vector of three elements"
            shape = f"the shape {found.shape[1:]}"
            raise InputError(Problem(expected=expected, found=shape, place=Place(f"--{option}", name=name)))
        if (unit := data.units.get(name, _UNITS[option])) != _UNITS[option]:
            place = Place(f"--{option}", name=name)
            raise InputError(Problem(expected=f"the unit {_UNITS[option]}", found=unit, place=place))
        return found[kept]

    position, velocity = vector("position"), vector("velocity")
    return Motion(
        frame=frame,
        instants=instants,
        q=quaternions((turn @ values[kept]).reshape(-1, 9)),
        rate=vector("rate"),
        position=None if position is None else position @ turn.T,
        velocity=None if velocity is None else velocity @ turn.T,
        without=int((apart > _ORTHONORMAL).sum()),
    )


def rotations(q: Floats) -> Floats:
    """Returns the matrices (n, 3, 3) of unit quaternions (n, 4), scalar first."""
    w, x, y, z = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def angles(a: Floats, b: Floats) -> Floats:
    """Returns the angles (n,) rad between two courses of unit quaternions; exact also where they are small."""
    apart = np.minimum(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return 4.0 * np.arcsin(np.minimum(apart / 2.0, 1.0))


def resampled(at: Floats, time: Floats, q: Floats) -> Floats:
    """Returns the quaternions (m, 4) at instants within those of a course, by SLERP between neighbours."""
    right = np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    left = right - 1
    share = ((at - time[left]) / (time[right] - time[left]))[:, None]
    a, b = q[left], q[right]
    b = b * np.where((a * b).sum(axis=1, keepdims=True) < 0.0, -1.0, 1.0)
    half = angles(a, b)[:, None] / 2.0
    small = half < 1e-7
    sine = np.where(small, 1.0, np.sin(half))
    first = np.where(small, 1.0 - share, np.sin((1.0 - share) * half) / sine)
    second = np.where(small, share, np.sin(share * half) / sine)
    found = first * a + second * b
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def in_frame(reference: Motion, frame: str) -> Motion:
    """Returns the same attitude in another frame; rates in B stay."""
    turn = from_N(frame, reference.instants.tt0) @ from_N(reference.frame, reference.instants.tt0).T
    return replace(
        reference, frame=frame, q=quaternions((turn @ reference.R).reshape(-1, 9)), position=None, velocity=None
    )
