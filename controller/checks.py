"""Checks of the parameters: the law works with those that pass. Tests: tests/controller/test_block.py."""

from __future__ import annotations

import math

import numpy as np

from . import gains, morse, so3
from .block import REFERENCE_TOLERANCE, REFERENCES, Parameters
from .so3 import Array


def check(p: Parameters) -> None:
    """Raises ValueError for parameters that the law cannot work with."""
    for name in ("J_B", "K0", "L0", "R_d0", "Omega_d0"):
        if not np.isfinite(value := getattr(p, name)).all():
            raise ValueError(f"{name}: expected finite numbers, found {value.tolist()}")
    for name in ("phi_scale", "gravitational_parameter", "kappa0", "lambda0", "a1", "a2", "c1", "c2"):
        if not 0.0 < (value := getattr(p, name)) < math.inf:
            raise ValueError(f"{name}: expected a finite number above 0, found {value!r}")
    for name, choices in (("phi", morse.PHI), ("gain_schedule", gains.SCHEDULES), ("reference", REFERENCES)):
        if (value := getattr(p, name)) not in choices:
            raise ValueError(f"{name}: expected one of {', '.join(choices)}, found {value!r}")
    _check_positive_definite("J_B", p.J_B)
    smallest, middle, largest = np.linalg.eigvalsh(p.J_B).tolist()
    if largest > (smallest + middle) * (1.0 + 1e-9):
        raise ValueError(
            f"J_B: expected the inertia of a body, each principal moment at most the sum of the other two, "
            f"found principal moments {smallest:g}, {middle:g}, {largest:g} kg m2"
        )
    _check_positive_definite("L0", p.L0)
    k1, k2, k3 = p.K0.tolist()
    if not 0.0 < k1 < k2 < k3:
        raise ValueError(f"K0: expected 0 < K0[1] < K0[2] < K0[3], found {p.K0.tolist()}")
    so3.require_rotation("R_d0", p.R_d0, REFERENCE_TOLERANCE)


def _check_positive_definite(name: str, M: Array) -> None:
    if np.abs(M - M.T).max() > 1e-9 * np.abs(M).max():
        raise ValueError(f"{name}: expected a symmetric matrix, found {M.tolist()}")
    if not (least := float(np.linalg.eigvalsh(M)[0])) > 0.0:
        raise ValueError(
            f"{name}: expected a positive definite matrix, found its least eigenvalue {least:g}: {M.tolist()}"
        )
