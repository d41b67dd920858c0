"""A linear model of what was measured: A, B, C, D of the map from one sample to the next.

The answer to a pulse is known sample by sample (measure.py), and the eigensystem realization (J.-N. Juang, R. S.
Pappa, Journal of Guidance 8 (1985) 620) makes the balanced model of it: x+ = A x + B d, v = C x + D d. Its states are
those that inputs move and outputs show, in the order in which they do; the singular values tell how many are seen above
the noise. The open loop follows from S = (I + L)^-1.

Tests: tests/orchestration/margins/test_linear.py.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import control
import numpy as np
from scipy.io import savemat
from scipy.linalg import hankel, svd

from ..errors import writing
from ..fmu.model import Floats
from .analysis import Complex
from .measure import Response

SEEN = 3e-4
"""Size of a state beside the largest beneath which it is taken for noise, unless the measurement was worse."""
_ROWS = 300
"""Block rows of the Hankel matrix at most."""


@dataclass(frozen=True)
class Linear:
    """x+ = A x + B u, y = C x + D u from sample to sample.

    Of a loop it is the open one, L: of what the receiver takes, u, there comes back -y.
    """

    inputs: list[str]
    outputs: list[str]
    A: Floats
    B: Floats
    C: Floats
    D: Floats
    step: float
    """s"""
    sizes: Floats
    """Singular values of the balanced states, all that were looked at; empty where the states are observed ones."""
    error: float
    """Largest difference from what was measured, beside the largest; the verdict says of what."""
    verdict: str
    """What can be seen of the states, in words."""
    observed: tuple[str, ...] = ()
    """Names of the states, where these are outputs."""
    moved: int | None = None
    """Directions of the states that the inputs move, where these may be fewer: of the others A says nothing."""

    @property
    def states(self) -> list[str]:
        """Names of the states: balanced ones have no other than numbers."""
        return list(self.observed) or [f"x{i + 1}" for i in range(len(self.A))]

    @property
    def eigenvalues(self) -> Complex:
        """Those of A for the directions that the inputs move, the largest first."""
        values = np.linalg.eigvals(self.A)
        return np.asarray(values[np.argsort(-np.abs(values))][: self.moved])

    def system(self) -> Any:
        """Returns the model as an object of python-control, which has no dots in names."""
        said = zip(("inputs", "outputs", "states"), (self.inputs, self.outputs, self.states), strict=True)
        names = {kind: [re.sub(r"\W+", "_", label).strip("_") for label in labels] for kind, labels in said}
        return control.ss(self.A, self.B, self.C, self.D, self.step, **names)

    def save(self, path: Path) -> None:
        """Writes it as `.npz` or `.mat`, by the suffix."""
        matrices = {"A": self.A, "B": self.B, "C": self.C, "D": self.D, "step": self.step, "sizes": self.sizes}
        matrices["error"] = self.error
        names = {"inputs": self.inputs, "outputs": self.outputs, "states": self.states}
        with writing(path):
            if path.suffix == ".mat":
                savemat(path, matrices | {key: np.array(value, object) for key, value in names.items()})
            else:
                np.savez(path, **matrices, **{key: np.array(value, str) for key, value in names.items()})  # type: ignore[arg-type]


def realized(response: Response, order: int | None = None) -> Linear:
    """Returns the model of a loop's response, of this order or with the states that are seen."""
    pulse, n = response.pulse, len(response.labels)  # dv/dd: (samples, channels, channels)
    A, B, C, sizes = balanced(pulse, max(SEEN, 0.1 * float(response.error.max())), order)
    direct = np.linalg.inv(np.eye(n) + pulse[0])  # S = I + D + C (z - A)^-1 B, and L = S^-1 - I
    opened = A - B @ direct @ C, B @ direct, -direct @ C, direct - np.eye(n)
    z = np.exp(1j * response.omega * response.step)
    found = _response(A, B, C, np.eye(n) + pulse[0], z)
    error = float(np.abs(found - response.S).max() / np.abs(response.S).max())
    verdict = f"{seen(len(A), sizes)}; the model's S is within {100 * error:.2g} % of the measured one"
    return Linear(response.labels, response.labels, *opened, response.step, sizes, error, verdict)


def balanced(pulse: Floats, least: float, order: int | None = None) -> tuple[Floats, Floats, Floats, Floats]:
    """Returns A, B, C whose answer to a pulse is pulse[1:], (samples, outputs, inputs), and the sizes of their states.

    States beneath `least` of the largest are left out, or all behind `order`.
    """
    outputs, inputs = pulse.shape[1:]
    stride = max(1, len(pulse) // (2 * _ROWS))
    places = 1 + stride * np.arange(min(_ROWS, (len(pulse) - 2) // (2 * stride)))
    index = hankel(places, places[-1] + places - 1)
    H, later = (np.block([[pulse[k] for k in row] for row in rows]) for rows in (index, index + 1))
    U, sizes, V = svd(H, full_matrices=False)
    rank = order or int((sizes > max(least * sizes[0], 1e-300)).sum())
    root = np.sqrt(sizes[:rank])
    A = (U[:, :rank] / root).T @ later @ (V[:rank].T / root)
    return A, (root[:, None] * V[:rank])[:, :inputs], (U[:, :rank] * root)[:outputs], sizes[: max(4 * rank, 10)]


def seen(n: int, sizes: Floats) -> str:
    """Returns in words how many balanced states are seen."""
    after = f", the next is {sizes[n] / sizes[0]:.2g} of the first" if 0 < n < len(sizes) else ""
    return f"{n} states are seen{after}"


def _response(A: Floats, B: Floats, C: Floats, D: Floats, z: Complex) -> Complex:
    inner = z[:, None, None] * np.eye(len(A)) - A
    return np.asarray(D + C @ np.linalg.solve(inner, np.broadcast_to(B, (len(z), *B.shape))))
