"""Tracking errors [4]. Tests: tests/controller/test_law.py."""

from __future__ import annotations

from typing import NamedTuple

from . import so3
from .reference import Reference
from .so3 import Array


class Errors(NamedTuple):
    """Q (3,3); angle |zeta| rad; omega (3,) rad/s; and the reference's rates turned into body axes."""

    Q: Array
    angle: float
    omega: Array
    Omega_d_B: Array
    """Q^T Omega_d, rad/s."""
    dOmega_d_B: Array
    """Q^T dOmega_d/dt, rad/s2."""


def errors(R_NB: Array, omega_B: Array, reference: Reference) -> Errors:
    """Q = R_d^T R = exp(zeta^), omega = Omega - Q^T Omega_d [4].

    R_NB (3,3) maps B to N, omega_B (3,) rad/s is the body rate Omega.
    """
    Q = reference.R_d.T.dot(R_NB)
    to_B = Q.T
    Omega_d_B = to_B.dot(reference.Omega_d)
    return Errors(Q, so3.principal_angle(Q), omega_B - Omega_d_B, Omega_d_B, to_B.dot(reference.dOmega_d))
