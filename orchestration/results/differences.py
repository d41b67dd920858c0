"""How far two results of the same signals lie apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from ..quantities import ONE, QuantityError
from .data import RunData, unit_text
from .html import rows

_COLUMNS = ("signal", "largest", "rms", "at, s", "unit")


@dataclass(frozen=True)
class Difference:
    """Difference of one signal, over all its elements, in `unit`."""

    largest: float
    """Of the magnitudes."""
    rms: float
    time: float
    """When it is largest, s."""
    unit: str


class Differences(dict[str, Difference]):
    """The difference of each signal by its name."""

    def _rows(self) -> list[tuple[str, ...]]:
        return [(name, f"{d.largest:.4g}", f"{d.rms:.4g}", f"{d.time:.6g}", d.unit) for name, d in self.items()]

    def __repr__(self) -> str:
        lines = [_COLUMNS, *self._rows()]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        return "\n".join("  ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)).rstrip() for line in lines)

    def _repr_html_(self) -> str:
        return Markup("<table>{}</table>").format(rows([_COLUMNS, *self._rows()]))


def compare(a: RunData, b: RunData) -> Differences:
    """Returns the differences b - a of the signals that both have, at the instants that both have, in the units of `a`.

    Raises ValueError where they have no instant in common.
    """
    time, of_a, of_b = np.intersect1d(a.time, b.time, return_indices=True)
    if not len(time):
        raise ValueError("the results have no instant in common")
    found = Differences()
    for name in a:
        if name not in b:
            continue
        ours, theirs = (np.asarray(r[name][rows], float) for r, rows in ((a, of_a), (b, of_b)))
        unit, other = a.variable(name).unit or ONE, b.variable(name).unit or ONE
        if ours.shape != theirs.shape or not other.fits(unit):
            continue
        try:
            factor, offset = other.conversion(unit)
        except QuantityError:
            continue  # a list of units, which has no factor
        apart = np.abs(factor * theirs + offset - ours).reshape(len(time), -1)
        sample = int(apart.max(axis=1).argmax())
        largest, rms = float(apart[sample].max()), float(np.sqrt(np.mean(apart * apart)))
        found[name] = Difference(largest, rms, float(time[sample]), unit_text(a.variable(name).unit))
    return found
