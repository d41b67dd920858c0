"""The quickest way to a total momentum by dipoles across a field that is known ahead: the reference for
controller/planned/native/steering.c.

H = R (J Omega + l e1) obeys dH/dt = m x B(t). To give D with |m| <= rho in least time, T must reach the largest of the
bounds that each direction p sets, since p.(m x B) <= rho |B x p|:

    p.D <= rho integral_0^T |B x p| ds   for every unit p,  with equality for the costate p = lambda.

On the way m = rho unit(B x lambda). controller/planned/native/steering.c comes to lambda by a fixed point; here the
convex problem is solved.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize

Array = NDArray[np.float64]


def least_time(
    D_N: Array, field: Callable[[float], Array], rho: float, longest: float, step: float = 5.0
) -> tuple[Array, float]:
    """lambda (3,) and T, s, for D_N (3,) N m s, field(t) (3,) T and rho A m2. Raises ValueError beyond `longest`, s."""
    times = np.arange(0.0, longest + step, step)
    B = np.array([field(t) for t in times])
    squares = (B * B).sum(axis=1)

    def weights(T: float) -> Array:
        w = np.clip((T - times) / step + 0.5, 0.0, 1.0) * step  # each node stands for half an interval on either side
        w[0] -= 0.5 * step
        return w

    def short(T: float) -> tuple[float, Array]:
        """Momentum that is short in the worst direction, over |D|, and this direction."""
        w = weights(T)

        def cost(p: Array) -> tuple[float, Array]:
            size = np.linalg.norm(p)
            along = B @ p
            across = B @ np.array(((0.0, -p[2], p[1]), (p[2], 0.0, -p[0]), (-p[1], p[0], 0.0)))  # B x p
            lengths = np.sqrt((across * across).sum(axis=1)) + 1e-300
            value = p @ D_N - rho * (w @ lengths)
            share = w / lengths
            slope = D_N - rho * ((share @ squares) * p - (share * along) @ B)  # (B x p) x B = p |B|^2 - B (B.p)
            value, slope = value / size, slope / size - value * p / size**3
            return -value / np.linalg.norm(D_N), -slope / np.linalg.norm(D_N)

        starts = (D_N / np.linalg.norm(D_N), *B[:40:13] / np.linalg.norm(B[0]))
        found = [minimize(cost, start, jac=True, options={"gtol": 1e-10}) for start in starts]
        best = min(found, key=lambda f: float(f.fun))
        return -float(best.fun), best.x / np.linalg.norm(best.x)

    if short(longest)[0] > 0.0:
        raise ValueError(f"expected a momentum that can be given within {longest:g} s, found {D_N} N m s")
    T = brentq(lambda t: short(t)[0], 1e-3, longest, xtol=1e-2)
    return short(T)[1], float(T)
