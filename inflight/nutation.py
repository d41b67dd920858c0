"""Ratios of inertia from free motion, and its forecast by the plant's integrator.

A rigid body without moments obeys J dw/dt = J w x w, of which only ratios of J show. Common to all records are the
principal moments as parts of the second one, the turn of the principal axes and the gyro's bias; each record has its
rate at its start. Gauss and Newton; derivatives by differences, all at once. Tests: tests/inflight/test_nutation.py.

Longer than 250 lines: the motion, its derivatives and the fit are one method.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimator.bank import exp
from plant.attitude import COMPOSITIONS, Body, lgvi_step

Floats = NDArray[np.float64]

STEP = 0.2
"""Longest step of the integration, s."""
PRIOR = np.array([0.5, 0.5, 0.1, 0.1, 0.1, 0.005, 0.005, 0.005])
"""Standard deviations of what is known before: logarithms of the two ratios, the turn, rad, the bias, rad/s."""
COMMON = len(PRIOR)
AMPLITUDE_MIN = 2.0
"""A record shows nutation where its rates across the spin vary by so many times the noise."""


@dataclass(frozen=True)
class Motion:
    """Rates (n,3), rad/s, at times (n,), s."""

    name: str
    t: Floats
    omega: Floats

    def until(self, end: float) -> Motion:
        """The part to so many s after its first row."""
        early = self.t - self.t[0] <= end
        return replace(self, t=self.t[early], omega=self.omega[early])


@dataclass(frozen=True)
class Inertia:
    """Inertia from free motion: J = turn diag(i1, 1, i3) turn^T up to a factor."""

    p: Floats
    """(8,): log i1, log i3, turn, rad, bias, rad/s"""
    covariance: Floats
    starts: Floats
    """(records, 3) rad/s"""
    rms: float
    """rad/s, of a component of the residuals: with a good fit the gyro's noise"""
    amplitude: float
    """rad/s, of the nutation in the record that has most of it"""

    @property
    def ratios(self) -> Floats:
        """(i1, i3), the moments about the first and third principal axis as parts of that about the second."""
        return np.exp(self.p[:2])

    @property
    def ratio_sigma(self) -> Floats:
        return np.asarray(self.ratios * np.sqrt(np.diag(self.covariance))[:2])

    @property
    def J(self) -> Floats:
        """(3,3) with the second principal moment 1."""
        return inertia(self.p)

    def data(self) -> dict[str, Any]:
        """For JSON."""
        sigma = np.sqrt(np.diag(self.covariance))
        share = sigma / PRIOR
        return {
            "ratios": self.ratios.tolist(),
            "ratio_sigma": self.ratio_sigma.tolist(),
            "axes_turn": self.p[2:5].tolist(),
            "axes_turn_sigma": sigma[2:5].tolist(),
            "gyro_bias": self.p[5:8].tolist(),
            "gyro_bias_sigma": sigma[5:8].tolist(),
            "J_B": self.J.tolist(),
            "rms": self.rms,
            "verdict": {
                "ratios": "shown"
                if share[:2].max() < 0.2 and self.amplitude > AMPLITUDE_MIN * self.rms
                else "not shown",
                "axes": "shown" if share[2:5].max() < 0.5 else "not all shown",
                "gyro bias": "shown" if share[5:8].max() < 0.5 else "not all shown",
            },
        }


def inertia(p: Floats) -> Floats:
    """J (...,3,3) of common parameters (...,8)."""
    flat = p.reshape(-1, p.shape[-1])
    moments = np.stack((np.exp(flat[:, 0]), np.ones(len(flat)), np.exp(flat[:, 1])), axis=1)
    C = exp(flat[:, 2:5])
    J = np.einsum("kij,kj,klj->kil", C, moments, C)
    return np.asarray(J.reshape(*p.shape[:-1], 3, 3))


def identify(motions: Sequence[Motion], first: Inertia | None = None, rounds: int = 25) -> Inertia:
    """Fits inertia, bias and the rates at the starts. `first` is where to begin; by default what the frequency says."""
    x = np.zeros((len(motions), 3)) if first is None or len(first.starts) != len(motions) else first.starts.copy()
    if not x.any():
        x = np.array([m.omega[:8].mean(axis=0) for m in motions])
    p = _from_frequency(motions) if first is None else first.p.copy()
    prior = p.copy()
    prior[2:] = 0.0
    sigma, last = 2e-3, np.inf
    damping = 1e-3
    for _ in range(rounds):
        N, g, cost = _normal(motions, p, x, sigma, prior)
        while True:
            step = np.linalg.solve(N + damping * np.diag(np.diag(N)), g)
            p_new, x_new = p - step[:COMMON], x - step[COMMON:].reshape(-1, 3)
            new = _cost(motions, p_new, x_new, sigma, prior)
            if new <= cost or damping > 1e6:
                break
            damping *= 10.0
        if new <= cost:
            p, x = p_new, x_new
        damping = max(damping / 10.0, 1e-9)
        if abs(last - new) < 1e-7 * new:
            break
        last = new
    fitted = [predicted(m, p, w) for m, w in zip(motions, x, strict=True)]
    r = np.concatenate([(f - m.omega).ravel() for f, m in zip(fitted, motions, strict=True)])
    amplitude = max(float(f.std(axis=0).max()) for f in fitted)
    rms = float(np.sqrt(np.mean(r**2)))
    N, _, _ = _normal(motions, p, x, rms, prior)
    return Inertia(p, np.asarray(np.linalg.inv(N), float)[:COMMON, :COMMON], x, rms, amplitude)


def left_out(motions: Sequence[Motion], whole: Inertia, i: int) -> Inertia:
    """Returns what all records but that of number i show; `whole` is what all show, where the fit begins."""
    rest = [motion for k, motion in enumerate(motions) if k != i]
    return identify(rest, replace(whole, starts=np.delete(whole.starts, i, 0)), 3)


def starting(motion: Motion, known: Inertia) -> Floats:
    """The rate (3,) at the start of a record whose body is known."""
    x = motion.omega[:8].mean(axis=0)
    for _ in range(12):
        r, J = _derivatives(motion, known.p, x)
        step = np.linalg.lstsq(J[:, COMMON:], r, rcond=None)[0]
        x = x - step
        if np.abs(step).max() < 1e-10:
            break
    return np.asarray(x)


def predicted(motion: Motion, p: Floats, start: Floats) -> Floats:
    """Returns what a gyro of this bias measures at a record's instants (n,3)."""
    return _integrated(motion.t, p[None], start[None])[0]


def forecast(motion: Motion, known: Inertia, start: Floats) -> Floats:
    """The same by the integrator of the plant, of order 4, without moments."""
    J = known.J
    body, no_wheels = Body(J, np.asarray(np.linalg.inv(J), float)), np.zeros(3)
    R, Pi, zero = np.eye(3), J @ start, np.zeros(3)
    rates = [start]
    for a, b in zip(motion.t[:-1], motion.t[1:], strict=True):
        steps = max(1, int(np.ceil((b - a) / STEP)))
        h, t = (b - a) / steps, float(a)
        for _ in range(steps):
            for part in COMPOSITIONS[4]:
                R, Pi, zero = lgvi_step(R, Pi, zero, lambda *_: np.zeros(3), body, t, part * h, no_wheels, no_wheels)
                t += part * h
        rates.append(body.J_inverse @ Pi)
    return np.array(rates) + known.p[5:8]


def _integrated(t: Floats, p: Floats, start: Floats) -> Floats:
    """(k,n,3) of k sets of parameters (k,8) and starts (k,3): Euler's equations in principal axes, Runge and Kutta,
    order 4."""
    i1, i2, i3 = np.exp(p[:, 0]), np.ones(len(p)), np.exp(p[:, 1])
    factor = np.array(((i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3))
    C = exp(p[:, 2:5])
    after, before = [1, 2, 0], [2, 0, 1]
    w = (np.swapaxes(C, 1, 2) @ start[:, :, None])[:, :, 0].T
    rates = [w]
    for span in np.diff(t):
        steps = max(1, int(np.ceil(span / STEP)))
        h = span / steps
        for _ in range(steps):
            k1 = factor * w[after] * w[before]
            v = w + 0.5 * h * k1
            k2 = factor * v[after] * v[before]
            v = w + 0.5 * h * k2
            k3 = factor * v[after] * v[before]
            v = w + h * k3
            w = w + h / 6.0 * (k1 + 2.0 * (k2 + k3) + factor * v[after] * v[before])
        rates.append(w)
    return np.asarray(np.stack(rates).transpose(2, 0, 1) @ np.swapaxes(C, 1, 2) + p[:, None, 5:8])


def _derivatives(motion: Motion, p: Floats, x: Floats) -> tuple[Floats, Floats]:
    """Residuals (3n,) and their derivatives (3n, 8 + 3)."""
    d = 1e-6
    k = COMMON + 3
    ps, xs = np.tile(p, (k + 1, 1)), np.tile(x, (k + 1, 1))
    ps[range(1, COMMON + 1), range(COMMON)] += d
    xs[range(COMMON + 1, k + 1), range(3)] += d
    all_ = _integrated(motion.t, ps, xs).reshape(k + 1, -1)
    return all_[0] - motion.omega.ravel(), ((all_[1:] - all_[0]) / d).T


def _normal(
    motions: Sequence[Motion], p: Floats, x: Floats, sigma: float, prior: Floats
) -> tuple[Floats, Floats, float]:
    n = COMMON + 3 * len(motions)
    N, g, cost = np.zeros((n, n)), np.zeros(n), 0.0
    for i, motion in enumerate(motions):
        r, J = _derivatives(motion, p, x[i])
        at = [*range(COMMON), *range(COMMON + 3 * i, COMMON + 3 * i + 3)]
        N[np.ix_(at, at)] += J.T @ J / sigma**2
        g[at] += J.T @ r / sigma**2
        cost += float(r @ r) / sigma**2
    off = (p - prior) / PRIOR
    N[range(COMMON), range(COMMON)] += PRIOR**-2
    g[:COMMON] += off / PRIOR
    return N, g, cost + float(off @ off)


def _cost(motions: Sequence[Motion], p: Floats, x: Floats, sigma: float, prior: Floats) -> float:
    cost = float((((p - prior) / PRIOR) ** 2).sum())
    for motion, start in zip(motions, x, strict=True):
        cost += float(((predicted(motion, p, start) - motion.omega) ** 2).sum()) / sigma**2
    return cost if np.isfinite(cost) else np.inf


def _from_frequency(motions: Sequence[Motion]) -> Floats:
    """Common parameters of a small nutation about the body axis of the spin, from its frequency and its axes' ratio.

    About the second axis d w1/dt = v W w3, d w3/dt = -u W w1 with v = (1 - i3)/i1, u = (1 - i1)/i3, W the spin: the
    frequency is sqrt(u v) W, and the amplitudes are as sqrt(v/u).
    """
    best = (np.inf, 0.5, 1.0)
    for share in np.linspace(0.03, 1.5, 400):
        cost, first, third = 0.0, 0.0, 0.0
        for motion in motions:
            spin = float(np.abs(motion.omega[:, 1]).mean())
            wave = share * spin * (motion.t - motion.t[0])
            H = np.column_stack((np.ones(len(wave)), np.cos(wave), np.sin(wave)))
            X, rest, *_ = np.linalg.lstsq(H, motion.omega[:, [0, 2]], rcond=None)
            cost += float(rest.sum()) if len(rest) else 0.0
            first += float((X[1:, 0] ** 2).sum())
            third += float((X[1:, 1] ** 2).sum())
        if cost < best[0]:
            best = cost, share, np.sqrt(first / max(third, 1e-30))
    share, ratio = best[1], float(np.clip(best[2], 0.05, 20.0))
    u, v = share / ratio, share * ratio
    i3 = (v - 1.0) / (u * v - 1.0) if abs(u * v - 1.0) > 1e-6 else 0.5
    i1 = 1.0 - u * i3
    if not (0.02 < i1 < 5.0 and 0.02 < i3 < 5.0):
        i1, i3 = 0.5, 0.9
    return np.array([np.log(i1), np.log(i3), 0, 0, 0, 0, 0, 0])
