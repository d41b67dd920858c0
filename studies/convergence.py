"""Whence the law converges when its torque is given exactly, and what its unstable equilibria are."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

import controller
from controller import law as paper
from controller import morse
from controller.errors import Errors

from .law import Law, stack
from .vectors import Array, cross, inverse, product, random_rotations, times

ORBITAL_RATE = math.sqrt(3.986004418e14 / 6971e3**3)
RATE_MAX = 0.1
"""Random rates are uniform in a ball of this radius, rad/s; the paper's manoeuvres start at 0.10 and 0.077."""


@dataclass(frozen=True)
class Flown:
    """Each (n,), of n cases."""

    initial_angle: Array
    converged: Array
    """When the errors are below 2 deg and 1e-3 rad/s for good, s; NaN where they are not at the end."""
    final_angle: Array
    final_rate: Array
    steps_up: Array
    """Samples at which V rose."""
    largest_rise: Array
    """Largest rise of V above its least value so far, over V(0)."""
    rate_error: float
    """Largest |dV/dt + omega.L omega|, W, over the largest omega.L omega, for constant gains; by central differences."""


def start(rng: np.random.Generator, n: int) -> tuple[Array, Array]:
    """Attitude errors Q uniform on SO(3), and body rates uniform in a ball of RATE_MAX."""
    Q = random_rotations(rng, n)
    direction = rng.standard_normal((3, n))
    size = RATE_MAX * rng.random(n) ** (1.0 / 3.0)
    return Q, size * direction / np.sqrt((direction * direction).sum(axis=0))


def fly(
    laws: list[controller.Parameters],
    J: Array,
    Q: Array,
    Omega: Array,
    duration: float,
    step: float = 0.1,
    n: float = ORBITAL_RATE,
    disturbance: Array | None = None,
) -> Flown:
    """The closed loop of each case with exact torque on a circular orbit, by RK4 on [1] and [2].

    J (3, 3, cases) is the body's inertia; the laws have their own. The gravity gradient acts. In LVLH the
    loop is autonomous: dQ/dt = Q Omega^ - Omega_d^ Q.
    """
    law = Law(laws)
    J_inverse = inverse(J)
    turn = np.zeros_like(Q)
    turn[0, 2], turn[2, 0] = -n, n  # Omega_d^ with Omega_d = (0, -n, 0)
    M = np.zeros_like(Omega) if disturbance is None else disturbance

    def slope(Q: Array, Omega: Array) -> tuple[Array, Array]:
        moment = law(Q, Omega, n).tau + 3.0 * n * n * cross(Q[2], times(J, Q[2])) + M
        skew_Q = product(Q, _hat(Omega)) - product(turn, Q)
        return skew_Q, times(J_inverse, moment - cross(Omega, times(J, Omega)))

    count = math.ceil(duration / step)
    first = law(Q, Omega, n)
    V0, least, V_before = first.V, first.V.copy(), first.V
    up, rise = np.zeros(len(V0)), np.zeros(len(V0))
    converged = np.full(len(V0), np.nan)
    outside = np.ones(len(V0), bool)
    defect, largest = 0.0, 0.0
    earlier: list[tuple[Array, Array]] = []
    for i in range(count + 1):
        d = law(Q, Omega, n)
        now = (d.zeta >= math.radians(2.0)) | (np.sqrt((d.omega**2).sum(axis=0)) >= 1e-3)
        converged = np.where(now, np.nan, np.where(outside, i * step, converged))
        outside = now
        if i:
            up += V_before + 1e-12 * V0 < d.V
            rise = np.maximum(rise, (d.V - least) / V0)
            least = np.minimum(least, d.V)
        V_before = d.V
        earlier = [*earlier[-4:], (d.V, d.dV)]
        if len(earlier) == 5 and i % 5 == 0:  # central difference of order 4 at the middle one
            V = [e[0] for e in earlier]
            found = (V[0] - 8.0 * V[1] + 8.0 * V[3] - V[4]) / (12.0 * step)
            defect = max(defect, float(np.abs(found - earlier[2][1]).max()))
            largest = max(largest, float(np.abs(earlier[2][1]).max()))
        k1 = slope(Q, Omega)
        k2 = slope(Q + 0.5 * step * k1[0], Omega + 0.5 * step * k1[1])
        k3 = slope(Q + 0.5 * step * k2[0], Omega + 0.5 * step * k2[1])
        k4 = slope(Q + step * k3[0], Omega + step * k3[1])
        Q = Q + step / 6.0 * (k1[0] + 2.0 * (k2[0] + k3[0]) + k4[0])
        Omega = Omega + step / 6.0 * (k1[1] + 2.0 * (k2[1] + k3[1]) + k4[1])
    return Flown(
        initial_angle=first.zeta,
        converged=converged,
        final_angle=d.zeta,
        final_rate=np.sqrt((d.omega**2).sum(axis=0)),
        steps_up=up,
        largest_rise=np.maximum(rise, 0.0),
        rate_error=defect / largest if largest else 0.0,
    )


def random_cases(
    law: controller.Parameters,
    schedule: str,
    n: int = 600,
    seed: int = 1,
    duration: float = 600.0,
    J: Array | None = None,
) -> Flown:
    """n random starts under one law with the gain schedule "error" [10] or "constant".

    J (3, 3, n): the bodies' inertias, by default what the law knows.
    """
    p = replace(law, gain_schedule=schedule)
    if schedule == "constant":  # k and l as [10] has them at the start from (90 deg, 0.1 rad/s)
        p = replace(
            p,
            kappa0=p.kappa0 * (p.a1 + math.pi / 2) / (p.a2 + math.pi / 2),
            lambda0=p.lambda0 * (p.c1 + RATE_MAX) / (p.c2 + RATE_MAX),
        )
    Q, Omega = start(np.random.default_rng(seed), n)
    return fly([p] * n, stack([p.J_B] * n) if J is None else J, Q, Omega, duration)


def from_the_edge(law: controller.Parameters, each: int = 20, seed: int = 3, off: float = 1e-6) -> Flown:
    """Starts at rest `off`, rad, from each of the three unstable equilibria, in random directions; gains [10]."""
    rng = np.random.default_rng(seed)
    Q = []
    for which in (1, 2, 3):
        for _ in range(each):
            x = rng.standard_normal(3)
            Q.append(np.diag(_SIGNS[which]) @ controller.so3.exp(off * x / np.linalg.norm(x)))
    at = stack(Q)
    p = [law] * len(Q)
    return fly(p, stack([law.J_B] * len(Q)), at, at[1] * -ORBITAL_RATE, 1500.0)


# ---------------------------------------------------------------- equilibria

EQUILIBRIA = ("I", "half turn about e1", "half turn about e2", "half turn about e3")
_SIGNS = np.array(((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)))


def stiffness(K: Array, which: int) -> Array:
    """H (3,) of the torque -H eta at Q = Q_i exp(eta^): h_i = sum of s_j k_j over j not i, Q_i = diag(s)."""
    s = _SIGNS[which] * K
    return np.array((s[1] + s[2], s[2] + s[0], s[0] + s[1]))


def analytic_eigenvalues(J: Array, K: Array, L: Array, which: int, n: float = ORBITAL_RATE) -> Array:
    """Eigenvalues (6,) of J omega' = J(omega x W) - omega x J W - W x J omega - L omega - H eta, eta' = omega.

    The law [8] put into the error dynamics [6] and linearised about (Q_i, 0), with W = Q_i^T Omega_d.
    """
    W = _SIGNS[which] * np.array((0.0, -n, 0.0))
    gyroscopic = -J @ _skew(W) + _skew(J @ W) - _skew(W) @ J
    inverse_J = np.linalg.inv(J)
    A = np.zeros((6, 6))
    A[:3, 3:] = np.eye(3)
    A[3:, :3] = -inverse_J @ np.diag(stiffness(K, which))
    A[3:, 3:] = inverse_J @ (gyroscopic - L)
    return _ordered(np.linalg.eigvals(A))


def closed_form(J: Array, K: Array, L: Array, which: int) -> Array:
    """The same without the orbit's rate, for diagonal J and L: (-l_i +- sqrt(l_i^2 - 4 J_i h_i))/(2 J_i)."""
    j, l, h = J.diagonal(), L.diagonal(), stiffness(K, which)  # noqa: E741
    root = np.sqrt((l * l - 4.0 * j * h).astype(complex))
    return _ordered(np.concatenate(((-l + root) / (2.0 * j), (-l - root) / (2.0 * j))))


def measured_eigenvalues(law: controller.Parameters, which: int, n: float = ORBITAL_RATE, eps: float = 1e-5) -> Array:
    """Eigenvalues (6,) of the loop of the controller's own functions and a body, by central differences about Q_i."""
    Q0, J = np.diag(_SIGNS[which]), law.J_B
    J_inverse = np.linalg.inv(J)
    Omega_d = np.array((0.0, -n, 0.0))

    def rate(x: Array) -> Array:
        Q = Q0 @ controller.so3.exp(x[:3])
        W = Q.T @ Omega_d
        Omega = x[3:] + W
        e = Errors(Q, 0.0, x[3:], W, np.zeros(3))
        K, L = law.kappa0 * law.K0, law.lambda0 * law.L0
        r_B = -Q[2]
        M_g = 3.0 * n * n * np.cross(r_B, J @ r_B)
        tau = paper.torque(J, K, L, morse.phi(law.phi, law.phi_scale, morse.trace(K, Q))[1], e, M_g)
        acceleration = J_inverse @ (tau + M_g - np.cross(Omega, J @ Omega))
        # omega = Omega - Q^T Omega_d, so omega' = Omega' + omega x Q^T Omega_d; eta' = omega to first order.
        return np.concatenate((x[3:], acceleration + np.cross(x[3:], W)))

    A = np.column_stack([(rate(eps * e) - rate(-eps * e)) / (2.0 * eps) for e in np.eye(6)])
    return _ordered(np.linalg.eigvals(A))


def at_rest(law: controller.Parameters) -> controller.Parameters:
    """The law with the constant gains that [10] has where the loop rests at a half turn, having started there."""
    return replace(
        law,
        gain_schedule="constant",
        kappa0=law.kappa0 * (law.a1 + math.pi) / (law.a2 + math.pi),
        lambda0=law.lambda0 * law.c1 / law.c2,
    )


def _ordered(values: Array) -> Array:
    return values[np.lexsort((values.imag, -values.real))]


def _skew(x: Array) -> Array:
    return np.array(((0.0, -x[2], x[1]), (x[2], 0.0, -x[0]), (-x[1], x[0], 0.0)))


def _hat(x: Array) -> Array:
    zero = np.zeros_like(x[0])
    return np.array(((zero, -x[2], x[1]), (x[2], zero, -x[0]), (-x[1], x[0], zero)))
