"""Reads how far an output may differ from ours: absolute with a unit, or a share of our output's largest value.

Each output has a tolerance of its largest difference and one of the rms difference. A number or text is that of both;
`{largest: ..., rms: ...}` gives each, `any` asks nothing of it, and one that is not given is the default.
Under `default` stands what counts for outputs without their own: a share. Of a boolean it is the share of samples
that differ. Tests: tests/orchestration/acceptance/test_compare.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeGuard

from ..errors import InputError, as_written, hint
from ..fmu.model import Model, Variable
from ..quantities import ONE, QuantityError, parse, suffix
from ..scenario.text import read

DEFAULT = 1e-6
ANY = "any"
"""The tolerance of a difference of which nothing is asked."""


@dataclass(frozen=True)
class Bound:
    """A bound on a difference: a share of our largest value, or absolute in the port's unit, infinite for any."""

    share: float | None = None
    absolute: float | None = None
    text: str = ""

    def limit(self, peak: float) -> float:
        return self.absolute if self.absolute is not None else (self.share or 0.0) * peak


@dataclass(frozen=True)
class Tolerance:
    """The bounds that are asked of one output."""

    largest: Bound
    rms: Bound

    @property
    def text(self) -> str:
        if self.largest == self.rms:
            return self.largest.text
        return f"{self.largest.text}; rms {self.rms.text}"


def tolerances(texts: Sequence[str], model: Model) -> dict[str, Tolerance]:
    """Returns the tolerance of each output, from options such as `0.1 %`, `dipole=0.2 A.m2` and `tolerances.yaml`.

    Raises InputError where one is no tolerance, or of an output that there is not.
    """
    outputs = {v.name: v for v in model.of("output")}
    default = both(Bound(share=DEFAULT, text=f"{DEFAULT:g} of ours"))
    given: dict[str, dict[str, Bound]] = {}
    for text in texts:
        if text.endswith((".yaml", ".yml")):
            source = read(Path(text))
            if not isinstance(source.data, dict):
                raise InputError(source.error((), f"expected output: tolerance, found {as_written(source.data)}"))
            entries = [(str(key), value, source.where((key,))) for key, value in source.data.items()]
        else:
            name, equals, value = text.partition("=")
            entries = [
                (name.strip(), value.strip(), f"--tolerance {text}")
                if equals
                else ("default", text, f"--tolerance {text}")
            ]
        for name, value, where in entries:
            if name != "default" and name not in outputs:
                raise InputError(f"{where}: there is no output {name!r}{hint(name, outputs)}")
            try:
                if name == "default":
                    default = both(_share(value))
                else:
                    given[name] = _tolerance(value, outputs[name])
            except QuantityError as error:
                raise InputError(f"{where}: {error}") from None
    # A boolean either is as ours or is not: the default share of a number's size means nothing for it.
    same = both(Bound(share=0.0, text="no sample"))
    return {
        name: replace(default if variable.type == "real" else same, **given.get(name, {}))
        for name, variable in outputs.items()
    }


def both(bound: Bound) -> Tolerance:
    """Returns the tolerance that asks the same of the largest and of the rms difference."""
    return Tolerance(bound, bound)


def _share(value: Any) -> Bound:
    number, unit = parse(value) if isinstance(value, str) else (value, None)
    if not _is_size(number) or (unit is not None and unit.exponents != ONE.exponents):
        raise QuantityError(f"expected a share such as 1e-6 or '0.1 %', found {as_written(value)}")
    share = number * (unit.factor if unit else 1.0)
    return Bound(share=share, text=f"{share:g} of ours")


def _is_size(number: Any) -> TypeGuard[float]:
    return isinstance(number, (int, float)) and not isinstance(number, bool) and 0.0 <= number < math.inf


def _tolerance(value: Any, variable: Variable) -> dict[str, Bound]:
    if isinstance(value, dict):
        if not value or set(value) - {"largest", "rms"}:
            raise QuantityError(f"expected largest and rms, found {', '.join(map(str, value)) or 'nothing'}")
        return {key: _bound(bound, variable) for key, bound in value.items()}
    return dict.fromkeys(("largest", "rms"), _bound(value, variable))


def _bound(value: Any, variable: Variable) -> Bound:
    if value == ANY:
        return Bound(absolute=math.inf, text=ANY)
    number, unit = parse(value) if isinstance(value, str) else (value, None)
    if not _is_size(number):
        raise QuantityError(
            f"expected a tolerance such as '0.1 %' or '0.2 {variable.unit or ONE}', found {as_written(value)}"
        )
    if unit is not None and unit.name == "%":
        what = "of samples" if variable.type != "real" else "of ours"
        return Bound(share=number / 100, text=f"{number:g} % {what}")
    own = variable.unit or ONE
    if unit is not None and not unit.fits(own):
        raise QuantityError(f"the unit {str(unit)!r} does not fit that of {variable.name}, {own}")
    absolute = number * (unit.factor / own.factor if unit is not None else 1.0)
    return Bound(absolute=absolute, text=f"{number:g}{suffix(unit or own)}")
