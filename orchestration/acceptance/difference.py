"""How far an output of another FMU lies from ours: the largest and the rms difference, held against a tolerance.

Tests: tests/orchestration/acceptance/test_words.py, test_compare.py, test_vector.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..fmu.model import Floats, Variable
from ..quantities import shown
from .tolerances import Tolerance

ROUNDING = 1e-15
"""A difference of so much of an output's nominal value is rounding and counts as zero."""
WIDE = 0.01
"""A difference beyond this share of our largest value is named in the verdict, though a tolerance allows it."""


@dataclass
class Difference:
    """One output of theirs, and how far it is from ours on the same inputs."""

    output: str
    unit: str
    passed: bool
    tolerance: str
    largest: float | None = None
    """The largest of all elements and instants; of a boolean or an enumeration the share of samples that differ."""
    element: str = ""
    time: float | None = None
    share: float | None = None
    """`largest` over `scale`; 0 where it is rounding."""
    rms: float | None = None
    rms_share: float | None = None
    scale: float | None = None
    """Our output's largest value."""
    zero: float = 0.0
    """A difference up to this is rounding."""
    note: str = ""

    @property
    def wide(self) -> bool:
        """Returns whether a tolerance allows it, though it is no small one."""
        return self.passed and self.share is not None and self.share > WIDE


def difference(variable: Variable, ours: Floats, theirs: Floats, time: Floats, bound: Tolerance) -> Difference:
    """Returns how far an output (n, elements) lies from ours at these instants (n,), and whether that is allowed.

    Where ours is nan, nothing is compared.
    """
    found = Difference(
        variable.name, shown(variable.unit), False, bound.text, note="" if len(time) else "nothing to compare"
    )
    if not len(time):
        return found
    error = np.where(np.isnan(ours), 0.0, np.abs(theirs - ours))
    if variable.type != "real":
        differing = (error > 0.0).any(axis=1)
        found.largest = found.share = share = float(differing.mean())
        found.unit, found.passed = "", share <= min(bound.largest.limit(1.0), bound.rms.limit(1.0))
        found.time = float(time[differing][0]) if differing.any() else None
        found.note = f"{int(differing.sum())} of {len(time)} samples"
        return found
    row, column = np.unravel_index(int(error.argmax()), error.shape)
    largest, scale = float(error[row, column]), float(np.nanmax(np.abs(ours)))
    rms = float(np.sqrt((error * error).mean(axis=0).max()))
    found.largest, found.rms, found.scale, found.zero = largest, rms, scale, ROUNDING * variable.nominal
    pairs = [(largest, bound.largest), (rms, bound.rms)]
    found.passed = all(value <= max(b.limit(scale), found.zero) for value, b in pairs)
    found.share, found.rms_share = (0.0 if d <= found.zero else d / scale if scale else None for d in (largest, rms))
    if largest > found.zero:
        found.element, found.time = variable.label(int(column)) if variable.shape else "", float(time[row])
    return found
