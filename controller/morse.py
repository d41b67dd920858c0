"""The attitude's error function Phi(tr(K - K Q)) and its gradient [7].

K = diag(k1, k2, k3) is given by its diagonal, (3,) N m. Tests: tests/controller/test_law.py.
"""

from __future__ import annotations

import math

import numpy as np

from .so3 import Array

PHI = ("linear", "logarithm", "square_root")


def trace(K: Array, Q: Array) -> float:
    """tr(K - K Q), J. Its critical points are Q = I, its least, and the half turns about the three axes."""
    k1, k2, k3 = K.tolist()
    (q11, _, _), (_, q22, _), (_, _, q33) = Q.tolist()
    return k1 * (1.0 - q11) + k2 * (1.0 - q22) + k3 * (1.0 - q33)


def slope_direction(K: Array, Q: Array) -> Array:
    """sum k_i e_i x Q^T e_i (3,), N m [7]: d/dt tr(K - K Q) = -omega . this, where dQ/dt = Q omega^ [5].

    Q^T e_i is row i of Q.
    """
    k1, k2, k3 = K.tolist()
    (_, q12, q13), (q21, _, q23), (q31, q32, _) = Q.tolist()
    return np.array((k2 * q23 - k3 * q32, k3 * q31 - k1 * q13, k1 * q12 - k2 * q21))


def phi(choice: str, scale: float, x: float) -> tuple[float, float]:
    """Phi(x) and Phi'(x) of one of the choices `PHI`, x and scale in J; each has Phi(0) = 0 and Phi'(0) = 1.

    'linear' x; 'logarithm' s ln(1 + x/s); 'square_root' 2 s (sqrt(1 + x/s) - 1): the last two bend beyond s.
    """
    x = max(x, 0.0)  # tr(K - K Q) is not negative; the rounding of Q may make it so
    if choice == "linear":
        return x, 1.0
    if choice == "logarithm":
        return scale * math.log1p(x / scale), 1.0 / (1.0 + x / scale)
    if choice == "square_root":
        root = math.sqrt(1.0 + x / scale)
        return 2.0 * x / (root + 1.0), 1.0 / root
    raise ValueError(f"phi: expected one of {', '.join(PHI)}, found {choice!r}")
