"""Random demands on the bounded allocator, in every kind of field, and the problem that it solves."""

from dataclasses import replace

import numpy as np

from allocator import bounded
from tests.blocks import inputs, parameters

BLOCK = "allocator_bounded"
P = parameters(BLOCK)
RNG = np.random.default_rng(8)
E1 = np.array([1.0, 0.0, 0.0])


def unit(x):
    return np.asarray(x, float) / np.linalg.norm(x)


def given(u, p=P):
    return bounded.outputs(bounded.State(0.0), u, p)


def commands(y):
    return np.array([*y.dipole_cmd, y.wheel_torque_cmd])


def torque(y, u, p=P):
    """Of the commands on the body [14] [16], by NumPy's cross products."""
    rods = np.cross(y.dipole_cmd @ p.U, u.b_B)
    return rods - y.wheel_torque_cmd * E1 - u.h_w * np.cross(u.omega_B, E1)


FIELDS = {
    "any": lambda rng: rng.normal(size=3) * 3e-5,
    "normal to the wheel": lambda rng: np.array([0.0, *rng.normal(size=2)]) * 3e-5,
    "along the wheel": lambda rng: rng.choice([-3e-5, 3e-5]) * E1,
    "along a rod": lambda rng: 3e-5 * P.U[rng.integers(3)],
    "weak": lambda rng: rng.normal(size=3) * 10.0 ** rng.uniform(-11.0, -6.0),
    "none": lambda rng: np.zeros(3),
}


def problem(rng, kind, tuned=True):
    """Inputs and parameters: demands from those that are met to ten times too large, wheels still, running and full."""
    free = rng.random() < 0.5
    u = inputs(
        BLOCK,
        tau_cmd_B=rng.normal(size=3) * 10.0 ** rng.uniform(-6.0, -2.0),
        b_B=FIELDS[kind](rng),
        omega_B=rng.normal(size=3) * 0.05,
        h_w=rng.choice([0.0, 0.03, -0.03, 0.0299, rng.uniform(-0.03, 0.03), 0.04, -0.05]),
        **({} if free else {"dipole_ff": rng.uniform(-30.0, 30.0, 3), "wheel_torque_ff": rng.uniform(-4e-3, 4e-3)}),
    )
    if not tuned:
        return u, P
    rods = np.array([unit(v) for v in rng.normal(size=(3, 3))]) if kind != "along a rod" else P.rod_axes
    p = replace(P, rod_axes=rods, rod_weight=10.0 ** rng.uniform(-7, -6), wheel_weight=rng.uniform(0.0, 0.3))
    return u, replace(p, command_period=rng.choice([0.1, 5.0, 30.0]), wheel_weight_ff=rng.uniform(0.0, 0.3))


PROBLEMS = {kind: [problem(RNG, kind) for _ in range(300)] for kind in FIELDS}


def cost_and_box(u, p):
    """The problem as the interface states it, in A m2 and N m: residuals as a matrix and a vector, and the box."""
    e = np.eye(4)
    with_wheel = abs(u.wheel_torque_ff) < 1e9
    m_p = np.clip(u.dipole_ff, -25.0, 25.0) if np.abs(u.dipole_ff).max() < 1e9 else np.zeros(3)
    m_p = m_p if np.any(u.b_B) else np.zeros(3)
    low, high = -p.wheel_torque_max, p.wheel_torque_max
    if u.h_w + p.command_period * high > p.wheel_momentum_max:
        high = max((p.wheel_momentum_max - u.h_w) / p.command_period, 0.0)
    if u.h_w + p.command_period * low < -p.wheel_momentum_max:
        low = min((-p.wheel_momentum_max - u.h_w) / p.command_period, 0.0)
    d_p = np.clip(u.wheel_torque_ff if with_wheel else -u.h_w / p.desaturation_time, low, high)
    w_w = p.wheel_weight_ff if with_wheel else p.wheel_weight
    gains = u.rod_gains if np.abs(u.rod_gains).max() < 1e9 else np.ones(3)
    by_actuator = [gain * np.cross(axis, u.b_B) for gain, axis in zip(gains, p.U, strict=True)] + [-E1]
    A = np.vstack([np.column_stack(by_actuator), p.rod_weight * e[:3], w_w * e[3:]])
    r = u.tau_cmd_B + u.h_w * np.cross(u.omega_B, E1)
    y = np.concatenate([r, p.rod_weight * m_p, [w_w * d_p]])
    return A, y, np.array([-25.0, -25.0, -25.0, low]), np.array([25.0, 25.0, 25.0, high])
