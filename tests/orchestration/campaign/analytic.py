"""Functions of the unit cube in place of runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Analytic:
    """A function of points in the unit cube, asked as the engine is. Where `fails` is true a run fails."""

    def __init__(
        self,
        function: Callable[[Floats], Floats],
        entries: list[tuple[str, int, int]],
        fails: Callable[[Floats], NDArray[np.bool_]] = lambda u: np.zeros(len(u), bool),
        bounded: bool = True,
    ) -> None:
        self.function, self.fails, self.entries = function, fails, entries
        self.dimension = sum(count for _, _, count in entries)
        self.coordinates = [f"{name} ({i + 1})" for name, _, count in entries for i in range(count)]
        self.bounded = [bounded] * self.dimension
        self.metrics = {"y": ""}
        self.reasons: dict[str, int] = {}
        self.asked: list[Floats] = []

    def fly(self, unit: Floats) -> dict[str, Floats]:
        assert unit.shape[1] == self.dimension
        assert ((unit > 0.0) & (unit < 1.0)).all()
        self.asked.append(unit)
        failed = self.fails(unit)
        if failed.any():
            self.reasons["it broke"] = self.reasons.get("it broke", 0) + int(failed.sum())
        return {"y": np.where(failed, np.nan, self.function(unit))}

    def values(self, unit: Floats) -> dict[str, Any]:
        return {name: unit[first : first + count].tolist() for name, first, count in self.entries}

    def scenario(self, unit: Floats) -> str:
        return f"name: at {unit.tolist()}\n"


def separate(count: int) -> list[tuple[str, int, int]]:
    """Entries of one coordinate each: a, b, c..."""
    return [("abcdefgh"[i], i, 1) for i in range(count)]


def ishigami(unit: Floats) -> Floats:
    """sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1, x uniform in (-pi, pi)."""
    x = np.pi * (2.0 * unit - 1.0)
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


ISHIGAMI = {"first": [0.3139, 0.4424, 0.0], "total": [0.5576, 0.4424, 0.2437]}
"""Its Sobol' indices, from the variance in closed form (Ishigami and Homma 1990): 1/2 + 7^2/8 + pi^4/50 + pi^8/1800."""


def peaks(unit: Floats) -> Floats:
    """A wide hill of height 1 far from a narrow one of height 1.3."""
    wide = np.exp(-((unit - 0.25) ** 2).sum(axis=1) / (2 * 0.3**2))
    return wide + 1.3 * np.exp(-((unit - 0.8) ** 2).sum(axis=1) / (2 * 0.12**2))


def ackley(unit: Floats) -> Floats:
    """Ackley's function turned upside down: a hundred hills, the highest of them, 0, at 0.7."""
    z = 6.0 * (unit - 0.7)
    hill = 20.0 * np.exp(-0.2 * np.sqrt((z**2).mean(axis=1))) - 20.0
    return hill + np.exp(np.cos(2 * np.pi * z).mean(axis=1)) - np.e


def edge(unit: Floats) -> Floats:
    """The largest value lies on an edge of the cube."""
    return unit @ np.array([1.0, -2.0, 0.5, 1.5, -1.0, 0.1])[: unit.shape[1]] + 0.5 * unit[:, 0] * unit[:, 1]
