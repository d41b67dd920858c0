"""Attitude by a bank of filters side by side: field, gyro and photodiode currents, with the gyro's scale as a state.

Field and gyro alone cannot always tell a spin from its mirror image: seen from the field, which moves nearly in a
plane, both fit, with gyro scales that differ by little. One filter then settles in either, with quiet innovations. So
the bank starts from all turns about the field, each filter has a score (its log-likelihood), and the attitude is
ambiguous as long as one that is far from the best is nearly as likely.

The error state of each filter is (turn in B, gyro bias, gyro scale); multiplicative, as that of the estimator
(Lefferts, Markley and Shuster, 1982). All arrays begin with the filter's number. Tests: tests/inflight/test_bank.py.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

EARTH_RADIUS = 6378137.0


@dataclass(frozen=True)
class Noise:
    """Standard deviations, all fixed before a record is looked at."""

    field: float = 1.5e-6
    """T, of a component: calibration, field model and the instants of the samples together"""
    angle: float = 2.0e-3
    """rad in 1 s, by the noise of the gyro"""
    bias_walk: float = 1e-6
    """rad/s in 1 s"""
    bias: float = 0.03
    """rad/s, at the start"""
    scale: float = 0.01
    """At the start: the prior on the gyro's scale"""
    light: float = 0.12
    """Of a current, as part of that of the Sun at normal incidence"""
    gate: float = 30.0
    """Innovations beyond this are not used, and count as this in the score"""


@dataclass(frozen=True)
class Faces:
    """Photodiodes: outward normals (m,3) in B, the current of the Sun at normal incidence, and that of the Earth's
    light."""

    normals: Floats
    full: Floats
    """(m,)"""
    albedo: float = 0.3
    """Part of the light that the Earth throws back"""


@dataclass
class Bank:
    """Filters side by side: attitudes R (k,3,3), N from B, biases and scales (k,3), covariances (k,9,9), scores
    (k,)."""

    R: Floats
    bias: Floats
    scale: Floats
    P: Floats
    score: Floats
    count: int = 0
    """Measurements that the scores hold."""
    rejected: Floats = field(default_factory=lambda: np.zeros(0))
    rate: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def best(self) -> int:
        """The number of the most likely filter."""
        return int(np.argmax(self.score))

    def angles(self) -> Floats:
        """(k,) rad from the best one's attitude."""
        trace = np.einsum("ij,kij->k", self.R[self.best], self.R)
        return np.asarray(np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0)))

    def pruned(self, margin: float, angle: float) -> None:
        """Takes out filters whose score is `margin` below the best, and of those within `angle`, rad, all but the
        better."""
        keep: list[int] = []
        for k in np.argsort(-self.score):
            far = [float(np.trace(self.R[j].T @ self.R[k])) < 1.0 + 2.0 * np.cos(angle) for j in keep]
            if self.score[k] > self.score[self.best] - margin and all(far):
                keep.append(int(k))
        for name in ("R", "bias", "scale", "P", "score", "rejected"):
            setattr(self, name, getattr(self, name)[keep])

    def ambiguity(self, margin: float) -> float:
        """Returns the largest angle, rad, from the best attitude to one whose score is less than `margin` below."""
        return float(self.angles()[self.score > self.score[self.best] - margin].max())


def started(b_B: Floats, B_N: Floats, noise: Noise, turns: int = 12, scales: int = 7) -> Bank:
    """A bank of turns about the field (3,), evenly spread, each with gyro scales spread over twice the prior's
    deviation.

    A spin that is off by a per cent leaves the attitude within minutes, so the scale is spread as the turn is.
    """
    first_B, first_N = _frame(b_B / np.linalg.norm(b_B)), _frame(B_N / np.linalg.norm(B_N))
    angle = np.repeat(2.0 * np.pi * np.arange(turns) / turns, scales)
    off = np.tile(noise.scale * np.linspace(-2.0, 2.0, scales) if scales > 1 else np.zeros(1), turns)
    about = exp(np.outer(angle, np.array([0.0, 0.0, 1.0])))
    R = first_N @ about @ first_B.T
    along = first_B[:, 2:] @ first_B[:, 2:].T
    P = np.zeros((len(angle), 9, 9))
    P[:, :3, :3] = (np.pi / turns) ** 2 * along + 0.1**2 * (np.eye(3) - along)
    P[:, [3, 4, 5], [3, 4, 5]] = noise.bias**2
    P[:, [6, 7, 8], [6, 7, 8]] = noise.scale**2
    score = -0.5 * (off / noise.scale) ** 2
    return Bank(R, np.zeros((len(angle), 3)), np.repeat(off[:, None], 3, 1), P, score, rejected=np.zeros(len(angle)))


def propagate(x: Bank, before: Floats, now: Floats, h: float, noise: Noise) -> None:
    """Over h s, between measured rates (3,) or (k,3), rad/s, at its ends."""
    rate = (before - x.bias) / (1.0 + x.scale)
    after = (now - x.bias) / (1.0 + x.scale)
    turn = 0.5 * h * (rate + after) + h * h / 12.0 * np.cross(rate, after)
    middle = 0.5 * (rate + after)
    step = exp(turn)
    x.R = x.R @ step
    x.rate = after
    Jr = right_jacobian(turn)
    F = np.zeros_like(x.P)
    F[:, range(9), range(9)] = 1.0
    F[:, :3, :3] = step.transpose(0, 2, 1)
    F[:, :3, 3:6] = -h * Jr
    F[:, :3, 6:] = -h * Jr * middle[:, None, :]
    x.P = F @ x.P @ F.transpose(0, 2, 1)
    x.P[:, [0, 1, 2], [0, 1, 2]] += noise.angle**2 * h
    x.P[:, [3, 4, 5], [3, 4, 5]] += noise.bias_walk**2 * h


def by_field(x: Bank, b_B: Floats, B_N: Floats, noise: Noise) -> None:
    """With the measured field (3,) or (k,3), T, and that of the model, in N."""
    b = np.einsum("kji,...j->ki", x.R, B_N) if B_N.ndim == 1 else np.einsum("kji,kj->ki", x.R, B_N)
    _corrected(x, b_B - b, _hat(b), np.full(3, noise.field**2), noise.gate)


def by_light(x: Bank, currents: Floats, faces: Faces, sun_N: Floats, r_N: Floats, noise: Noise) -> None:
    """With currents (m,) in sunlight: each is full (max(0, n.s) + Earth's light), a scalar at a time."""
    s = np.einsum("kji,j->ki", x.R, sun_N)
    size = float(np.linalg.norm(r_N))
    nadir = np.einsum("kji,j->ki", x.R, -r_N / size)
    lit = faces.albedo * (EARTH_RADIUS / size) ** 2 * max(0.0, float(r_N @ sun_N) / size)
    for n, full, current in zip(faces.normals, faces.full, currents, strict=True):
        cosine, down = s @ n, nadir @ n
        seen = cosine > 0.0
        expected = np.where(seen, cosine, 0.0) + lit * (0.5 * (1.0 + down)) ** 2
        slope = np.where(seen[:, None], np.cross(n, s), 0.0) + (lit * 0.5 * (1.0 + down))[:, None] * np.cross(n, nadir)
        _corrected(x, (current / full - expected)[:, None], slope[:, None, :], np.array([noise.light**2]), noise.gate)


def _corrected(x: Bank, y: Floats, H: Floats, variance: Floats, gate: float) -> None:
    """With an innovation (k,m) of slope (k,m,3) by the turn; beyond the gate it only counts in the score."""
    PH = x.P[:, :, :3] @ H.transpose(0, 2, 1)
    S = H @ PH[:, :3] + np.diag(variance)
    inverse = np.linalg.inv(S)
    nis = np.einsum("ki,kij,kj->k", y, inverse, y)
    use = nis <= gate
    x.score -= 0.5 * (np.minimum(nis, gate) + np.log(np.linalg.det(S / variance[0])))
    x.count += 1
    x.rejected = x.rejected + ~use
    K = PH @ inverse * use[:, None, None]
    change = np.einsum("kij,kj->ki", K, y)
    x.P -= K @ PH.transpose(0, 2, 1)
    x.P = 0.5 * (x.P + x.P.transpose(0, 2, 1))
    x.R = x.R @ exp(change[:, :3])
    x.bias = x.bias + change[:, 3:6]
    x.scale = x.scale + change[:, 6:]


def exp(v: Floats) -> Floats:
    """(k,3,3) rotations by the vectors (k,3), rad."""
    angle = np.linalg.norm(v, axis=1)[:, None, None]
    safe = np.maximum(angle, 1e-9)
    hat = _hat(v)
    return np.asarray(np.eye(3) + np.sin(safe) / safe * hat + (1.0 - np.cos(safe)) / safe**2 * hat @ hat)


def right_jacobian(v: Floats) -> Floats:
    """(k,3,3): exp(v + d) is exp(v) exp(J d) to first order in d."""
    angle = np.maximum(np.linalg.norm(v, axis=1)[:, None, None], 1e-4)
    hat = _hat(v)
    return np.asarray(
        np.eye(3) - (1.0 - np.cos(angle)) / angle**2 * hat + (angle - np.sin(angle)) / angle**3 * hat @ hat
    )


def _hat(v: Floats) -> Floats:
    """(k,3,3): hat(v) w is v x w."""
    hat = np.zeros((len(v), 3, 3))
    hat[:, 0, 1], hat[:, 0, 2], hat[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    return hat - hat.transpose(0, 2, 1)


def _frame(z: Floats) -> Floats:
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x = x / np.linalg.norm(x)
    return np.column_stack((x, np.cross(z, x), z))
