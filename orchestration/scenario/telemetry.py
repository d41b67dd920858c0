"""A record as a block: which columns of a file are ports, and what its time column means."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, field_validator, model_validator

from .types import Model, UnitName

Text = Annotated[str, Field(strict=True, min_length=1)]
OWN = ("hold", "shift", "rows", "age", "ended")
"""What every record has beside its columns."""
Scale = Literal["UTC", "GPS", "TAI", "elapsed"]


def _listed(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


_Row = Annotated[list[Text], Field(min_length=1)]


class TimeColumn(Model):
    """The column of the rows' instants."""

    column: Text
    """Its name in the header."""
    scale: Scale
    """In which scale it counts: UTC (with leap seconds, as Unix time has it), GPS, TAI, or `elapsed`, from the start
    of the run."""
    unit: UnitName = "s"
    """The unit of a number, where the header names none behind the column; a text is a date and time in ISO 8601."""
    epoch: Text | None = None
    """The instant of the number 0, in the same scale. Default: 1970-01-01 of UTC, 1980-01-06 of GPS."""


class Column(Model):
    """A port, and the columns that it is made of."""

    of: Annotated[
        _Row | Annotated[list[_Row], Field(min_length=1)],
        BeforeValidator(_listed, json_schema_input_type=str | list[str] | list[list[str]]),
    ]
    """One column, those of a vector in their order, or a list of such for each row of a matrix."""
    unit: UnitName = "1"
    """Their unit, which is the port's. A unit in the file's header, as in `x [rad/s]`, is converted to it."""
    gain: list[tuple[float, float]] = []
    """By which the columns are multiplied first: pairs of time, s, and factor, linear between and constant beyond."""
    offset: list[float] | list[list[float]] | None = None
    """Then taken off, in their unit; where it changes, rows of time, s, and offsets, linear between and constant
    beyond."""
    matrix: Annotated[list[list[float]], Field(min_length=1)] | None = None
    """By which they are last multiplied: a row for each element of the port."""
    quaternion: Literal["scalar first", "scalar last"] | None = None
    """The port is a rotation matrix and the four columns are a unit quaternion, q v q* = R v, with its scalar there."""
    inverse: bool = Field(False, strict=True)
    """Of a quaternion: it stands for the inverse, the port is transposed."""
    missing: list[float] = []
    """Numbers that mean that there is no value, beside an empty cell and NaN."""
    required: bool = False
    """Whether a value that is missing is an error."""
    description: str = ""
    """What it is."""

    @model_validator(mode="after")
    def _whole(self) -> Column:
        rows = [row for row in self.of if isinstance(row, list)]
        if len({len(row) for row in rows}) > 1:
            raise ValueError("of: expected rows of one length")
        if rows and self.matrix is not None:
            raise ValueError("expected a 'matrix' for the columns of a vector, found rows of columns")
        if self.inverse and self.quaternion is None:
            raise ValueError("'inverse' is of a quaternion; say 'quaternion: scalar first' or 'scalar last' as well")
        if self.quaternion is not None:
            if beside := [key for key in ("gain", "offset", "matrix") if getattr(self, key)]:
                raise ValueError(f"a quaternion goes without {' and '.join(beside)}")
            if rows or len(self.of) != 4 or self.unit != "1":
                raise ValueError(f"a quaternion has 4 columns without unit, found {self.of} in {self.unit!r}")
        return self

    @property
    def cells(self) -> list[str]:
        """The columns of the file, a matrix row by row."""
        return [cell for part in self.of for cell in ([part] if isinstance(part, str) else part)]

    @property
    def shape(self) -> tuple[int, ...]:
        """The port's; that of a scalar is empty."""
        if self.quaternion is not None:
            return (3, 3)
        if isinstance(self.of[0], list):
            return (len(self.of), len(self.of[0]))
        size = len(self.of if self.matrix is None else self.matrix)
        return (size,) if size > 1 else ()


class Telemetry(Model):
    """A file of recorded columns in the place of an FMU."""

    file: Text
    """CSV with a header, or Parquet (`.parquet`), relative to the scenario. Lines that begin with # are no rows."""
    time: TimeColumn
    columns: Annotated[
        dict[Annotated[str, Field(pattern=r"^[A-Za-z_]\w*$")], Column],
        Field(min_length=1),
    ]
    """The ports by their names. Each `NAME` brings `NAME_valid` and `NAME_sample`, the number of its last sample."""
    start: Text | float | None = None
    """The instant that is t = 0 of the run, in UTC; with the scale `elapsed` a number. Default: the first row, or 0."""
    where: dict[Text, Text] = {}
    """Only rows that have this text in this column."""
    repeated: Literal["last", "first", "refused"] = "last"
    """Which of several rows of one instant counts."""
    disordered: Literal["dropped", "sorted", "refused"] = "dropped"
    """What becomes of a row that is older than one before it; `sorted` reads the whole file into memory."""

    @field_validator("columns")
    @classmethod
    def _free_names(cls, columns: dict[str, Column]) -> dict[str, Column]:
        names = [*columns, *(f"{name}_{what}" for name in columns for what in ("valid", "sample")), *OWN]
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise ValueError(
                f"expected names other than {', '.join(OWN)} and NAME_valid, NAME_sample, found {twice!r} twice"
            )
        return columns
