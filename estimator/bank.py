"""Attitude by a bank of filters side by side: field, gyro and photodiode currents, with the gyro's scale as a state.

Field and gyro alone cannot always tell a spin from its mirror image: seen from the field, which moves nearly in a
plane, both fit, with gyro scales that differ by little. One filter then settles in either, with quiet innovations. So
the bank starts from all turns about the field, each filter has a score (its log-likelihood), and the attitude is
ambiguous as long as one that is far from the best is nearly as likely.

The error state of each filter is (turn in B, gyro bias, field bias, gyro scale): that of the estimator (Lefferts,
Markley and Shuster, 1982), and behind it the scale. All arrays begin with the filter's number. Tests:
tests/inflight/test_bank.py, tests/estimator/test_banked.py.

Longer than 250 lines: the bank, each of its measurements, and the vectorised rotations that they need.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .so3 import log

Floats = NDArray[np.float64]

EARTH_RADIUS = 6378137.0
STATES = 12
GYRO = (3, 4, 5, 9, 10, 11)
"""Of the error state: the gyro's bias and scale."""


@dataclass(frozen=True)
class Noise:
    """Standard deviations, all fixed before a record is looked at."""

    field: float = 1.5e-6
    """T, of a component: calibration, field model and the instants of the samples together"""
    angle: float = 2.0e-3
    """rad in 1 s, by the noise of the gyro"""
    bias_walk: float = 1e-5
    """rad/s in 1 s: with its temperature along an orbit"""
    bias: float = 0.03
    """rad/s, at the start"""
    scale: float = 0.01
    """At the start: the prior on the gyro's scale"""
    light: float = 0.12
    """Of a current, as part of that of the Sun at normal incidence"""
    field_bias: float = 0.0
    """T, of the magnetometer at the start; with 0 and without a walk none is estimated"""
    field_walk: float = 0.0
    """T in 1 s"""
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
    """Filters side by side: attitudes R (k,3,3), N from B, biases of gyro and field and scales (k,3), covariances
    (k,12,12), scores (k,)."""

    R: Floats
    bias: Floats
    field_bias: Floats
    scale: Floats
    P: Floats
    score: Floats

    @property
    def best(self) -> int:
        """The number of the most likely filter; of those alike the first, so that both flavours take the same."""
        return int(np.argmax(self.score >= self.score.max() - ALIKE))

    @property
    def packed(self) -> Floats:
        """(k,163), a row for each filter."""
        k = len(self.score)
        return np.hstack(
            (self.R.reshape(k, 9), self.bias, self.field_bias, self.scale, self.P.reshape(k, -1), self.score[:, None])
        )

    @classmethod
    def unpacked(cls, rows: Floats) -> Bank:
        """The bank of which `packed` made the rows; its arrays are its own."""
        R, bias, field_bias, scale, P, score = (part.copy() for part in np.split(rows, [9, 12, 15, 18, 162], axis=1))
        return cls(R.reshape(-1, 3, 3), bias, field_bias, scale, P.reshape(-1, STATES, STATES), score[:, 0])

    def strain(self, noise: Noise) -> float:
        """Returns the largest bias or scale of the best filter, in deviations of what was known before."""
        parts = ((self.bias[self.best], noise.bias), (self.scale[self.best], noise.scale))
        return max((float(np.abs(x).max()) / sigma for x, sigma in parts if sigma > 0.0), default=0.0)

    def angles(self) -> Floats:
        """(k,) rad from the best one's attitude."""
        between = self.R[self.best].T @ self.R
        twice = [between[:, j, i] - between[:, i, j] for i, j in ((1, 2), (2, 0), (0, 1))]
        sine, cosine = 0.5 * np.linalg.norm(twice, axis=0), 0.5 * (np.trace(between, axis1=1, axis2=2) - 1.0)
        return np.asarray(np.arctan2(sine, cosine))

    def pruned(self, margin: float, angle: float) -> None:
        """Takes out filters whose score is `margin` below the best, and of those within `angle`, rad, all but the
        better."""
        keep: list[int] = []
        order = np.arange(len(self.score))
        for i in range(len(order)):
            left = self.score[order[i:]]
            following = i + int(np.argmax(left >= left.max() - ALIKE))
            order[[i, following]] = order[[following, i]]
            k = int(order[i])
            far = [float(np.trace(self.R[j].T @ self.R[k])) < 1.0 + 2.0 * np.cos(angle) for j in keep]
            if not keep or (self.score[k] > self.score[keep[0]] - margin and all(far)):
                keep.append(k)
        for name in ("R", "bias", "field_bias", "scale", "P", "score"):
            setattr(self, name, getattr(self, name)[keep])

    def ambiguity(self, margin: float) -> float:
        """Returns the largest angle, rad, from the best attitude to one whose score is less than `margin` below."""
        return float(self.angles()[self.score > self.score[self.best] - margin].max())


TURNS, SCALES = 8, 5
"""Of the filters at the start; with more of them, 12 times 7, synthetic spins end alike."""
ALIKE = 1e-6
"""Scores that are nearer than this are alike."""
PRUNE_EVERY, PRUNE_MARGIN, PRUNE_ANGLE = 20, 80.0, np.radians(3.0)
"""Measurements of the field; of the log-likelihood; rad between attitudes that count as one."""
MARGIN = 10.0
"""Of the log-likelihood: a filter that is less likely by this is excluded, one in 20,000."""
UNIQUE = np.radians(10.0)
"""The attitude is unique where no filter within the margin is farther off."""
STRAIN_MAX = 5.0
"""Of a gyro's error, in deviations of the prior: beyond it the filters may have followed a motion that is not the
satellite's."""


def started(b_B: Floats, B_N: Floats, noise: Noise, turns: int = TURNS, scales: int = SCALES) -> Bank:
    """A bank of turns about the field (3,), evenly spread, each with gyro scales spread over twice the prior's
    deviation.

    A spin that is off by a per cent leaves the attitude within minutes, so the scale is spread as the turn is.
    """
    first_B, first_N = _frame(b_B / np.linalg.norm(b_B)), _frame(B_N / np.linalg.norm(B_N))
    angle = np.repeat(2.0 * np.pi * np.arange(turns) / turns, scales)
    off = np.tile(np.linspace(-2.0, 2.0, scales) if scales > 1 else np.zeros(1), turns)
    about = exp(np.outer(angle, np.array([0.0, 0.0, 1.0])))
    R = first_N @ about @ first_B.T
    along = first_B[:, 2:] @ first_B[:, 2:].T
    P = np.zeros((len(angle), STATES, STATES))
    P[:, :3, :3] = (np.pi / turns) ** 2 * along + 0.1**2 * (np.eye(3) - along)
    P[:, [3, 4, 5], [3, 4, 5]] = noise.bias**2
    P[:, [6, 7, 8], [6, 7, 8]] = noise.field_bias**2
    P[:, [9, 10, 11], [9, 10, 11]] = noise.scale**2
    scale = np.repeat(noise.scale * off[:, None], 3, 1)
    zero = np.zeros((len(angle), 3))
    return Bank(R, zero, zero, scale, P, -0.5 * off**2)


def propagate(x: Bank, before: Floats, now: Floats, h: float, noise: Noise, since: float | None = None) -> None:
    """Over h s, by the measured rates (3,), rad/s, of the last measurement and of this one, `since` s apart; h by
    default, 0 where there is no new one.

    The body turns by the rate of before; what a rate that is linear over `since` adds is made up for at its end, with
    the turn of the body meanwhile, so a gap of several turns does not spoil it.
    """
    rate = (before - x.bias) / (1.0 + x.scale)
    after = (now - x.bias) / (1.0 + x.scale)
    middle = 0.5 * (rate + after)
    step = exp(h * rate) @ exp(_made_up(rate, after - rate, h if since is None else since))
    x.R = x.R @ step
    Jr = right_jacobian(h * middle)
    F = np.zeros_like(x.P)
    F[:, range(STATES), range(STATES)] = 1.0
    F[:, :3, :3] = step.transpose(0, 2, 1)
    F[:, :3, 3:6] = -h * Jr
    F[:, :3, 9:] = -h * Jr * middle[:, None, :]
    x.P = F @ x.P @ F.transpose(0, 2, 1)
    x.P[:, [0, 1, 2], [0, 1, 2]] += noise.angle**2 * h
    x.P[:, [3, 4, 5], [3, 4, 5]] += noise.bias_walk**2 * h
    x.P[:, [6, 7, 8], [6, 7, 8]] += noise.field_walk**2 * h


def _made_up(rate: Floats, change: Floats, since: float) -> Floats:
    """(k,3) rad: the integral of exp(-rate^ (since - t)) change t/since over `since`, in closed form."""
    if since == 0.0:
        return np.zeros_like(rate)
    angle = np.maximum(np.linalg.norm(rate, axis=1)[:, None] * since, 1e-3)
    w = angle / since
    across = np.cross(rate, change)
    normal = -np.cross(rate, across) / w**2
    turned = (1.0 - np.cos(angle)) / (angle * w) - 0.5 * since
    return np.asarray(0.5 * since * change + turned * normal - (1.0 - np.sin(angle) / angle) / w**2 * across)


def by_field(x: Bank, b_B: Floats, B_N: Floats, noise: Noise) -> Floats:
    """With the measured field (3,), T, and that of the model, in N. Returns the nis (k,), as all of these do."""
    b = np.einsum("kji,j->ki", x.R, B_N)
    slope = np.zeros((len(b), 3, 9))
    slope[:, :, :3], slope[:, :, 6:] = _hat(b), np.eye(3)
    return _corrected(x, b_B - b - x.field_bias, slope, np.full(3, noise.field**2), noise.gate)


def by_sun(x: Bank, sun_B: Floats, sun_N: Floats, sigma: float, noise: Noise) -> Floats:
    """With the measured direction to the Sun (3,), of unit length; sigma in rad."""
    s = np.einsum("kji,j->ki", x.R, sun_N)
    error = sun_B - s
    y = error - np.einsum("ki,ki->k", s, error)[:, None] * s
    return _corrected(x, y, _hat(s), np.full(3, sigma**2), noise.gate)


def by_tracker(x: Bank, R_NB: Floats, axes: Floats, variance: Floats, noise: Noise) -> Floats:
    """With a measured attitude (3,3), whose errors about the axes (3,3), by rows, have the variances (3,), rad2."""
    y = np.array([axes @ log(R.T @ R_NB) for R in x.R])
    return _corrected(x, y, np.repeat(axes[None], len(y), 0), variance, noise.gate)


def by_light(x: Bank, currents: Floats, faces: Faces, sun_N: Floats, r_N: Floats, noise: Noise) -> None:
    """With currents (m,) in sunlight: each is full (max(0, n.s) + Earth's light), a scalar at a time."""
    size, lit = float(np.linalg.norm(r_N)), float(earths_light(faces.albedo, r_N, sun_N))
    for n, full, current in zip(faces.normals, faces.full, currents, strict=True):
        if not n.any() or not np.isfinite(current):
            continue
        s, nadir = np.einsum("kji,j->ki", x.R, sun_N), np.einsum("kji,j->ki", x.R, -r_N / size)
        cosine, down = s @ n, nadir @ n
        seen = cosine > 0.0
        expected = np.where(seen, cosine, 0.0) + lit * (0.5 * (1.0 + down)) ** 2
        slope = np.where(seen[:, None], np.cross(n, s), 0.0) + (lit * 0.5 * (1.0 + down))[:, None] * np.cross(n, nadir)
        _corrected(x, (current / full - expected)[:, None], slope[:, None, :], np.array([noise.light**2]), noise.gate)


def earths_light(albedo: float, r_N: Floats, sun_N: Floats) -> Floats:
    """Returns the Earth's light on a face to nadir at r_N (...,3), m, as part of the Sun's with its direction
    (...,3)."""
    size = np.linalg.norm(r_N, axis=-1)
    return np.asarray(albedo * (EARTH_RADIUS / size) ** 2 * np.maximum(0.0, (r_N * sun_N).sum(axis=-1) / size))


def _corrected(x: Bank, y: Floats, H: Floats, variance: Floats, gate: float) -> Floats:
    """With an innovation (k,m) of slope (k,m,n) by the first n error states; beyond the gate it only counts in the
    score. Returns the normalised innovation squared (k,)."""
    n = H.shape[2]
    PH = x.P[:, :, :n] @ H.transpose(0, 2, 1)
    S = H @ PH[:, :n] + np.diag(variance)
    inverse = np.linalg.inv(S)
    nis = np.einsum("ki,kij,kj->k", y, inverse, y)
    use = nis <= gate
    x.score -= 0.5 * (np.minimum(nis, gate) + np.log(np.linalg.det(S / variance[0])))
    K = PH @ inverse * use[:, None, None]
    change = np.einsum("kij,kj->ki", K, y)
    left = np.tile(np.eye(STATES), (len(y), 1, 1))
    left[:, :, :n] -= K @ H
    x.P = left @ x.P @ left.transpose(0, 2, 1) + (K * variance) @ K.transpose(0, 2, 1)  # Joseph's form
    x.P = 0.5 * (x.P + x.P.transpose(0, 2, 1))
    x.R = x.R @ exp(change[:, :3])
    x.bias = x.bias + change[:, 3:6]
    x.field_bias = x.field_bias + change[:, 6:9]
    x.scale = x.scale + change[:, 9:]
    return np.asarray(nis)


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
