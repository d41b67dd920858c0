"""Metrics: a run in a number each."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from .expectations import Bound, Span
from .references import Reference
from .types import UnitName


class Metric(Span):
    """A number that a run is measured by. Exactly one of `statistic`, `settles`, `reaches`, `share` and `python`."""

    name: Annotated[str, Field(strict=True, pattern=r"^[A-Za-z_]\w*$")]
    """Its name in requirements and in the dataset: letters, digits and `_`."""
    signal: Reference | None = None
    """The signal that is measured, recorded or not: `judge.attitude_error`."""
    statistic: Literal["final", "maximum", "mean", "minimum", "peak", "rms"] | None = None
    """Its last value, the largest, the mean, the smallest, the largest magnitude, or the root of the mean square."""
    settles: Bound | None = None
    """The time from which the signal meets the bound to the end, s; infinite where it does not at the end."""
    reaches: Bound | None = None
    """The first time at which the signal meets the bound, s; infinite where it never does."""
    share: Bound | None = None
    """The share of the samples that meet the bound, from 0 to 1."""
    python: Annotated[str, Field(strict=True, pattern=r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$")] | None = None
    """`module:function`, which is given the times (n,) and a dictionary of the `signals` (n, elements), and returns
    the number. The code runs as you do, without any guard."""
    signals: list[Reference] = []
    """The signals that the Python function is given, at every base step."""
    unit: UnitName | None = None
    """The metric's unit; default: the signal's, or the bound's; `s` of times."""

    @model_validator(mode="after")
    def _one(self) -> Metric:
        if self.kind == "python":
            beside = [name for name in ("signal", "after", "before", "when") if getattr(self, name) is not None]
            if beside or self.measure != "element":
                without = " and ".join(beside) or "measure"
                raise ValueError(f"a Python function goes without {without}; expected 'signals'")
            if not self.signals:
                raise ValueError("a Python function needs 'signals', which it is given")
        elif self.signal is None:
            raise ValueError("'signal' is missing: the signal that is measured")
        elif self.signals:
            raise ValueError("'signals' are those of a Python function; expected 'signal'")
        return self

    @property
    def kind(self) -> str:
        """The one of five that is given."""
        return self._only("statistic", *BOUNDS, "python")


BOUNDS = ("settles", "reaches", "share")
"""The kinds that hold the signal against a bound."""
