"""A linear model of what was measured: A, B, C, D of the map from one sample to the next.

The answer to a pulse is known sample by sample (measure.py), and the eigensystem realization (J.-N. Juang, R. S.
Pappa, Journal of Guidance 8 (1985) 620) makes the balanced model of it: x+ = A x + B d, v = C x + D d. Its states are
those that inputs move and outputs show, in the order in which they do; the singular values tell how many are seen above
the noise. The open loop follows from S = (I + L)^-1.

Tests: tests/orchestration/margins/test_linear.py.
"""

from __future__ import annotations

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
    """The open loop L at the samples of the site: of what the receiver takes, u, there comes back v = -L u."""

    labels: list[str]
    """Of inputs and of outputs, which are the same channels."""
    A: Floats
    B: Floats
    C: Floats
    D: Floats
    step: float
    """s"""
    sizes: Floats
    """Singular values of the closed loop's balanced states, all that were looked at."""
    error: float
    """Largest difference of S from the measured one, beside the largest S."""

    @property
    def states(self) -> list[str]:
        """Names of the states: balanced ones have no other."""
        return [f"x{i + 1}" for i in range(len(self.A))]

    @property
    def verdict(self) -> str:
        """What can be seen, in words."""
        n, sizes = len(self.A), self.sizes / self.sizes[0]
        after = f", the next is {sizes[n]:.2g} of the first" if n < len(sizes) else ""
        return f"{n} states are seen{after}; the model's S is within {100 * self.error:.2g} % of the measured one"

    def system(self) -> Any:
        """Returns the model as an object of python-control, which has no dots in names."""
        labels = [label.replace(".", "_") for label in self.labels]
        names = {"inputs": labels, "outputs": labels, "states": self.states}
        return control.ss(self.A, self.B, self.C, self.D, self.step, **names)

    def save(self, path: Path) -> None:
        """Writes it as `.npz` or `.mat`, by the suffix."""
        matrices = {"A": self.A, "B": self.B, "C": self.C, "D": self.D, "step": self.step, "sizes": self.sizes}
        names = {"inputs": self.labels, "outputs": self.labels, "states": self.states}
        with writing(path):
            if path.suffix == ".mat":
                savemat(path, matrices | {key: np.array(value, object) for key, value in names.items()})
            else:
                np.savez(path, **matrices, **{key: np.array(value) for key, value in names.items()})  # type: ignore[arg-type]


def realized(response: Response, order: int | None = None) -> Linear:
    """Returns the model of a response, of this order or with the states that are seen."""
    pulse, n = response.pulse, len(response.labels)  # dv/dd: (samples, channels, channels)
    stride = max(1, len(pulse) // (2 * _ROWS))
    places = 1 + stride * np.arange(min(_ROWS, (len(pulse) - 2) // (2 * stride)))
    index = hankel(places, places[-1] + places - 1)
    H, later = (np.block([[pulse[k] for k in row] for row in rows]) for rows in (index, index + 1))
    U, sizes, V = svd(H, full_matrices=False)
    least = max(SEEN, 0.1 * float(response.error.max()))
    rank = order or int((sizes > least * sizes[0]).sum())
    root = np.sqrt(sizes[:rank])
    A = (U[:, :rank] / root).T @ later @ (V[:rank].T / root)
    B, C, D = (root[:, None] * V[:rank])[:, :n], (U[:, :rank] * root)[:n], pulse[0]
    direct = np.linalg.inv(np.eye(n) + D)  # S = I + D + C (z - A)^-1 B, and L = S^-1 - I
    opened = A - B @ direct @ C, B @ direct, -direct @ C, direct - np.eye(n)
    z = np.exp(1j * response.omega * response.step)
    found = _response(A, B, C, np.eye(n) + D, z)
    error = float(np.abs(found - response.S).max() / np.abs(response.S).max())
    return Linear(response.labels, *opened, response.step, sizes[: max(4 * rank, 10)], error)


def _response(A: Floats, B: Floats, C: Floats, D: Floats, z: Complex) -> Complex:
    inner = z[:, None, None] * np.eye(len(A)) - A
    return np.asarray(D + C @ np.linalg.solve(inner, np.broadcast_to(B, (len(z), *B.shape))))
