"""What a block that is judged by itself is read of: its signals in a run, what it is told, and how explanations stand.

Tests: tests/orchestration/acceptance/test_itself.py.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...fmu.model import Element, Floats, Model
from ...results.data import RunData
from ..robustness import Trial

SMALL = 0.02
"""The share of what is looked at that may be left for an explanation to be stated, or for what has to hold."""
Explanation = tuple[str, Floats, Floats]
"""Words, and two courses that are the same where the words are true."""


@dataclass(frozen=True)
class Signals:
    """Values (n, ...) by the names of our ports, in our units, which are SI; and our parameters as the scenario tells
    them."""

    time: Floats
    values: Mapping[str, Floats]
    told: Mapping[str, Any] = field(default_factory=dict)

    def lacks(self, *names: str) -> str:
        """Returns which of these are not given, in words; empty where all are."""
        gone = [name for name in names if name not in self.values]
        return f"it does not give {' and '.join(gone)}" if gone else ""

    def wide(self, name: str) -> Floats:
        """Returns values (n, k), k = 1 for a scalar."""
        return self.values[name].reshape(len(self.time), -1)

    def parameter(self, name: str, default: Any) -> Floats:
        """Returns a parameter, (k,) of any shape, or a default."""
        return np.atleast_1d(np.asarray(self.told.get(name, default), float))


def signals(result: RunData, block: str) -> Signals:
    """Returns what a block was given and gave in a run."""
    prefix = f"{block}."
    values = {name[len(prefix) :]: np.asarray(result[name], float) for name in result if name.startswith(prefix)}
    return Signals(np.asarray(result.time, float), values)


def told(model: Model, starts: Mapping[Element, Any]) -> dict[str, Any]:
    """Returns the parameters of a block of ours as a scenario sets them, by name, in their shapes."""
    known = {**model.starts, **starts}
    found = {}
    for variable in model.of("parameter"):
        values = [known.get(element) for element in variable.elements]
        if None not in values:
            found[variable.name] = values[0] if not variable.shape else np.array(values).reshape(variable.shape)
    return found


def rms(values: Floats) -> float:
    """Returns the root of the mean square of the norms of rows."""
    return float(np.sqrt((values.reshape(len(values), -1) ** 2).sum(axis=1).mean())) if len(values) else 0.0


def apart(a: Floats, b: Floats) -> float:
    """Returns how far two courses are apart, as a share of the larger."""
    with np.errstate(all="ignore"):
        share = rms(a - b) / max(rms(a), rms(b), 1e-300)
    return share if np.isfinite(share) else np.inf


def best(explanations: Iterable[Explanation]) -> str:
    """Returns the words of the explanation that leaves least; empty where none leaves little."""
    found = [(apart(a, b), words) for words, a, b in explanations]
    least, words = min(found, key=lambda one: one[0], default=(np.inf, ""))
    return f"{words} (leaves {100 * least:.2g} %)" if least <= SMALL else ""


def judged(name: str, left: float, explanations: Iterable[Explanation], symptom: str, allowed: float = SMALL) -> Trial:
    """Returns a trial: met where little is left; else failed with the explanation, or with the symptom."""
    if left <= allowed:
        return Trial(name, "met", f"within {100 * left:.2g} %")
    words = best(explanations)
    return Trial(name, "failed", words or f"{symptom}; no usual unit, sign or frame explains it")


def between(values: Floats) -> Floats:
    """Returns the means (n - 1, ...) of neighbours."""
    return 0.5 * (values[1:] + values[:-1])


def rate(values: Floats, time: Floats) -> Floats:
    """Returns the differences of neighbours over the time between."""
    return np.diff(values, axis=0) / np.diff(time).reshape(-1, *(1 for _ in values.shape[1:]))


def factors(words: Mapping[str, float], a: Floats, b: Floats) -> list[Explanation]:
    """Returns for each name of a unit what a is where b has been given in it."""
    return [(text, a, factor * b) for text, factor in words.items()]


def along(matrices: Floats, vectors: Floats) -> Floats:
    """Returns matrices (n, 3, 3) times vectors (n, 3)."""
    return np.einsum("nij,nj->ni", matrices, vectors)


def transposed(matrices: Floats) -> Floats:
    return matrices.transpose(0, 2, 1)


def axes_and_angles(matrices: Floats) -> tuple[Floats, Floats]:
    """Returns axes (n, 3), as long as the sine of the angle, and angles (n,), rad, of rotation matrices (n, 3, 3)."""
    axes = 0.5 * np.stack([matrices[:, i, j] - matrices[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=1)
    cosine = 0.5 * (np.trace(matrices, axis1=1, axis2=2) - 1.0)
    return axes, np.arctan2(np.linalg.norm(axes, axis=1), cosine)


def number(values: Sequence[float] | Floats) -> str:
    """Returns numbers in brackets."""
    return "[" + ", ".join(f"{value:.3g}" for value in np.ravel(values)) + "]"
