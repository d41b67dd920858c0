"""How far an output may differ from ours: absolute with a unit, or a share of our output's largest value.

A tolerance is a number or text, for the largest difference, or `{largest: ..., rms: ...}`. Under `default`
stands what counts for outputs without their own: a share. Of a boolean it is the share of samples that differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError, as_written, hint
from ..fmu.model import Model, Variable
from ..quantities import ONE, QuantityError, parse
from ..scenario.text import read

DEFAULT = 1e-6


@dataclass(frozen=True)
class Bound:
    """A bound on a difference. `share` is of our output's largest value, `absolute` in the port's unit."""

    share: float | None = None
    absolute: float | None = None
    text: str = ""

    def limit(self, peak: float) -> float:
        return self.absolute if self.absolute is not None else (self.share or 0.0) * peak


@dataclass(frozen=True)
class Tolerance:
    """What is asked of one output."""

    largest: Bound | None
    rms: Bound | None = None


def tolerances(texts: Sequence[str], model: Model) -> dict[str, Tolerance]:
    """The tolerance of each output, from options such as `0.1 %`, `dipole=0.2 A.m2` and `tolerances.yaml`.

    Raises InputError where one is no tolerance, or of an output that there is not.
    """
    outputs = {v.name: v for v in model.of("output")}
    default = Tolerance(Bound(share=DEFAULT, text=f"{DEFAULT:g} of the largest"))
    bounds: dict[str, Tolerance] = {}
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
                    default = Tolerance(_share(value))
                else:
                    bounds[name] = _tolerance(value, outputs[name])
            except QuantityError as error:
                raise InputError(f"{where}: {error}") from None
    # A boolean either is as ours or is not: the default share of a number's size means nothing for it.
    same = Tolerance(Bound(share=0.0, text="no sample"))
    for name, variable in outputs.items():
        bounds.setdefault(name, default if variable.type == "real" else same)
    return bounds


def _share(value: Any) -> Bound:
    number, unit = parse(value) if isinstance(value, str) else (value, None)
    if (
        isinstance(number, bool)
        or not isinstance(number, (int, float))
        or (unit is not None and unit.exponents != ONE.exponents)
    ):
        raise QuantityError(f"expected a share such as 1e-6 or '0.1 %', found {as_written(value)}")
    share = number * (unit.factor if unit else 1.0)
    return Bound(share=share, text=f"{share:g} of the largest")


def _tolerance(value: Any, variable: Variable) -> Tolerance:
    if isinstance(value, dict):
        if not value or set(value) - {"largest", "rms"}:
            raise QuantityError(f"expected largest and rms, found {', '.join(map(str, value)) or 'nothing'}")
        return Tolerance(*(_bound(value[key], variable) if key in value else None for key in ("largest", "rms")))
    return Tolerance(_bound(value, variable))


def _bound(value: Any, variable: Variable) -> Bound:
    number, unit = parse(value) if isinstance(value, str) else (value, None)
    if isinstance(number, bool) or not isinstance(number, (int, float)) or not 0.0 <= number < float("inf"):
        raise QuantityError(
            f"expected a tolerance such as '0.1 %' or '0.2 {variable.unit or ONE}', found {as_written(value)}"
        )
    if unit is not None and unit.name == "%":
        what = "of samples" if variable.type != "real" else "of the largest"
        return Bound(share=number / 100, text=f"{number:g} % {what}")
    own = variable.unit or ONE
    if unit is not None and not unit.fits(own):
        raise QuantityError(f"the unit {str(unit)!r} does not fit that of {variable.name}, {own}")
    absolute = number * (unit.factor / own.factor if unit is not None else 1.0)
    shown = f" {unit or own}" if str(unit or own) != "1" else ""
    return Bound(absolute=absolute, text=f"{number:g}{shown}")
