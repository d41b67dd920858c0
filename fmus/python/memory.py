"""A block's values as FMI sees them, a flat list by value reference, and as the block sees them, its dataclasses.

Carried by every Python FMU, so it needs the standard library and numpy only. Tests: tests/fmus/python/test_slave.py.
"""

from __future__ import annotations

import base64
import dataclasses
import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from operator import attrgetter, itemgetter
from types import ModuleType
from typing import Any

import numpy as np

from ..variables import Causality, Interface, Variable
from .asked import Asked, look
from .written import SCALARS, writer

Values = list[Any]


class ContractError(TypeError):
    """A block's dataclasses and its interface differ; the message names the first difference."""


@dataclass(frozen=True)
class Snapshot:
    """All that an instance remembers. The objects within are never changed in place, so a snapshot may share them."""

    values: tuple[Any, ...]
    mode: str
    time: float
    begin: float
    stop: float | None
    instants: int
    held: bool
    dirty: bool
    state: Any
    error: str | None = None
    """Why these bytes are no snapshot: the message of the call that restores it."""


class Layout:
    """Places of a block's ports and parameters in the flat list, and the conversions both ways."""

    def __init__(self, interface: Interface, block: ModuleType) -> None:
        self.starts: Values = [_start(v, e.start) for v, e in interface.elements.values()]
        self.names = list(interface.elements)
        self.parameters = _reader(interface, block, "parameter", "Parameters")
        self.inputs = _reader(interface, block, "input", "Inputs")
        outputs = [interface.variables[name] for name in _fields(interface, block, "output", "Outputs")]
        variables = list(interface.variables.values())
        self.of_type = {kind: _references(v for v in variables if _fmi_type(v) == kind) for kind in FMI_TYPES}
        self.output_references = _references(v for v in variables if v.causality == "output")
        self.parameter_references = _references(v for v in variables if v.causality == "parameter")
        self.settable = self.parameter_references | _references(v for v in variables if v.causality == "input")
        self.tunable = self.settable - _references(v for v in variables if v.variability == "fixed")
        self.bounds = {r: bounds for v in variables if (bounds := _bounds(v)) for r in v.value_references}
        periods = [v.value_references[0] for v in variables if v.of_shell]
        self.sample_period: Callable[[Values], float] = lambda values: values[periods[0]] if periods else 0.0
        self._asked: dict[tuple[str, tuple[int, ...]], Asked] = {}
        scalars, arrays = ([v for v in outputs if bool(v.shape) is shaped] for shaped in (False, True))
        self._get_scalars, self._get_arrays = (_all(attrgetter, [v.name for v in some]) for some in (scalars, arrays))
        self._scalar_places = [(v.value_references[0], writer(v)) for v in scalars]
        self._array_places = [(v.value_references[0], v.value_references[-1] + 1, v.shape, writer(v)) for v in arrays]
        self._outputs = outputs
        self._real_places = [r for v in outputs if v.type == "real" for r in v.value_references]
        self._reals = _all(itemgetter, self._real_places)

    def asked(self, kind: str, references: list[int]) -> Asked:
        """Returns what is asked of these value references, for the functions of this type."""
        key = kind, tuple(references)
        if key not in self._asked:
            if len(self._asked) >= _ASKED_MAX:
                self._asked.clear()
            whole = self.of_type[kind], self.settable, self.tunable
            some = self.output_references, self.parameter_references, self.bounds.keys()
            self._asked[key] = look(references, whole, some)
        return self._asked[key]

    def store(self, outputs: Any, values: Values) -> Values:
        """A copy of the values with a block's `Outputs` put in. Raises ValueError for one that is not
        finite, and ContractError."""
        values = values.copy()
        try:
            for (place, convert), value in zip(self._scalar_places, self._get_scalars(outputs), strict=True):
                values[place] = convert(value)
            for (first, after, shape, write), value in zip(self._array_places, self._get_arrays(outputs), strict=True):
                if value.shape != shape:
                    raise ContractError  # told below
                values[first:after] = write(value)
            finite = math.isfinite(sum(self._reals(values)))
        except (AttributeError, TypeError, ValueError, OverflowError):
            raise self._differs(outputs) from None
        if not finite:
            for r in self._real_places:
                if not math.isfinite(values[r]):
                    raise ValueError(f"output {self.names[r]} is {values[r]}; expected a finite number")
        return values

    def _differs(self, outputs: Any) -> ContractError:
        """The error that names the first of a block's outputs that is not as its interface says."""
        for variable in self._outputs:
            value = getattr(outputs, variable.name)
            array = isinstance(value, np.ndarray) and value.dtype.kind in "biuf"
            if variable.shape and not (array and value.shape == variable.shape):
                found = f"one of shape {value.shape}, {value.dtype}" if isinstance(value, np.ndarray) else repr(value)
                return ContractError(
                    f"output {variable.name}: expected an array of shape {variable.shape}, found {found}"
                )
            try:
                writer(variable)(value)
            except (TypeError, ValueError, OverflowError):
                kind = f"one of {', '.join(variable.items)}" if variable.items else f"a scalar, {variable.type}"
                return ContractError(f"output {variable.name}: expected {kind}, found {value!r}")
        return ContractError("the outputs of the block are not as its interface says")


def _all(getter: Callable[..., Any], names: Sequence[Any]) -> Callable[[Any], Sequence[Any]]:
    """`attrgetter` or `itemgetter` of any number of names, also of one or none; it gives a tuple."""
    if len(names) > 1:
        return getter(*names)
    getters = [getter(name) for name in names]
    return lambda whole: tuple(get(whole) for get in getters)


_ASKED_MAX = 100
"""Lists of value references that are kept."""
FMI_TYPES = ("Real", "Integer", "Boolean", "String")
"""Those with functions to get and set; an enumeration goes as an Integer in FMI 2.0."""


def _fmi_type(variable: Variable) -> str:
    return "Integer" if variable.type == "enumeration" else variable.type.title()


def _references(variables: Iterable[Variable]) -> frozenset[int]:
    return frozenset(r for v in variables for r in v.value_references)


def _bounds(variable: Variable) -> tuple[float, float] | None:
    low, high = variable.bounds
    if low is None and high is None:
        return None
    return (-math.inf if low is None else low, math.inf if high is None else high)


def _start(variable: Variable, start: Any) -> Any:
    if variable.type == "enumeration":
        return 1 if start is None else int(start)
    return SCALARS[variable.type](start or "") if variable.type == "string" else SCALARS[variable.type](start or 0)


def _fields(interface: Interface, block: ModuleType, causality: Causality, record: str) -> list[str]:
    expected = [v.name for v in interface.of(causality)]
    fields = dataclasses.fields(getattr(block, record))
    # What only a set of parts has has a default, and stands last.
    names = [f.name for f in fields if f.name in expected or f.default is dataclasses.MISSING or not interface.sets]
    if difference := sorted(set(names) ^ set(expected)):
        where = "interface" if difference[0] in names else f"{block.__name__}.{record}"
        raise ContractError(f"{causality} {difference[0]!r} is missing in the {where} of {interface.name}")
    return names


def _reader(interface: Interface, block: ModuleType, causality: Causality, record: str) -> Callable[[Values], Any]:
    """A function that makes the block's dataclass from the flat list."""
    names = _fields(interface, block, causality, record)
    readers = [_field_reader(interface.variables[name]) for name in names]
    make = getattr(block, record)
    return lambda values: make(*[read(values) for read in readers])


def _field_reader(variable: Variable) -> Callable[[Values], Any]:
    first, after = variable.value_references[0], variable.value_references[-1] + 1
    if variable.type == "enumeration":
        return lambda values: variable.items[values[first] - 1]
    if not variable.shape:
        return lambda values: values[first]
    if len(variable.shape) == 1:
        return lambda values: np.array(values[first:after])
    return lambda values: np.array(values[first:after]).reshape(variable.shape)


def to_bytes(snapshot: Snapshot, identity: str) -> bytes:
    """A snapshot as JSON. Exact: Python writes a float's shortest digits that read back as the same bits."""
    state = snapshot.state
    fields = (
        None if state is None else {f.name: _encode(getattr(state, f.name), f.name) for f in dataclasses.fields(state)}
    )
    return json.dumps({"identity": identity, **vars(snapshot), "state": fields}, separators=(",", ":")).encode()


def from_bytes(data: bytes, identity: str, block: ModuleType) -> Snapshot:
    """Reads what `to_bytes` wrote. Bytes of another FMU or none at all make a snapshot that holds the error."""
    try:
        entries = json.loads(data)
        if (found := entries.pop("identity")) != identity:
            raise ValueError(f"it was saved by another build, {found}; this is {identity}")
        fields = entries.pop("state")
        state = None if fields is None else block.State(**{name: _decode(value) for name, value in fields.items()})
        entries |= {"values": tuple(entries["values"]), "state": state}
        return Snapshot(**entries)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        return Snapshot(
            (), "", math.nan, 0.0, None, 0, False, True, None, f"the serialized FMU state cannot be restored: {error}"
        )


def _encode(value: Any, name: str) -> Any:
    if value is None or type(value) in (bool, int, float, str):
        return value
    if isinstance(value, (np.ndarray, np.generic)) and value.dtype.kind in "biuf":
        bits = base64.b64encode(np.ascontiguousarray(value).tobytes()).decode()
        return {
            "dtype": value.dtype.str,
            "shape": list(value.shape),
            "scalar": isinstance(value, np.generic),
            "bits": bits,
        }
    raise ContractError(f"State.{name} is a {type(value).__name__}; expected a float, bool, int, array or None")


def _decode(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    array = (
        np.frombuffer(base64.b64decode(value["bits"]), dtype=np.dtype(value["dtype"])).reshape(value["shape"]).copy()
    )
    return array[()] if value["scalar"] else array


def check_state(state: Any) -> None:
    """Raises ContractError where a state holds what cannot be serialized."""
    if state is not None:
        for f in dataclasses.fields(state):
            _encode(getattr(state, f.name), f.name)


def first_not_finite(values: Sequence[float]) -> int | None:
    """The position of the first value that is not finite."""
    return next((i for i, value in enumerate(values) if not math.isfinite(value)), None)
