"""What a scenario file may say: these models are its schema.

`orchestrate schema` prints it as JSON Schema, for editors.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Annotated, Any, Literal, Unpack

from pydantic import ConfigDict, Field, PrivateAttr, field_validator, model_validator

from ..errors import Fields, Problem
from .consistency import Consistency
from .expectations import Expectation, HoldEntry
from .faults import Fault
from .figures import FigureEntry
from .live import Live
from .mapping import MapEntry
from .orbit import OrbitEntry
from .realtime import Realtime
from .references import Connection, Name, Reference, Selection
from .source import Key, Source
from .telemetry import Telemetry
from .timeline import Phases, TimelineEntry
from .types import Bytes, Extending, Flavour, Isolation, Mass, Model, Period, Value
from .view import ViewEntry


def _fmu_or_telemetry(schema: dict[str, Any]) -> None:
    schema["anyOf"] = [{"required": [key]} for key in ("fmu", "telemetry", "orbit", "python")]
    schema["properties"]["fmu"].pop("default", None)


class BlockEntry(Model):
    """A block of the loop: an FMU, a record or a law in Python, how often it is stepped and its start values."""

    model_config = ConfigDict(json_schema_extra=_fmu_or_telemetry)

    fmu: str = Field("", strict=True, min_length=1)
    """One of the project's own blocks by its name, or the path of an .fmu file, relative to the scenario."""
    telemetry: Telemetry | None = None
    """In place of `fmu`: a file of recorded columns, which are outputs at the instants of its rows."""
    orbit: OrbitEntry | None = None
    """In place of `fmu`: position and velocity by element sets, as a record; beside `fmu`: start values that put the
    block on that orbit."""
    python: str | None = Field(None, strict=True, min_length=1)
    """In place of `fmu`: the path of a Python file, relative to the scenario, with a function
    `step(inputs, parameters, t, h)` or one class with it. Its ports are those of `interface`;
    over an FMU of a file that is extended it keeps that one's, with its start values."""
    flavour: Flavour | None = None
    """Which build of one of the project's own blocks; default: the scenario's."""
    isolation: Isolation | None = None
    """Whether the FMU or the law runs in a process of its own; default: the scenario's."""
    validation: Literal["strict", "lenient"] = "strict"
    """Whether an FMU whose modelDescription.xml is not valid is refused, or runs as far as it can be read, each
    finding a warning."""
    timeout: Period | None = None
    """How long one call of an FMU in a process of its own may take before it is ended; default: 60 s."""
    memory: Bytes | None = None
    """How much memory an FMU in a process of its own may take, such as `500 MB` (on Linux only); default: 4 GB, or
    half of the machine's where that is less."""
    every: int = Field(1, strict=True, ge=1)
    """Stepped once in so many base steps, over all of them."""
    interface: Annotated[str, Field(strict=True, min_length=1)] | None = None
    """The interface that the FMU has to keep, or is mapped to: one of the project's own by its name, or the path of a
    reference .fmu. Default for an FMU given by its path: the block's name, if the project has such an interface."""
    map: MapEntry | None = None
    """How the FMU's ports stand to those of the interface: a mapping, or the path of one, relative to the scenario."""
    start: dict[Name, Value] = {}
    """Start values of parameters and inputs: numbers in the unit of the port, or text with a unit; vectors and
    matrices as lists; one element as `name[2]`; items of enumerations by their names; a matrix also as
    `{diagonal: [1, 2, 3]}`, `{axis: [1, 0, 0], angle: 90 deg}`, `{euler: [10 deg, 0, 0], sequence: ZYX}` or
    `{quaternion: [1, 0, 0, 0]}`, scalar first."""
    differs: list[Annotated[str, Field(strict=True, min_length=1)]] = []
    """Parameters whose values are meant to differ from those of the same quantity in other blocks: no warning then."""

    @model_validator(mode="after")
    def _one_of_both(self) -> BlockEntry:
        for alone in ("telemetry", "python"):
            others = [key for key in ("fmu", "orbit", "telemetry", "python") if key != alone and getattr(self, key)]
            if getattr(self, alone) and others:
                raise ValueError(f"expected '{alone}' alone, found '{others[0]}', too")
        if not (self.fmu or self.telemetry or self.orbit or self.python):
            raise ValueError("expected either 'fmu', 'telemetry', 'orbit' or 'python', found neither")
        return self


class Record(Model):
    """Signals that are recorded, and how often."""

    interval: Period | None = None
    """Time from sample to sample, a multiple of the base step, which is the default."""
    signals: list[Selection] | None = None
    """Names such as `plant.omega_B`, `plant.x[2]` or `plant.*` (all outputs). Default: all outputs of all blocks."""


class Data(Model):
    """Values of a data sheet that no block takes."""

    mass: Mass | None = None
    """In kg, or as text with a unit. `orchestrate plausible`, `review` and the notes of a run compare it with the
    inertia."""


class Cycle(Model):
    """A second axis of time in figures, such as orbits."""

    name: str = Field(strict=True, min_length=1)
    """What is counted: "orbits"."""
    period: Period
    """How long one lasts."""


class Scenario(Extending):
    """A closed loop of FMUs: who takes part, how they are wired, for how long, and what is expected of it."""

    name: Annotated[str, Field(strict=True, pattern=r"^\w[\w.-]*$", max_length=200)]
    """Its name, and that of the results' folder: letters, digits, `.`, `_` and `-`."""
    description: str = ""
    """What the scenario shows."""
    step: Period
    """The base communication step, in seconds or as text with a unit."""
    duration: Period
    """How long the run lasts; it ends with the first step at or after this time. All times may also be counted in what
    `cycle` names, as in `2 orbits`."""
    exchange: Literal["sequential", "parallel"] = "sequential"
    """Whether a block sees what those before it gave in the same step, or all see the values of the step before."""
    flavour: Flavour = "native"
    """Which build of the project's own blocks is run: compiled C, or the Python reference."""
    isolation: Isolation | None = None
    """Whether blocks run in processes of their own. Default: laws in Python and FMUs given by a path do, the project's
    own blocks do not.
    """
    realtime: Realtime | None = None
    """How a run is paced by wall time. Default: it is as fast as it goes. Only `orchestrate run` and
    `orchestration.run` pace a run."""
    blocks: dict[Annotated[str, Field(pattern=r"^[A-Za-z_]\w*$")], BlockEntry] = Field(min_length=1)
    """The blocks, each under a name of its own."""
    shared: dict[Name, Value] = {}
    """Start values by the parameter's name, for every block that has it; a value under the block's own `start` goes
    before."""
    data: Data = Field(default_factory=Data)
    """Data that no block takes; nothing that flies depends on them."""
    connections: list[Connection] = []
    """`plant.omega_B -> controller.omega_B`: whole variables, or single elements as `a.x[2] -> b.y`."""
    delays: list[Reference] = []
    """Targets of connections that pass the value of the step before, to break an algebraic loop."""
    record: Record = Field(default_factory=Record)
    expect: list[Expectation] = []
    """Expectations, which decide the exit status."""
    holds: list[HoldEntry] = []
    """Holds, of which the summary tells whether and when they were released."""
    consistency: dict[Annotated[str, Field(min_length=1)], Consistency] = {}
    """Consistency checks by their names, such as "the wheel's momentum follows its torque": `orchestrate polarity`
    sees a wrong wiring early by them."""
    faults: list[Fault] = []
    """What goes wrong during the run."""
    timeline: list[TimelineEntry] = []
    """Commands and set-points at given times, and the phases of the run."""
    phases: Phases | None = None
    """Phases by the value of a signal; they are drawn in place of those of the timeline."""
    figures: list[FigureEntry] = []
    """Figures that `--figures` draws."""
    cycle: Cycle | None = None
    """A second axis of time in the figures."""
    view: ViewEntry | None = None
    """The report's three-dimensional view. Default: what the interfaces of the project's own blocks say, if one has an
    attitude."""
    live: Live | None = None
    """What a reader may change in the page that `orchestrate live` makes. A run takes no notice of it."""

    @field_validator("blocks")
    @classmethod
    def _free_names(cls, blocks: dict[str, BlockEntry]) -> dict[str, BlockEntry]:
        if "shared" in blocks:
            raise ValueError("no block can be called 'shared', which is what --set calls the shared values")
        return blocks

    _source: Source = PrivateAttr()

    @property
    def source(self) -> Source:
        return self._source

    def given(self, block: str) -> dict[str, Key]:
        """Returns where the start values of a block stand, by variable: its own go before the shared ones."""
        shared: dict[str, Key] = {name.variable: ("shared", name) for name in self.shared}
        return shared | {name.variable: ("blocks", block, "start", name) for name in self.blocks[block].start}

    def error(self, key: Key, text: str = "", **fields: Unpack[Fields]) -> Problem:
        """Returns an error at the place of a key in the file."""
        return self._source.error(key, text, **fields)

    def naming(self, key: Key) -> AbstractContextManager[None]:
        """Places at a key the errors of what stands or is named there."""
        return self._source.naming(key)

    def note(self, key: Key, text: str) -> str:
        """Returns a note on what stands at a key in the file."""
        return self._source.note(key, text)
