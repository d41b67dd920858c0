"""A block as a PythonFMU slave: what an FMU does at Set, Get, doStep and in initialization.

Carried by every Python FMU, so it needs the standard library and numpy only. A call that fails leaves the
instance as it was before the call.
Longer than 250 lines: the calls of FMI share one state, as in PythonFMU.
"""

from __future__ import annotations

import importlib
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

from ..parsing import parse
from ..variables import Interface
from .calls import Refused, guarded
from .memory import Layout, Snapshot, check_state, first_not_finite, from_bytes, to_bytes

try:
    from ..pythonfmu.fmi2slave import Fmi2Slave  # the copy that an FMU carries
except ModuleNotFoundError:
    from pythonfmu.fmi2slave import Fmi2Slave

_CODE = __package__.rpartition(".")[0]
"""The package of all the code that an FMU carries."""
_INSTANTIATED, _INITIALIZING, _STEPPING, _TERMINATED = "instantiated", "initializing", "stepping", "terminated"
_TIME_TOLERANCE = 1e-6
"""Of a step: how far doStep's time may be from the block's own."""
_BEYOND_STOP = 0.01
"""Of a step: by how much it may end beyond the stop time, for masters that add up times."""
_ROUNDING = 1e-12
"""Of a time."""
_SHORT = 0.01
"""Of a step: how much before an own instant it may end to reach it, for masters that add up times."""


class BlockSlave(Fmi2Slave):
    """The base of the one class in an FMU's entry module, which names the block."""

    package: ClassVar[str] = ""
    """The block's package, beside this module."""
    identity: ClassVar[str] = ""
    """Hash of the FMU's content; a serialized state is bound to it."""
    interface: ClassVar[Interface]
    block: ClassVar[ModuleType]
    layout: ClassVar[Layout]
    folder: ClassVar[Path | None] = None

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        resources = Path(self.resources)
        if self.folder is None or (not self.folder.exists() and (resources / _CODE).exists()):
            type(self)._load(resources)
        self.modelName = self.interface.name
        self._values = self.layout.starts.copy()
        self._mode = _INSTANTIATED
        self._time = 0.0
        self._stop: float | None = None  # infinite where the host gave none; None until setupExperiment
        self._begin = 0.0  # startTime, from which the block's own instants count
        self._instants = 0  # of its own: how many it has acted at
        self._held = False  # the outputs are those of the last own instant, whatever the inputs are by now
        self._dirty = True  # the outputs among the values are not those of state, inputs and parameters
        self._state: Any = None
        self._p: Any = None  # the block's Parameters and Inputs, None where the values have changed
        self._u: Any = None

    @classmethod
    def _load(cls, resources: Path) -> None:
        """Imports the block; again where the folder of the first import has been deleted."""
        here = sys.modules[_CODE]
        if cls.folder is not None:
            here.__path__ = [str(resources / _CODE)]
            for name in [name for name in sys.modules if name.startswith(f"{_CODE}.{cls.package}")]:
                del sys.modules[name]
            importlib.invalidate_caches()
        folder = Path(here.__path__[0])
        cls.block = importlib.import_module(f".{cls.package}", _CODE)
        cls.interface = parse((folder / "interface.toml").read_text("utf-8"), "interface.toml")
        cls.layout = Layout(cls.interface, cls.block)
        cls.folder = folder

    # ------------------------------------------------------------ the course of a simulation

    @guarded
    def setup_experiment(self, start_time: float, stop_time: float | None = None, *_: Any) -> None:
        """The block's t = 0 is the experiment's start time; no step ends beyond `stop_time`."""
        self._expect(_INSTANTIATED, "setupExperiment")
        if not math.isfinite(start_time):
            raise Refused(f"setupExperiment: the start time is {start_time}; expected a finite number")
        if stop_time is not None and not start_time <= stop_time < math.inf:
            raise Refused(
                f"setupExperiment: the stop time is {stop_time}; expected a finite number, at least the start "
                f"time {start_time}"
            )
        self._time = self._begin = start_time
        self._stop = math.inf if stop_time is None else stop_time

    @guarded
    def enter_initialization_mode(self) -> None:
        self._expect(_INSTANTIATED, "enterInitializationMode")
        if self._stop is None:
            raise Refused("enterInitializationMode: expected setupExperiment before it")
        self._mode = _INITIALIZING

    @guarded
    def exit_initialization_mode(self) -> None:
        self._expect(_INITIALIZING, "exitInitializationMode")
        p, u = self._read()
        state = self.block.start(p, u)
        self._values = self.layout.store(self.block.outputs(state, u, p), self._values)
        self._state, self._dirty, self._mode = state, False, _STEPPING

    @guarded
    def do_step(self, current_time: float, step_size: float) -> bool:
        self._expect(_STEPPING, "doStep")
        if not 0.0 < step_size < math.inf:
            raise Refused(f"doStep: the step is {step_size} s; expected a finite number above 0")
        if not abs(current_time - self._time) <= _TIME_TOLERANCE * step_size + _ROUNDING * abs(self._time):
            raise Refused(f"doStep: the step starts at {current_time} s, but the block is at {self._time} s")
        end, stop = current_time + step_size, math.inf if self._stop is None else self._stop
        if end > stop + _BEYOND_STOP * step_size + _ROUNDING * abs(stop):
            raise Refused(
                f"doStep: the step ends at {end} s; expected the stop time {stop} s or before (to a hundredth of "
                "the step)"
            )
        period = self.layout.sample_period(self._values)
        if period and step_size > period * (1.0 + _TIME_TOLERANCE):
            raise Refused(f"doStep: the step is {step_size} s; expected at most sample_period = {period} s")
        p, u = self._read()
        if period and end < self._begin + (self._instants + 1) * period - _SHORT * step_size:
            self._time, self._held = end, True
            return True
        state, outputs = self.block.step(self._state, u, p, period or step_size)
        self._values = self.layout.store(outputs, self._values)
        self._state, self._dirty, self._held, self._time = state, False, False, end
        self._instants += 1
        return True

    @guarded
    def terminate(self) -> None:
        self._expect(_STEPPING, "terminate")
        self._mode = _TERMINATED

    def _expect(self, mode: str, call: str) -> None:
        if self._mode != mode:
            raise Refused(f"{call}: the block is {self._mode}; this call is for a block that is {mode}")

    def _read(self) -> tuple[Any, Any]:
        """Parameters, checked as a whole, and inputs, from the current values."""
        if self._p is None:
            p = self.layout.parameters(self._values)
            self.block.check(p)
            self._p = p
        if self._u is None:
            self._u = self.layout.inputs(self._values)
        return self._p, self._u

    # ------------------------------------------------------------ Get and Set

    def _get(self, kind: str, references: list[int]) -> list[Any]:
        asked = self.layout.asked(kind, references)
        if not asked.known:
            wrong = next(r for r in references if r not in self.layout.of_type[kind])
            raise Refused(f"get{kind}: there is no {kind} with the value reference {wrong}")
        if self._dirty and asked.outputs and not self._held:
            p, u = self._read()
            state = self._state if self._state is not None else self.block.start(p, u)
            self._values = self.layout.store(self.block.outputs(state, u, p), self._values)
            self._dirty = False
        return asked.take(self._values)

    def _set(self, kind: str, references: list[int], values: Sequence[Any]) -> None:
        if self._mode == _TERMINATED:
            raise Refused(f"set{kind}: the block is terminated")
        asked = self.layout.asked(kind, references)
        if not (asked.known and (asked.tunable if self._state is not None else asked.settable)):
            allowed = self.layout.tunable if self._state is not None else self.layout.settable
            self._refuse_set(
                kind, next(r for r in references if r not in allowed or r not in self.layout.of_type[kind])
            )
        if asked.bounded:
            for r, value in zip(references, values, strict=True):
                low, high = self.layout.bounds.get(r, (-math.inf, math.inf))
                if not low <= value <= high:
                    raise Refused(f"set{kind}: {self.layout.names[r]} = {value}; expected {low} to {high}")
        asked.put(self._values, values)
        self._u = None
        if asked.parameters:
            self._p = None
        self._dirty = True

    def _refuse_set(self, kind: str, reference: int) -> None:
        if reference not in self.layout.of_type[kind]:
            raise Refused(f"set{kind}: there is no {kind} with the value reference {reference}")
        name = self.layout.names[reference]
        why = "is an output" if reference in self.layout.output_references else "is fixed once initialization is over"
        raise Refused(f"set{kind}: {name} cannot be set, it {why}")

    @guarded
    def get_real(self, vrs: list[int]) -> list[float]:
        return self._get("Real", vrs)

    @guarded
    def get_integer(self, vrs: list[int]) -> list[int]:
        return self._get("Integer", vrs)

    @guarded
    def get_boolean(self, vrs: list[int]) -> list[bool]:
        return self._get("Boolean", vrs)

    @guarded
    def get_string(self, vrs: list[int]) -> list[str]:
        return self._get("String", vrs)

    @guarded
    def set_real(self, vrs: list[int], values: list[float]) -> None:
        i = None if math.isfinite(sum(values)) else first_not_finite(values)
        if i is not None and vrs[i] in self.layout.of_type["Real"]:
            raise Refused(f"setReal: {self.layout.names[vrs[i]]} = {values[i]}; expected a finite number")
        self._set("Real", vrs, values)

    @guarded
    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        self._set("Integer", vrs, values)

    @guarded
    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        self._set("Boolean", vrs, values)

    @guarded
    def set_string(self, vrs: list[int], values: list[str]) -> None:
        self._set("String", vrs, values)

    # ------------------------------------------------------------ FMU state

    @guarded
    def _get_fmu_state(self) -> Snapshot:
        check_state(self._state)
        times = self._time, self._begin, self._stop, self._instants
        return Snapshot(tuple(self._values), self._mode, *times, self._held, self._dirty, self._state)

    @guarded
    def _set_fmu_state(self, state: Snapshot) -> None:
        if state.error is not None:
            raise Refused(f"setFMUstate: {state.error}")
        self._values = list(state.values)
        self._mode, self._time, self._begin, self._stop = state.mode, state.time, state.begin, state.stop
        self._instants, self._held = state.instants, state.held
        self._dirty, self._state = state.dirty, state.state
        self._p = self._u = None

    @classmethod
    def _fmu_state_to_bytes(cls, state: Snapshot) -> bytes:
        return to_bytes(state, cls.identity)

    @classmethod
    def _fmu_state_from_bytes(cls, state: bytes) -> Snapshot:
        return from_bytes(state, cls.identity, cls.block)
