"""The rests of the law [8]: the goal, three half turns, and the eigenvalues of the loop at each.
Tests: tests/evidence/reproduction/test_convergence.py."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

import controller
from controller import law as paper
from controller import morse, so3
from controller.errors import Errors
from controller.gains import attitude_scale, rate_scale

from ..paper import ORBIT, Array

ORBITAL_RATE = 2.0 * math.pi / ORBIT
SIGNS = np.array(((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)))


def stiffness(K: Array, which: int) -> Array:
    """H (3,) of the torque -H eta at Q = Q_i exp(eta^): h_i = sum of s_j k_j over j not i, Q_i = diag(s)."""
    s = SIGNS[which] * K
    return np.array((s[1] + s[2], s[2] + s[0], s[0] + s[1]))


def analytic_eigenvalues(J: Array, K: Array, L: Array, which: int, n: float = ORBITAL_RATE) -> Array:
    """Eigenvalues (6,) of J omega' = J(omega x W) - omega x J W - W x J omega - L omega - H eta, eta' = omega.

    The law [8] put into the error dynamics [6] and linearised about (Q_i, 0), with W = Q_i^T Omega_d.
    """
    W = SIGNS[which] * np.array((0.0, -n, 0.0))
    gyroscopic = -J @ so3.hat(W) + so3.hat(J @ W) - so3.hat(W) @ J
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
    Q0, J = np.diag(SIGNS[which]), law.J_B
    J_inverse = np.linalg.inv(J)
    Omega_d = np.array((0.0, -n, 0.0))

    def rate(x: Array) -> Array:
        Q = Q0 @ so3.exp(x[:3])
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


def at_rest(law: controller.Parameters, which: int) -> controller.Parameters:
    """The law with the constant gains that [10] has where the loop rests at equilibrium `which`, having started there.

    |zeta| is 0 at Q = I and pi at a half turn.
    """
    angle = math.pi if which else 0.0
    return replace(
        law,
        gain_schedule="constant",
        kappa0=attitude_scale(law.kappa0, law.a1, law.a2, angle, angle),
        lambda0=rate_scale(law.lambda0, law.c1, law.c2, 0.0, 0.0),
    )


def _ordered(values: Array) -> Array:
    return values[np.lexsort((values.imag, -values.real))]
