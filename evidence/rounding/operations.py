"""What `controller.c` and `allocator.c` compute, operation by operation in their order, on numbers of either kind.

On doubles these lines give the C's bits, which the study checks for every sample: so a bound that they give on bounds
is one of the C. `a.within`, `least` state what is known of exact values; on doubles it is looked at.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

V = Sequence[Any]
M = Sequence[Sequence[Any]]
QUOTIENT = 1.0002
"""|element| of R_d^T R of two matrices that are orthonormal to 1e-4."""


def dot(u: V, v: V) -> Any:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def add(u: V, v: V) -> list[Any]:
    return [x + y for x, y in zip(u, v, strict=True)]


def subtract(u: V, v: V) -> list[Any]:
    return [x - y for x, y in zip(u, v, strict=True)]


def scale(s: Any, v: V) -> list[Any]:
    return [s * x for x in v]


def cross(u: V, v: V) -> list[Any]:
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def apply(m: M, v: V) -> list[Any]:
    return [dot(row, v) for row in m]


def transposed(m: M) -> list[list[Any]]:
    return [list(column) for column in zip(*m, strict=True)]


def apply_transposed(m: M, v: V) -> list[Any]:
    return apply(transposed(m), v)


def multiply(m: M, n: M) -> list[list[Any]]:
    return [apply_transposed(n, row) for row in m]


def clamped(a: Any, v: V, size: Any) -> list[Any]:
    return [a.within(x, size) for x in v]


def lvlh(a: Any, r_N: V, v_N: V, r: tuple[float, float], v: tuple[float, float], sine: float) -> tuple[M, V, V]:
    """R_d, Omega_d and dOmega_d of an orbit; r, v: least and largest length; sine: least of the angle between."""
    size = a.within(a.norm(r_N), r[1])
    h_N = clamped(a, cross(r_N, v_N), r[1] * v[1])
    least = r[0] * v[0] * sine
    h = a.within(a.norm(h_N), r[1] * v[1])
    n = a.divide(h, size * size, r[0] * r[0], v[1] / r[0])
    radial = a.within(dot(r_N, v_N), r[1] * v[1])
    dn = a.divide(-2.0 * n * radial, size * size, r[0] * r[0], 2.0 * (v[1] / r[0]) ** 2)
    z, y = a.direction(-size, r_N, r[0]), a.direction(-h, h_N, least)
    R_d = transposed([clamped(a, cross(y, z), 1.0), y, z])
    one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]  # R_d0
    Omega_d = apply_transposed(one, [0.0, -n, 0.0])
    return multiply(R_d, one), Omega_d, apply_transposed(one, [0.0, -dn, 0.0])


def errors(a: Any, R: M, omega_B: V, desired: tuple[M, V, V]) -> tuple[Any, ...]:
    """Q, |zeta|, omega and the desired motion in body axes [4]."""
    R_d, Omega_d, dOmega_d = desired
    Q = [clamped(a, row, QUOTIENT) for row in multiply(transposed(R_d), R)]
    axis = [Q[2][1] - Q[1][2], Q[0][2] - Q[2][0], Q[1][0] - Q[0][1]]
    cosine = 0.5 * (Q[0][0] + Q[1][1] + Q[2][2] - 1.0)
    # Of a rotation the sine and the cosine are on the unit circle; 1e-4 in R^T R moves them by less than 0.001.
    angle = a.atan2(a.within(0.5 * a.norm(axis), 1.001), a.within(cosine, 1.001), 0.99)
    Omega_d_B, dOmega_d_B = apply_transposed(Q, Omega_d), apply_transposed(Q, dOmega_d)
    return Q, angle, subtract(omega_B, Omega_d_B), Omega_d_B, dOmega_d_B


def controller(
    a: Any, p: Any, R: M, omega_B: V, r_N: V, r: tuple[float, float], e: tuple[Any, ...], first: tuple[Any, Any]
) -> dict[str, Any]:
    """The outputs [8] to [11]; first: |zeta| and |omega| at the start."""
    Q, angle, omega, Omega_d_B, dOmega_d_B = e
    k = a.divide(p.kappa0, p.a2 + first[0], p.a2) * (p.a1 + angle)
    l_ = a.divide(p.lambda0, p.c2 + first[1], p.c2) * (p.c1 + a.norm(omega))
    K = scale(k, p.K0)
    gradient = [
        K[1] * Q[1][2] - K[2] * Q[2][1],
        K[2] * Q[2][0] - K[0] * Q[0][2],
        K[0] * Q[0][1] - K[1] * Q[1][0],
    ]
    x = a.larger(dot(K, [1.0 - Q[i][i] for i in range(3)]), 0.0)
    share = a.divide(x, p.phi_scale, p.phi_scale)
    stretch = 1.0 + share
    value, slope = x, 1.0
    if p.phi == "logarithm":
        value, slope = p.phi_scale * a.log1p(share), a.divide(1.0, stretch, 1.0)
    if p.phi == "square_root":
        root = a.sqrt(stretch, 1.0)
        value, slope = a.divide(2.0 * x, root + 1.0, 2.0), a.divide(1.0, root, 1.0)
    size = a.within(a.norm(r_N), r[1])
    r_B = clamped(a, scale(a.divide(1.0, size, r[0]), apply_transposed(R, r_N)), 1.001)
    strength = a.divide(3.0 * p.gravitational_parameter, size * size * size, r[0] ** 3)
    M_g = scale(strength, cross(r_B, apply(p.J_B, r_B)))
    damping, acceleration = scale(-l_, apply(p.L0, omega)), apply(p.J_B, dOmega_d_B)
    gyroscopic = cross(Omega_d_B, apply(p.J_B, Omega_d_B))
    tau = subtract(add(add(damping, acceleration), add(gyroscopic, scale(slope, gradient))), M_g)
    return {
        "tau_cmd_B": tau,
        "attitude_error": [angle],
        "rate_error_B": omega,
        "lyapunov": [0.5 * dot(omega, apply(p.J_B, omega)) + value],
        "gain_k": [k],
        "gain_l": [l_],
    }


def across_field(a: Any, tau: V, b: V) -> list[Any]:
    """A unit vector across the field. It does not depend on the demand's size, of which a bound takes 1 to 2."""
    tau = clamped(a, tau, 2.0) if not isinstance(b[0], np.ndarray) else tau
    own = subtract(tau, scale(dot(tau, b), b))
    x, y, z = (abs(c) for c in b)
    zero = 0.0 * x
    first, second = (lambda: (x <= y) & (x <= z)), (lambda: y <= z)
    axis = a.either(
        first, [1.0 + zero, zero, zero], a.either(second, [zero, 1.0 + zero, zero], [zero, zero, 1.0 + zero])
    )
    axis = subtract(axis, scale(dot(axis, b), b))
    size = a.norm(own)
    if not isinstance(b[0], np.ndarray):
        return a.either(None, a.direction(size, own, 0.99 * ACROSS), a.direction(a.norm(axis), axis, 0.8))
    across = a.either(lambda: size > ACROSS * a.norm(tau), own, axis)
    return a.direction(a.norm(across), across, 0.0)


ACROSS = 1e-3
"""Of across_field in allocator.c."""


def wheel_reaction(axis: V, dh_w: Any, h_w: Any, Omega: V) -> list[Any]:
    return subtract(scale(-dh_w, axis), scale(h_w, cross(Omega, axis)))


def allocator(
    a: Any, p: Any, law: Any, tau: V, b_B: V, Omega: V, h_w: Any, B_range: tuple[float, float], b_least: float
) -> dict[str, Any]:
    """The outputs where no command is held; law: unit axes, and the least det(A^T A) of these rods."""
    U, axis = law.U, law.axis
    m_max, dh_max = p.hold_fraction * p.dipole_max, p.hold_fraction * p.wheel_torque_max
    across_max = 3.0 * m_max * B_range[1]  # of the torque of three rods
    B = a.within(a.norm(b_B), B_range[1])
    b = a.direction(B, b_B, B_range[0])
    spin = scale(h_w, cross(Omega, axis))
    along = dot(tau, b) + spin[0] * b[0] + spin[1] * b[1] + spin[2] * b[2]
    dh_w = -a.divide(along, dot(b, axis), b_least, dh_max)
    tau_MT = clamped(a, subtract(tau, wheel_reaction(axis, dh_w, h_w, Omega)), across_max)
    n = across_field(a, tau, b)
    c = clamped(a, cross(b, n), 1.0)
    A_n = clamped(a, apply(U, c), 1.0)
    A_c = scale(-1.0, clamped(a, apply(U, n), 1.0))
    nn, nc, cc = (a.within(dot(x, y), 3.0) for x, y in ((A_n, A_n), (A_n, A_c), (A_c, A_c)))
    det = a.within(nn * cc - nc * nc, 9.0)
    t_n, t_c = (a.within(dot(x, tau_MT), across_max) for x in (n, c))
    y_max = 3.0 * m_max / law.det_least**0.5  # |A y| is at least |y| (det/trace)^(1/2)
    least = B_range[0] * law.det_least
    y_n = a.divide(cc * t_n - nc * t_c, B * det, least, y_max)
    y_c = a.divide(nn * t_c - nc * t_n, B * det, least, y_max)
    dipole = clamped(a, add(scale(y_n, A_n), scale(y_c, A_c)), m_max)
    largest = a.larger(a.larger(abs(dipole[0]), abs(dipole[1])), abs(dipole[2]))
    shares = (
        a.divide(largest, p.dipole_max, p.dipole_max),
        a.divide(abs(dh_w), p.wheel_torque_max, p.wheel_torque_max),
    )
    rods = cross(apply_transposed(U, dipole), b_B)
    achieved = add(rods, wheel_reaction(axis, dh_w, h_w, Omega))
    return {
        "dipole_cmd": dipole,
        "wheel_torque_cmd": [dh_w],
        "demand_fraction": [a.larger(*shares)],
        "tau_residual_B": subtract(tau, achieved),
        "b_wheel": [a.divide(dot(b_B, axis), B, B_range[0], 1.0)],
    }
