"""Functions of time alone along the orbit: evaluated at nodes, interpolated between them.

Field, density and air speed at the satellite do not depend on its attitude, so they need not be
evaluated at every stage of the attitude's integrator. Tests: tests/plant/test_field.py.
"""

from __future__ import annotations

import math

import numpy as np

from .so3 import Array

NODE_INTERVAL = 10.0
"""Distance of the nodes, s."""


class AlongOrbit:
    """A vector function of time, `exact`, interpolated by degree 5 through the six nearest nodes 10 s apart.

    The nodes are a pure function of the parameters, so keeping them is no memory of the block.
    """

    def __init__(self) -> None:
        self._nodes: dict[int, Array] = {}
        self._interval: int | None = None
        self._six = np.zeros((6, 0))

    def exact(self, t: float) -> Array:
        """The function itself, (n,), at time t, s."""
        raise NotImplementedError

    def at(self, t: float) -> Array:
        """The function (n,) at time t, s, interpolated."""
        s = t / NODE_INTERVAL
        k = math.floor(s)
        if k != self._interval:
            if len(self._nodes) > 4096:
                self._nodes.clear()
            for i in range(k - 2, k + 4):
                if i not in self._nodes:
                    self._nodes[i] = self.exact(i * NODE_INTERVAL)
            self._six = np.array([self._nodes[i] for i in range(k - 2, k + 4)])
            self._interval = k
        return np.array(_lagrange6(s - k)).dot(self._six)


def _lagrange6(u: float) -> tuple[float, float, float, float, float, float]:
    """Weights of the nodes -2, -1, 0, 1, 2, 3 at u in [0, 1)."""
    a, b, c, d, e, f = u + 2.0, u + 1.0, u, u - 1.0, u - 2.0, u - 3.0
    ab, cd, ef = a * b, c * d, e * f
    return (
        b * cd * ef / -120.0,
        a * cd * ef / 24.0,
        ab * d * ef / -12.0,
        ab * c * ef / 12.0,
        ab * cd * f / -24.0,
        ab * cd * e / 120.0,
    )
