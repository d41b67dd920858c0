"""The estimator beside a public filter, the extended Kalman filter of the package ahrs, on the same measurements.

That filter takes a gyro and two unit vectors and knows no biases: quaternion, first order in the rate. Both get slow
turns.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from estimator import Inputs, Parameters, check, start, step
from estimator.onboard import sun_direction, sunlight
from fmus.interface import load

from ..paper import Array

STEPS, H = 1200, 0.5
FIELD, SUN, RATE = 3e-7, 0.01, 1e-5
"""Standard deviations: T, rad, rad/s of a sample."""


def compared() -> dict[str, Array]:
    """Angles, rad, over time: errors of both filters and between them, and the estimator's own standard deviation."""
    from ahrs.filters import EKF  # a package of this comparison alone  # noqa: PLC0415

    rng = np.random.default_rng(3)
    noise = {
        "rate_bias_sigma": 0.0,
        "rate_random_walk": 0.0,
        "angle_random_walk": RATE * math.sqrt(H),
        "sun_noise": SUN,
    }
    p = _record(Parameters, "parameter", field_noise=FIELD, gate=1e6, epoch="2009-02-10T00:00:00Z", **noise)
    check(p)
    r_N, v_N = np.array((6971e3, 0.0, 0.0)), np.zeros(3)
    R = Rotation.random(random_state=rng)
    x: Any = None
    found: dict[str, list[float]] = {name: [] for name in ("estimator", "ahrs", "apart", "sigma")}
    public: Any = None
    q = np.zeros(4)
    before = gyro = np.zeros(3)
    for k in range(STEPS):
        t = k * H
        rate = 2e-3 * np.array((math.sin(0.01 * t), math.cos(0.013 * t), 0.5))
        R = R * Rotation.from_rotvec(0.5 * H * (before + rate)) if k else R
        B, s = p.field.at(t, r_N), sun_direction(p.days + t / 86400.0)
        assert sunlight(r_N, s) > 0.5
        b = R.inv().apply(B) + FIELD * rng.normal(size=3)
        sun = R.inv().apply(s) + SUN * rng.normal(size=3)
        sun /= np.linalg.norm(sun)
        last, gyro = gyro, rate + RATE * rng.normal(size=3)
        before = rate
        u = _record(
            Inputs,
            "input",
            omega_B_measured=gyro,
            b_B_measured=b,
            r_N_measured=r_N,
            v_N_measured=v_N,
            sun_B_measured=sun,
        )
        if x is None:
            x = start(p, u)
            x, y = step(x, u, p, 1e-9)
            q = _quaternion(Rotation.from_matrix(y.R_NB))
            variances = [RATE**2, SUN**2, (FIELD / float(np.linalg.norm(B))) ** 2]
            public = EKF(magnetic_ref=(B / np.linalg.norm(B)).tolist(), noises=variances, Dt=H, P=1e-4 * np.eye(4))
            public.mag = np.zeros((1, 3))
            continue
        x, y = step(x, u, p, H)
        public.a_ref, public.m_ref = s, B / np.linalg.norm(B)
        q = public.update(q, 0.5 * (last + gyro), sun, b, H)
        ours, theirs = Rotation.from_matrix(y.R_NB), Rotation.from_quat(np.roll(q, -1))
        found["estimator"].append((ours.inv() * R).magnitude())
        found["ahrs"].append((theirs.inv() * R).magnitude())
        found["apart"].append((ours.inv() * theirs).magnitude())
        found["sigma"].append(float(np.linalg.norm(y.attitude_sigma_B)))
    return {name: np.array(values) for name, values in found.items()}


def _quaternion(R: Rotation) -> Array:
    return np.roll(R.as_quat(), 1)


def _record(record: Any, causality: Any, **changes: Any) -> Any:
    values = {v.name: changes.get(v.name, v.start) for v in load("estimator").of(causality)}
    return record(
        **{name: np.array(value, float) if isinstance(value, list) else value for name, value in values.items()}
    )
