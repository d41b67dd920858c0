"""What a mapping may say: how another team's ports stand to ours.

A mapping is a YAML file, or stands in the scenario under a block's `map`:

    ports:                                  # our name: theirs
      h_w: {theirs: tach, divide: 1.47e-5 kg.m2}
      b_B: {theirs: [bx, by, bz], matrix: [[0, 1, 0], [1, 0, 0], [0, 0, -1]]}
    inputs: {mag_B: plant.b_B}              # inputs that only theirs has, each with a signal of the scenario
    start: {mode: 2}                        # values of parameters and inputs that only theirs has
    ignore: [hold_fraction]                 # what of ours theirs does without

For every port, input, output or parameter, it is stated once and in one direction: theirs = A ours + c.
What a conversion of units does is not stated; both sides declare their units.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from .. import rotation
from ..errors import InputError, as_written
from ..quantities import ONE, parse, real, value_in
from . import complaints, source, text
from .references import Name, Reference
from .types import Model, UnitName


def _quantity(value: Any) -> Any:
    number = parse(value)[0] if isinstance(value, str) else value_in(value, ONE)
    if not math.isfinite(number):
        raise ValueError(f"expected a finite number, found {value}")
    return value


def _offset(value: Any) -> Any:
    for item in value if isinstance(value, list) else [value]:
        _quantity(item)
    return value


def _matrix(value: Any) -> Any:
    """Rows of numbers, all of one length."""
    if not isinstance(value, list) or not value or not all(isinstance(row, list) for row in value):
        raise ValueError(f"expected rows of numbers such as [[1, 0], [0, 1]], found {as_written(value)}")
    if len({len(row) for row in value}) != 1:
        raise ValueError("expected rows of one length")
    for number in (number for row in value for number in row):
        if isinstance(number, bool) or not isinstance(number, (int, float)):
            raise ValueError(f"expected rows of numbers, found {as_written(number)} in one")
        if not math.isfinite(real(number)):
            raise ValueError(f"expected rows of finite numbers, found {number} in one")
    return value


def _names(value: Any) -> list[Any]:
    return [value] if isinstance(value, str) else value


_Names = Annotated[list[Name], BeforeValidator(_names, json_schema_input_type=str | list[str]), Field(min_length=1)]
_Number = Annotated[Any, BeforeValidator(_quantity, json_schema_input_type=float | str)]
_Rows = Annotated[list[list[float]], BeforeValidator(_matrix)]
_Offset = Annotated[Any, BeforeValidator(_offset, json_schema_input_type=float | str | list[float | str])]


class PortMap(Model):
    """Relation of a port or parameter of theirs to ours: theirs = matrix (scale ours) + offset."""

    theirs: _Names
    """Their name; of a vector of ours also the names of their scalars, in the order of our elements."""
    unit: UnitName | None = None
    """Unit of theirs, where their FMU declares none or a wrong one."""
    scale: _Number | None = None
    """Factor from ours to theirs, with a unit where the quantities differ: `68027 rad/kg/m2`."""
    divide: _Number | None = None
    """Divisor from ours to theirs, with a unit where the quantities differ: `1.47e-5 kg.m2`."""
    matrix: _Rows | None = None
    """A, row by row, for signs and the order of axes, with our elements in a row if ours is a matrix."""
    offset: _Offset | None = None
    """c, one value or one for each of their elements, in their unit or as text with a unit."""
    quaternion: Literal["scalar first", "scalar last"] | None = None
    """Ours is a rotation matrix and theirs a unit quaternion, q v q* = R v, with its scalar there."""
    rotation: str | None = None
    """Ours is a rotation matrix and theirs three numbers: `mrp`, `rotation vector`, or `euler` and a sequence of axes,
    `euler ZYX` about the turned axes, `euler xyz` about the fixed ones."""
    turn: Annotated[str, Field(strict=True)] | None = None
    """Our input that is a rotation matrix R, where theirs has components along other axes: theirs = A R ours + c."""
    inverse: bool = Field(False, strict=True)
    """Of a rotation: theirs stands for the inverse, our matrix transposed. Of a turn: by the transposed matrix."""

    @model_validator(mode="after")
    def _one_way(self) -> PortMap:
        if self.scale is not None and self.divide is not None:
            raise ValueError("expected at most one of scale and divide")
        if self.inverse and self.quaternion is None and self.rotation is None and self.turn is None:
            raise ValueError(
                "'inverse' is of a quaternion; say 'quaternion: scalar first' or 'scalar last' as well, "
                "or a rotation or a turn"
            )
        if self.rotation is not None:
            rotation.three([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], self.rotation)
        beside = [k for k in ("unit", "scale", "divide", "matrix", "offset", "turn") if getattr(self, k) is not None]
        if self.quaternion is not None and self.rotation is not None:
            raise ValueError("expected at most one of quaternion and rotation")
        beside = [key for key in beside if self.quaternion is not None or key != "unit"]
        if (self.quaternion is not None or self.rotation is not None) and beside:
            kind = "quaternion" if self.quaternion is not None else "rotation"
            raise ValueError(f"a {kind} goes without {' and '.join(beside)}")
        for name in ("scale", "divide"):
            value = getattr(self, name)
            if value is not None and (parse(value)[0] if isinstance(value, str) else value) == 0.0:
                raise ValueError(f"{name}: expected a number other than 0")
        return self


def _port(value: Any) -> Any:
    return {"theirs": value} if isinstance(value, (str, list)) else value


def _file(value: Any) -> Any:
    return {"file": value} if isinstance(value, str) else value


_Port = Annotated[PortMap, BeforeValidator(_port, json_schema_input_type=str | list[str] | PortMap)]


class Mapping(Model):
    """Description of how another team's FMU stands in a block's place."""

    file: Annotated[str, Field(strict=True, min_length=1)] | None = None
    """A file that holds the mapping, relative to the scenario; nothing else then stands here."""
    ports: dict[str, _Port] = {}
    """Our inputs, outputs and parameters by name, each with theirs. What has our name need not be listed."""
    inputs: dict[Name, Reference] = {}
    """Inputs that only theirs has, each with the output of another block of the scenario that feeds it."""
    start: dict[Name, Any] = {}
    """Values of inputs and parameters that only theirs has, by their names."""
    ignore: list[Annotated[str, Field(strict=True)]] = []
    """Our inputs, outputs and parameters that theirs does without. The run says what is lost."""

    @model_validator(mode="after")
    def _file_alone(self) -> Mapping:
        if self.file is not None and (self.ports or self.inputs or self.start or self.ignore):
            raise ValueError("expected either a file or a mapping, found both")
        return self


MapEntry = Annotated[Mapping, BeforeValidator(_file, json_schema_input_type=str | Mapping)]
"""A mapping in a scenario, or the path of one."""


def load(path: Path) -> tuple[Mapping, source.Source]:
    """The mapping that a file holds, and the file's source for messages. Raises InputError."""
    here = Path.cwd()
    read = text.read(path.relative_to(here) if path.is_relative_to(here) else path)
    mapping = complaints.checked(Mapping, read)
    if mapping.file is not None:
        raise InputError(
            read.error(("file",), "a mapping's file holds the mapping itself; expected ports, inputs, start or ignore")
        )
    return mapping, read
