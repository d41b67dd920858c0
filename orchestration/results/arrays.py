"""The numbers of a page's plots, as few as a plot needs: rows thinned out, values packed, spans joined.

A number goes into the page as four bytes where these tell it well enough for a plot, in base64. Long runs are thinned
out row by row: of every stretch of time the rows stay at which a curve is lowest and highest, so no spike is lost.
"""

from __future__ import annotations

import base64
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

MARKS = 400
"""Spans and marks in a plot, about."""
LARGEST, _SMALLEST = 1e30, 1e-30
"""Beyond the one nothing is drawn; below the other all is zero."""


Span = tuple[float, float]


@dataclass
class Arrays:
    """The arrays of a page, each once."""

    items: list[dict[str, Any]] = field(default_factory=list)
    inline: bool = False
    """Whether an array stands where it is used instead of its place: for data that are kept without a page."""
    _places: dict[tuple[str, bytes, float], int] = field(default_factory=dict)

    def add(self, values: NDArray[Any]) -> int | dict[str, Any]:
        """Returns the array's place among all, or itself."""
        return self._place(*_packed(values))

    def add_short(self, values: NDArray[Any]) -> int | dict[str, Any]:
        """Returns the same with two bytes a number, 1/32767 of the largest magnitude apart."""
        clean = np.where(np.isfinite(values), values, 0.0).astype(float)
        scale = float(np.abs(clean).max(initial=0.0)) / 32767 or 1.0
        return self._place("i2", np.round(clean / scale).astype("<i2").tobytes(), scale)

    def _place(self, kind: str, data: bytes, scale: float = 1.0) -> int | dict[str, Any]:
        place = self._places.setdefault((kind, data, scale), len(self.items))
        if place == len(self.items):
            item: dict[str, Any] = {"type": kind, "data": base64.b64encode(data).decode("ascii")}
            self.items.append({**item, "scale": scale} if kind == "i2" else item)
        return self.items[place] if self.inline else place


def kept(values: NDArray[Any], rows: int) -> NDArray[np.intp]:
    """Returns which rows of (n, k) to keep, about so many: of each stretch those of every column's extremes, and all
    where few.
    """
    n, k = values.shape
    if n <= rows:
        return np.arange(n)
    size = -(-n // max(1, rows // (2 * k + 1)))
    whole = n // size
    chosen = [np.arange(0, n, size), np.array([n - 1])]
    for first, part in ((0, values[: whole * size]), (whole * size, values[whole * size :])):
        if not len(part):
            continue
        stretches = part.reshape(-1, min(size, len(part)), k)
        begins = first + size * np.arange(len(stretches))[:, None]
        ways = [stretches.argmin(axis=1), stretches.argmax(axis=1)]
        if (
            lost := np.isnan(stretches)
        ).any():  # a gap counts as lowest and highest to NumPy, and hides those beside it
            ways += [
                np.where(lost, np.inf, stretches).argmin(axis=1),
                np.where(lost, -np.inf, stretches).argmax(axis=1),
            ]
        chosen += [(begins + way).ravel() for way in ways]
    stays = np.zeros(n, bool)
    stays[np.concatenate(chosen)] = True
    return np.flatnonzero(stays)


def _packed(values: NDArray[Any]) -> tuple[str, bytes]:
    """Bytes, least first: one for booleans, four where seven figures are enough to tell neighbours, else eight."""
    if values.dtype == np.bool_:
        return "u1", values.astype(np.uint8).tobytes()
    values = np.asarray(values, np.float64)
    finite = np.abs(values) <= LARGEST
    magnitudes = np.abs(values[finite])
    largest = float(magnitudes.max()) if len(magnitudes) else 0.0
    clean = np.where(finite, values, np.nan)
    if largest < _SMALLEST:
        return "f4", (0.0 * clean).astype("<f4").tobytes()
    spread = float(np.ptp(values[finite]))
    if 0.0 < spread < 1e-3 * largest:
        return "f8", clean.astype("<f8").tobytes()
    return "f4", clean.astype("<f4").tobytes()


def few(spans: list[Span]) -> list[Span]:
    """Spans in order; where there are too many to see, neighbours are one."""
    spans = sorted(spans)
    if len(spans) <= MARKS:
        return spans
    gap = (spans[-1][1] - spans[0][0]) / MARKS
    joined = [spans[0]]
    for a, b in spans[1:]:
        if a - joined[-1][1] <= gap:
            joined[-1] = joined[-1][0], max(b, joined[-1][1])
        else:
            joined.append((a, b))
    return joined
