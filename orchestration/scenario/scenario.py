"""What a scenario file may say: these models are its schema.

`orchestrate schema` prints it as JSON Schema, for editors.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PrivateAttr,
    WithJsonSchema,
    model_validator,
)

from ..errors import said
from ..quantities import SECOND, QuantityError, parse, value_in
from .mapping import MapEntry
from .source import Key, Source


def _seconds(value: Any) -> float:
    try:
        return value_in(value, SECOND)
    except QuantityError as error:
        raise ValueError(f"{error}; expected seconds, or text such as '10 min'") from None


def _positive(value: float) -> float:
    if value <= 0.0:
        raise ValueError(f"expected a time above zero, found {value:g} s")
    return value


def _quantity(value: Any) -> Any:
    if isinstance(value, str):
        try:
            parse(value)
        except QuantityError as error:
            raise ValueError(str(error)) from None
    elif isinstance(value, bool) or not isinstance(value, (int, float)) or value != value:
        raise ValueError(f"expected a number or text with a unit, found {said(value)}")
    return value


_NUMBER_OR_TEXT: list[dict[str, Any]] = [{"type": "number"}, {"type": "string"}]
Time = Annotated[float, BeforeValidator(_seconds), WithJsonSchema({"anyOf": _NUMBER_OR_TEXT})]
Period = Annotated[Time, AfterValidator(_positive)]
Quantity = Annotated[Any, BeforeValidator(_quantity), WithJsonSchema({"anyOf": _NUMBER_OR_TEXT})]
_VALUE = {"anyOf": [*_NUMBER_OR_TEXT, {"type": "boolean"}, {"type": "array"}]}
Value = Annotated[Any, WithJsonSchema(_VALUE)]
_REFERENCE = re.compile(r"([A-Za-z_]\w*)\.(\S+?)((?:\[\s*\d+\s*(?:,\s*\d+\s*)*\])*)")


class Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)


Flavour = Literal["native", "python"]
Isolation = Literal["process", "none"]

_BYTES = {"": 1, "B": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12, "KiB": 2**10, "MiB": 2**20, "GiB": 2**30}


def _bytes(value: Any) -> int:
    match = re.fullmatch(r"\s*(\d+\.?\d*)\s*([A-Za-z]*)\s*", str(value))
    if match is None or match[2] not in _BYTES or isinstance(value, bool):
        raise ValueError(f"expected an amount of memory such as '2 GB', found {said(value)}")
    size = float(match[1]) * _BYTES[match[2]]
    if size > 1e18:
        raise ValueError(f"expected at most 1e18 bytes, found {size:g}")
    count = round(size)
    if count < 10**6:
        raise ValueError(f"expected at least 1 MB, found {count} bytes")
    return count


Bytes = Annotated[int, BeforeValidator(_bytes), WithJsonSchema({"anyOf": _NUMBER_OR_TEXT})]


class BlockEntry(Model):
    """A block of the loop: an FMU, how often it is stepped and its start values."""

    fmu: str = Field(strict=True, min_length=1)
    """One of the project's own blocks by its name, or the path of an .fmu file, relative to the scenario."""
    flavour: Flavour | None = None
    """Which build of one of the project's own blocks; default: the scenario's."""
    isolation: Isolation | None = None
    """Whether the FMU runs in a process of its own; default: the scenario's."""
    timeout: Period | None = None
    """How long one call of an FMU in a process of its own may take before it is ended; default: 60 s."""
    memory: Bytes | None = None
    """How much memory an FMU in a process of its own may take, such as `500 MB` (on Linux only); default: 4 GB, or half of
    the machine's where that is less."""
    every: int = Field(1, strict=True, ge=1)
    """Stepped once in so many base steps, over all of them."""
    interface: Annotated[str, Field(strict=True, min_length=1)] | None = None
    """The interface that the FMU has to keep, or is mapped to: one of the project's own by its name, or the path of a
    reference .fmu. Default for an FMU given by its path: the block's name, if the project has such an interface."""
    map: MapEntry | None = None
    """How the FMU's ports stand to those of the interface: a mapping, or the path of one, relative to the scenario."""
    start: dict[str, Value] = {}
    """Start values of parameters and inputs: numbers in the unit of the port, or text with a unit; vectors and
    matrices as lists; one element as `name[2]`; items of enumerations by their names."""


class Record(Model):
    """What is recorded, and how often."""

    interval: Period | None = None
    """Time from sample to sample, a multiple of the base step, which is the default."""
    signals: list[Annotated[str, Field(strict=True)]] | None = None
    """Names such as `plant.omega_B`, `plant.x[2]` or `plant.*` (all outputs). Default: all outputs of all blocks."""


class Bound(Model):
    """What a signal is held against; exactly one of these."""

    below: Quantity | None = None
    """x < bound"""
    above: Quantity | None = None
    """x > bound"""
    within: Annotated[
        Any, WithJsonSchema({"anyOf": [*_NUMBER_OR_TEXT, {"type": "array", "minItems": 2, "maxItems": 2}]})
    ] = None
    """|x| <= bound, or low <= x <= high for `[low, high]`"""
    equals: Annotated[Any, WithJsonSchema({"anyOf": [*_NUMBER_OR_TEXT, {"type": "boolean"}]})] = None
    """x = bound: a boolean, a whole number or an item of an enumeration"""

    @model_validator(mode="after")
    def _one(self) -> Bound:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(
                f"expected exactly one of below, above, within, equals; found {' and '.join(given) or 'none'}"
            )
        if isinstance(self.within, list):
            if len(self.within) != 2:
                raise ValueError(f"within: expected one number or [low, high], found {self.within!r}")
            for end in self.within:
                _quantity(end)
        elif self.within is not None:
            _quantity(self.within)
        return self

    @property
    def kind(self) -> str:
        return next(name for name in type(self).model_fields if getattr(self, name) is not None)


class Expectation(Model):
    """What the run is expected to show. Exactly one of `always`, `ever` and `zeros`."""

    name: str = Field(strict=True, min_length=1)
    """A sentence that reads well in the table at the end."""
    signal: str = Field(strict=True)
    """The signal that is looked at, recorded or not: `plant.omega_B` or one element, `plant.omega_B[2]`."""
    measure: Literal["element", "norm"] = "element"
    """Each element for itself, or the Euclidean norm of the vector."""
    after: Time | None = None
    """Only samples from this time on."""
    before: Time | None = None
    """Only samples up to this time."""
    when: Annotated[str, Field(strict=True)] | None = None
    """Only samples at which this boolean signal is true; there must be one."""
    always: Bound | None = None
    """Every sample meets the bound."""
    ever: Bound | None = None
    """At least one sample meets the bound, in every element."""
    zeros: Annotated[int, Field(strict=True, ge=0)] | None = None
    """How often the signal changes its sign."""

    @model_validator(mode="after")
    def _one(self) -> Expectation:
        given = [name for name in ("always", "ever", "zeros") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"expected exactly one of always, ever, zeros; found {' and '.join(given) or 'none'}")
        return self


class Panel(Model):
    """One plot of a figure."""

    signals: list[Annotated[str, Field(strict=True)]] = Field(min_length=1)
    """Signals of one unit, recorded or not; every element of a vector is a curve."""
    measure: Literal["element", "norm"] = "element"
    """Each element for itself, or the Euclidean norm of the vector."""
    unit: Annotated[str, Field(strict=True)] | None = None
    """Unit of the axis; default: the FMU's display unit."""
    label: str = ""
    """Text at the axis; default: the signal's name."""
    names: list[str] = []
    """Names of the curves in the legend; default: those of the signals."""
    lines: list[Quantity] = []
    """Limits, drawn across."""


class FigureEntry(Model):
    """A figure: panels side by side over time."""

    name: Annotated[str, Field(strict=True, pattern=r"^\w[\w.-]*$")]
    """Name of the file, without its ending."""
    title: str = ""
    panels: list[Panel] = Field(min_length=1)
    shade: Annotated[str, Field(strict=True)] | None = None
    """A boolean signal; the times at which it is true are shaded."""
    mark: Annotated[str, Field(strict=True)] | None = None
    """A scalar signal whose changes of sign are marked."""
    window: Annotated[list[Time], Field(min_length=2, max_length=2)] | None = None
    """From when to when; default: the whole run."""


class HoldEntry(Model):
    """A hold: while a boolean signal is true, other signals keep their values. The summary tells what became of it."""

    name: str = Field(strict=True, min_length=1)
    """What is held: "commands"."""
    signal: Annotated[str, Field(strict=True)]
    """The boolean signal that is true while they are held."""
    keeps: list[Annotated[str, Field(strict=True)]] = Field(min_length=1)
    """The signals that keep their values."""
    limits: dict[str, Annotated[str, Field(strict=True)]] = {}
    """Boolean signals of limits, by what is to be said of them, told where the hold does not end."""


class Fault(Model):
    """What goes wrong at some time. Exactly one of `set`, `freeze`, `bias` and `cut`.

    All but `set` change what the receivers of a signal are given: all of them where the signal is an output, one of
    them where it is an input. The block that gives the signal, and what is recorded of it, stay as they are.
    """

    at: Time
    """When it begins."""
    until: Time | None = None
    """When it ends; default: never."""
    set: Annotated[str, Field(strict=True)] | None = None
    """`plant.friction = 0.1`: a tunable parameter, or an input that is not connected."""
    freeze: Annotated[str, Field(strict=True)] | None = None
    """A signal that stays at the value that it has at this time."""
    bias: Annotated[str, Field(strict=True)] | None = None
    """A signal to which `by` is added."""
    by: Value = None
    """What `bias` adds."""
    cut: Annotated[str, Field(strict=True)] | None = None
    """A signal that is lost: its receivers are given `to`."""
    to: Value = None
    """What is given instead of a signal that is cut; default: zero, or false."""

    @model_validator(mode="after")
    def _one(self) -> Fault:
        given = [name for name in ("set", "freeze", "bias", "cut") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"expected exactly one of set, freeze, bias, cut; found {' and '.join(given) or 'none'}")
        if (self.by is None) == (self.bias is not None):
            raise ValueError("'by' says what 'bias' adds; expected both or neither")
        if self.to is not None and self.cut is None:
            raise ValueError("'to' says what is given instead of a signal that is cut; found no 'cut'")
        if self.at < 0.0:
            raise ValueError(f"at: expected zero or more, found {self.at:g} s")
        if self.until is not None and self.until <= self.at:
            raise ValueError(f"until: expected a time after {self.at:g} s, found {self.until:g} s")
        return self

    @property
    def kind(self) -> str:
        return next(name for name in ("set", "freeze", "bias", "cut") if getattr(self, name) is not None)


class Cycle(Model):
    """A second axis of time in figures, such as orbits."""

    name: str = Field(strict=True, min_length=1)
    """What is counted: "orbits"."""
    period: Period
    """How long one lasts."""


class Scenario(Model):
    """A closed loop of FMUs: who takes part, how they are wired, for how long, and what is expected of it."""

    name: Annotated[str, Field(strict=True, pattern=r"^\w[\w.-]*$")]
    """Its name, and that of the results' folder: letters, digits, `.`, `_` and `-`."""
    description: str = ""
    """What the scenario shows."""
    step: Period
    """The base communication step, in seconds or as text with a unit."""
    duration: Period
    """How long the run lasts; it ends with the first step at or after this time."""
    exchange: Literal["sequential", "parallel"] = "sequential"
    """Whether a block sees what those before it gave in the same step, or all see the values of the step before."""
    flavour: Flavour = "native"
    """Which build of the project's own blocks is run: compiled C, or the Python reference."""
    isolation: Isolation | None = None
    """Whether FMUs run in processes of their own. Default: those given by a path do, the project's own blocks do not."""
    blocks: dict[Annotated[str, Field(pattern=r"^[A-Za-z_]\w*$")], BlockEntry] = Field(min_length=1)
    """The blocks, each under a name of its own."""
    connections: list[Annotated[str, Field(strict=True)]] = []
    """`plant.omega_B -> controller.omega_B`: whole variables, or single elements as `a.x[2] -> b.y`."""
    delays: list[Annotated[str, Field(strict=True)]] = []
    """Targets of connections that pass the value of the step before, to break an algebraic loop."""
    record: Record = Record()
    expect: list[Expectation] = []
    """Expectations, which decide the exit status."""
    holds: list[HoldEntry] = []
    """Holds, of which the summary tells whether and when they were released."""
    faults: list[Fault] = []
    """What goes wrong during the run."""
    figures: list[FigureEntry] = []
    """Figures that `--figures` draws."""
    cycle: Cycle | None = None
    """A second axis of time in the figures."""

    _source: Source = PrivateAttr()

    @property
    def source(self) -> Source:
        return self._source

    def error(self, key: Key, message: str) -> str:
        """The message with the place in the file that it is about."""
        return self._source.error(key, message)


def load(scenario: str | Path | Mapping[str, Any] | Source, overrides: Mapping[str, Any] | None = None) -> Scenario:
    """A scenario from a YAML file, or from the same data as a dictionary. Raises InputError.

    `overrides` are start values by `block.parameter`, and `step`, `duration` and `flavour`.
    """
    from . import complaints, source

    if isinstance(scenario, Mapping):
        scenario = Source(dict(scenario))
    elif not isinstance(scenario, Source):
        scenario = source.read(Path(scenario))
    for name, value in (overrides or {}).items():
        if name in ("step", "duration", "flavour"):
            scenario = scenario.with_value(name, value, name)
        else:
            scenario = scenario.with_start(name, value)
    return complaints.validated(Scenario, scenario)


def split(reference: str) -> tuple[str, str, tuple[int, ...]] | None:
    """Block, variable and index (from 1) of `plant.R_NB[2,3]`, also written `plant.R_NB[2][3]`; None if malformed."""
    match = _REFERENCE.fullmatch(reference.strip())
    if match is None:
        return None
    return match[1], match[2], tuple(map(int, re.findall(r"\d+", match[3])))
