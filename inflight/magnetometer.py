"""Calibration of a magnetometer without attitude: |A (g(t) m - b(t))| is the field's size along the orbit.

b is the bias, whose drift is linear between the knots of the gain and small, A = diag(scale) (1 + misalignment) upper
triangular, since a turn of the sensor does not show in a size, and g a common gain of the sensor, linear between knots,
of mean 1: it acts on field and bias alike. Residuals are weighed by Huber's rule. Gauss and Newton with the derivatives
in closed form. Tests: tests/inflight/test_magnetometer.py."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestration.quantities import parse_unit

Floats = NDArray[np.float64]

KNOT_INTERVAL = 300.0
"""s"""
NAMES = ("A11", "A12", "A13", "A22", "A23", "A33", "b1", "b2", "b3")
PRIOR = np.array([0.2, 0.1, 0.1, 0.2, 0.1, 0.2, 2e-4, 2e-4, 2e-4])
"""Standard deviations of what is known before: scales and angles of A; the bias in T."""
GAIN_STEP = 0.01
"""Standard deviation of the change of the gain from knot to knot."""
BIAS_STEP = 3e-8
"""T, that of the bias; a loose one would take over what the gain does."""
GAIN_JUMP = 0.1
"""The same at a break."""
NOISE = 5e-7
"""T, with which the residuals begin; the fit's own rms takes its place."""
HUBER = 2.0
PARTS, STUDENT = 6, 1.312
"""Of a record, of which one after the other is left out for the covariance; the 97.5% of Student's distribution with
one freedom less than parts, over that of the normal one."""
SHOWN = 0.2
"""A parameter is shown by the record where its deviation is below this part of what was known before."""
_UPPER = np.triu_indices(3)


@dataclass(frozen=True)
class Calibration:
    """Calibration from a record."""

    A: Floats
    """(3,3)"""
    bias: Floats
    """(3,) T, of the sensor's own reading"""
    knots: Floats
    """s"""
    gain: Floats
    drift: Floats
    """(knots,3) T, of the bias, of mean 0"""
    covariance: Floats
    """Of A (its upper triangle by rows), the bias, the gain and the drift, an axis after the other; with errors that
    last from row to row."""
    rms: float
    """T, of the field's size"""
    residual: Floats

    @property
    def sigma(self) -> Floats:
        """Standard deviations in the order of the covariance."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def field(self, t: Floats, m: Floats) -> Floats:
        """The calibrated field (n,3), T."""
        H = _hats(t, self.knots)
        return np.asarray(((H @ self.gain)[:, None] * m - self.bias - H @ self.drift) @ self.A.T)

    def verdict(self) -> dict[str, str]:
        """Returns what the record shows of each parameter."""
        share = self.sigma[:9] / PRIOR
        return {
            n: "shown" if s < SHOWN else "weak" if s < 0.7 else "not shown" for n, s in zip(NAMES, share, strict=True)
        }

    def data(self, unit: str = "T") -> dict[str, Any]:
        """For JSON and YAML; `matrix`, `offset` and `gain` are those of a column of telemetry in this unit, with A as
        `symmetric` has it; `sensors` and `estimator` are what those blocks take, with the gain at its mean."""
        A, offset = symmetric(self).A, (self.bias + self.drift) / parse_unit(unit).factor
        sensors = {"field_bias_B": self.bias.tolist(), "field_scale": (np.linalg.inv(A) - np.eye(3)).tolist()}
        return {
            "unit": unit,
            "matrix": A.tolist(),
            "offset": np.column_stack((self.knots, offset)).tolist(),
            "gain": [[float(t), float(g)] for t, g in zip(self.knots, self.gain, strict=True)],
            "sensors": sensors | {"field_noise": self.rms},
            "estimator": {"field_noise": self.rms, "field_bias_sigma": float(self.sigma[6:9].max())},
            "sigma": dict(zip(NAMES, self.sigma[:9].tolist(), strict=True)),
            "gain_sigma": self.sigma[9 : 9 + len(self.knots)].tolist(),
            "covariance": self.covariance.tolist(),
            "rms": self.rms,
            "verdict": self.verdict(),
        }


def calibrate(
    t: Floats,
    m: Floats,
    size: Floats,
    known: Calibration | None = None,
    interval: float = KNOT_INTERVAL,
    breaks: Floats | None = None,
) -> Calibration:
    """Fits readings m (n,3), T, at t (n,), s, to the field's size (n,), T. `known`: A and bias stay, the gain is
    fitted.

    `interval` is that of the gain's knots; a record shorter than two intervals has one constant gain, which is 1
    unless A is known. At `breaks`, s, such as the borders of eclipses, the gain may jump within 10 s.
    """
    count = max(round(float(np.ptp(t)) / interval), 1)
    knots = np.linspace(t[0], t[-1], count + 1) if count > 1 else np.array([t[0]])
    steps = np.full(max(len(knots) - 1, 0), GAIN_STEP)
    for at in breaks if breaks is not None and count > 1 else ():
        if t[0] + 30.0 < at < t[-1] - 30.0:
            knots = knots[np.abs(knots - at) > 30.0]
            place = int(np.searchsorted(knots, at))
            knots = np.insert(knots, place, (at - 5.0, at + 5.0))
            steps = np.full(len(knots) - 1, GAIN_STEP)
    steps[np.diff(knots) < 11.0] = GAIN_JUMP
    H = _hats(t, knots)
    unit = 1e-6
    m, size = m / unit, size / unit
    prior = PRIOR.copy()
    prior[6:] /= unit
    drift = np.zeros(3 * len(knots))
    if known is None:
        x = np.concatenate(([1, 0, 0, 1, 0, 1], 0.5 * (m.max(0) + m.min(0)), np.ones(len(knots)), drift))
    else:
        x = np.concatenate((known.A[_UPPER], known.bias / unit, np.ones(len(knots)), drift))
    gain = slice(9, 9 + len(knots))
    free = np.ones(len(x), bool)
    if known is not None:
        free[:9] = free[gain.stop :] = False
    start = x.copy()
    sigma = NOISE / unit
    known_before = _smooth(len(knots), steps, unit, tied=known is None)
    for _ in range(60):
        r, J = _residual(x, m, size, H)
        w = np.minimum(1.0, HUBER * sigma / np.maximum(np.abs(r), 1e-12)) / sigma**2
        N = (J * w[:, None]).T @ J
        g = (J * w[:, None]).T @ r
        N[np.arange(9), np.arange(9)] += prior**-2
        g[:9] += (x[:9] - start[:9]) / prior**2
        N += known_before
        g += known_before @ x
        if known is None:
            g[gain] -= known_before[gain, gain] @ np.ones(
                len(knots)
            )  # the mean of the gain is 1, since A has the scale
        change = np.linalg.solve(N[np.ix_(free, free)], g[free])
        x[free] -= change
        sigma = max(1.4826 * float(np.median(np.abs(r))), 0.02)
        if np.abs(change).max() < 1e-9:
            break
    r, J = _residual(x, m, size, H)
    scale = np.concatenate((np.ones(6), np.full(3, unit), np.ones(len(knots)), np.full(len(drift), unit)))
    covariance = np.zeros((len(x), len(x)))
    w = np.minimum(1.0, HUBER * sigma / np.maximum(np.abs(r), 1e-12)) / sigma**2
    covariance[np.ix_(free, free)] = _honest(N[np.ix_(free, free)], J[:, free], r, w)
    A = np.zeros((3, 3))
    A[_UPPER] = x[:6]
    rms = float(np.sqrt(np.mean(r**2))) * unit
    drifted = x[gain.stop :].reshape(3, -1).T * unit
    return Calibration(A, x[6:9] * unit, knots, x[gain], drifted, covariance * np.outer(scale, scale), rms, r * unit)


def symmetric(calibration: Calibration) -> Calibration:
    """The same with A symmetric: turned as little as the stretching allows, where nothing else is known of the axes."""
    _, stretch, V = np.linalg.svd(calibration.A)
    return replace(calibration, A=V.T @ np.diag(stretch) @ V)


def _residual(x: Floats, m: Floats, size: Floats, H: Floats) -> tuple[Floats, Floats]:
    A, n = np.zeros((3, 3)), H.shape[1]
    A[_UPPER] = x[:6]
    v = (H @ x[9 : 9 + n])[:, None] * m - x[6:9] - H @ x[9 + n :].reshape(3, n).T
    b = v @ A.T
    length = np.maximum(np.linalg.norm(b, axis=1), 1e-9)
    u = b / length[:, None]
    by_A = (u[:, :, None] * v[:, None, :])[:, _UPPER[0], _UPPER[1]]
    back = u @ A
    by_gain, by_drift = H * np.einsum("ni,ni->n", back, m)[:, None], [-back[:, i : i + 1] * H for i in range(3)]
    return length - size, np.concatenate((by_A, -back, by_gain, *by_drift), axis=1)


def _smooth(knots: int, steps: Floats, unit: float, tied: bool) -> Floats:
    """Returns what is known before of the changes of gain and drift from knot to knot, and of their means, as normal
    equations.

    `tied`: the mean of the gain is known.
    """
    known = np.zeros((9 + 4 * knots, 9 + 4 * knots))
    change = np.diff(np.eye(knots), axis=0)
    mean = np.full((knots, knots), (1.0 / knots / 1e-5) ** 2)
    for k in range(4):
        at = slice(9 + k * knots, 9 + (k + 1) * knots)
        D = change / (steps * (1.0 if k == 0 else BIAS_STEP / unit / GAIN_STEP))[:, None]
        known[at, at] = D.T @ D + (mean if k or tied else 0.0)
    return known


def _hats(t: Floats, knots: Floats) -> Floats:
    return np.array([np.interp(t, knots, row) for row in np.eye(len(knots))]).T


def _honest(N: Floats, J: Floats, r: Floats, w: Floats) -> Floats:
    """The covariance of a fit with normal equations N, derivatives J (n,k), residuals r and weights w (n,).

    The model's errors (field, orbit, what a gain does not follow) last for minutes, so a record of thousands of rows
    has far fewer independent ones, and a fit follows some of them. The jackknife leaves out one part of the record
    after the other (Tukey, 1958; here by one step of Gauss and Newton), which needs no model of them. Few parts know a
    deviation poorly: Student's factor is in it. No deviation is below that of independent rows, which has what is
    known before.
    """
    independent = np.asarray(np.linalg.inv(N), float)
    changes = []
    for rows in np.array_split(np.arange(len(r)), PARTS):
        part = J[rows] * w[rows, None]
        changes.append(np.linalg.solve(N - part.T @ J[rows], part.T @ r[rows]))
    off = np.array(changes) - np.mean(changes, axis=0)
    jackknife = STUDENT**2 * (PARTS - 1) / PARTS * off.T @ off
    size = np.sqrt(np.maximum(np.diag(jackknife) / np.diag(independent), 1.0))
    return np.asarray(independent * np.outer(size, size))
