"""An FMU loaded into this process, as a block of the master.

FMPy loads and instantiates it; the calls of the step loop are made in calls.py.
"""

from __future__ import annotations

import atexit
import ctypes as c
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from copy import copy
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Slave

from ..errors import BlockError
from ..fmu.archive import Fmu
from ..fmu.model import TYPES, Element, Floats, Model
from . import calls
from .calls import WARNING, Call, Exchange, Stride
from .log import Log

_STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")
_ERROR, _FATAL = 3, 4
_FMI = {"real": "Real", "integer": "Integer", "enumeration": "Integer", "boolean": "Boolean", "string": "String"}
_C: dict[str, Any] = {"Real": c.c_double, "Integer": c.c_int, "Boolean": c.c_int, "String": c.c_char_p}
_STOP_TIME_DEFINED = 1

_libraries: dict[Path, FMU2Slave] = {}
"""Libraries that instances share, by the folder of their FMU. Reading the signatures of FMPy's functions takes 2 ms each."""


class Slave:
    """One instance of an FMU. See `block.Block`."""

    def __init__(
        self, name: str, fmu: Fmu, folder: Path, verbose: bool | Callable[[str], None] = False, shared: bool = False
    ) -> None:
        """Loads the library from `folder`, where the FMU has been unpacked, and instantiates it.

        `verbose` prints what it logs, or takes each line of it. `shared`: the library is loaded once for all instances,
        which only suits one without a state of its own, and stays until the process ends.
        """
        self._shared = shared
        self.name: str = name
        self.model: Model = fmu.model
        self._log = Log(name, echo=verbose)
        self._initialized = self._dead = False
        self._fmu = self._load(fmu, folder)
        try:
            self._fmu.instantiate(callbacks=self._log.callbacks, loggingOn=True)
        except Exception:
            if not self._shared:
                self._fmu.freeLibrary()
            hint = "" if self._log.lines else "; it gives no reason, but often the GUID is not that of the binary"
            if fmu.description.coSimulation.needsExecutionTool:
                hint += "; it needs the tool that made it to be at hand (needsExecutionTool)"
            raise self._error("fmi2Instantiate", f"gave no instance{hint}") from None
        self.component = c.c_void_p(self._fmu.component)
        self._argument = c.c_void_p.from_param(self._fmu.component)  # converted once, for the calls of every step

    def _load(self, fmu: Fmu, folder: Path) -> FMU2Slave:
        if not self._shared:
            return self._loaded(fmu, folder)
        if folder not in _libraries:
            _libraries[folder] = self._loaded(fmu, folder)
            atexit.register(_libraries[folder].freeLibrary)  # Windows removes no file of a library that is loaded
        library = copy(_libraries[folder])
        library.instanceName = self.name
        return library

    def _loaded(self, fmu: Fmu, folder: Path) -> FMU2Slave:
        here = os.getcwd()
        try:
            return FMU2Slave(
                guid=fmu.description.guid,
                modelIdentifier=fmu.description.coSimulation.modelIdentifier,
                unzipDirectory=str(folder),
                instanceName=self.name,
            )
        except Exception as error:
            reason = str(error).replace(f"{folder}{os.sep}", "")
            raise self._error("loading its library", reason) from None
        finally:
            os.chdir(here)  # FMPy leaves the folder changed where loading fails

    @property
    def log(self) -> Sequence[str]:
        return tuple(self._log.lines)

    # ------------------------------------------------------------ initialization

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        for kind, pairs in self._by_type(values):
            numbers = [value.encode() if kind == "String" else value for _, value in pairs]
            buffer = (_C[kind] * len(pairs))(*(numbers if kind in ("Real", "String") else map(int, numbers)))
            self._exchange("Set", kind, [element for element, _ in pairs], buffer)

    def get(self, elements: Sequence[Element]) -> list[float]:
        by_element: dict[Element, float] = {}
        for kind, pairs in self._by_type((element, None) for element in elements):
            buffer = (_C[kind] * len(pairs))()
            self._exchange("Get", kind, [element for element, _ in pairs], buffer)
            by_element.update((element, float(value)) for (element, _), value in zip(pairs, buffer, strict=True))
        return [by_element[element] for element in elements]

    def _by_type(self, values: Iterable[tuple[Element, Any]]) -> Iterator[tuple[str, list[tuple[Element, Any]]]]:
        groups: dict[str, list[tuple[Element, Any]]] = {}
        for element, value in values:
            groups.setdefault(_FMI[self.model.variables[element.variable].type], []).append((element, value))
        yield from groups.items()

    def _exchange(self, verb: str, kind: str, elements: list[Element], buffer: Any) -> None:
        references = (c.c_uint * len(elements))(*map(self._reference, elements))
        status = self._function(f"fmi2{verb}{kind}")(self.component, references, c.c_size_t(len(elements)), buffer)
        if status > WARNING:
            names = ", ".join(dict.fromkeys(element.variable for element in elements))
            raise self.failed(f"fmi2{verb}{kind} of {names}", status)

    def enter(self, stop: float) -> None:
        setup = self._function("fmi2SetupExperiment")
        status = setup(self.component, 0, c.c_double(0.0), c.c_double(0.0), _STOP_TIME_DEFINED, c.c_double(stop))
        if status > WARNING:
            raise self.failed("fmi2SetupExperiment", status)
        self._plain("fmi2EnterInitializationMode")

    def leave(self) -> None:
        self._plain("fmi2ExitInitializationMode")
        self._initialized = True

    def _plain(self, call: str) -> None:
        status = self._function(call)(self.component)
        if status > WARNING:
            raise self.failed(call, status)

    def reset(self) -> None:
        """Back to where it stood after it was instantiated, by fmi2Reset; what is wired stays so. Raises BlockError where it cannot."""
        self._log.lines.clear()
        self._initialized = False
        self._plain("fmi2Reset")

    # ------------------------------------------------------------ steps

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        values = np.zeros(len(inputs))
        self.setters = self._exchanges("Set", inputs, [0] * len(TYPES), values)
        self.getters = self._exchanges("Get", outputs, live, into)
        argument, failed = self._argument, self.failed
        self.set_inputs = calls.sequence([e.call(argument, len(e.values), failed) for e in self.setters])
        self.get_all = calls.sequence([e.call(argument, len(e.values), failed) for e in self.getters])
        self.get_live = calls.sequence([e.call(argument, e.live, failed) for e in self.getters if e.live])
        self.step_function = self._function("fmi2DoStep")
        self.do_step = calls.stepper(self.step_function, argument, failed)
        one = calls.strider(self.setters, self.getters, self.step_function, argument, failed)
        self.stride = one or calls.stride(self.set_inputs, self.do_step, self.get_live)
        return values

    setters: list[Exchange]
    getters: list[Exchange]
    step_function: Any

    set_inputs: Call
    get_all: Call
    get_live: Call
    do_step: Stride
    stride: Stride
    """`set_inputs`, `do_step` and `get_live` in one."""

    def _exchanges(self, verb: str, elements: Sequence[Element], live: Sequence[int], values: Floats) -> list[Exchange]:
        """A call for each type that occurs."""
        exchanges: list[Exchange] = []
        first = 0
        for kind, count in zip(TYPES, live, strict=True):
            members = [e for e in elements if self.model.variables[e.variable].type == kind]
            if members:
                part = values[first : first + len(members)]
                name = f"fmi2{verb}{_FMI[kind]}"
                references = np.array(list(map(self._reference, members)), np.uint32)
                buffer = part if kind == "real" else np.zeros(len(members), np.int32)
                exchanges.append(Exchange(name, self._function(name), references, part, buffer, count))
            first += len(members)
        return exchanges

    # ------------------------------------------------------------ end

    def close(self) -> None:
        """Terminates and frees the instance. After a fatal status nothing of it is called any more."""
        self._log.close()
        if self._dead:
            return
        self._dead = True
        if self._initialized:
            with suppress(BlockError):  # a library without fmi2Terminate
                self._function("fmi2Terminate")(self.component)
        if self._shared:
            self._fmu.fmi2FreeInstance(self._fmu.component)
        else:
            self._fmu.freeInstance()

    # ------------------------------------------------------------ helpers

    def _function(self, name: str) -> Any:
        try:
            function = self._fmu.dll[name]
        except AttributeError:
            raise self._error(name, "is missing in its library") from None
        function.restype = c.c_int
        return function

    def _reference(self, element: Element) -> int:
        return self.model.variables[element.variable].references[element.position]

    def failed(self, call: str, status: int) -> BlockError:
        """The error of a call that gave this status, which also decides what may still be called."""
        if status >= _ERROR:
            self._initialized = False  # FMI allows nothing but freeing it
        self._dead = self._dead or status == _FATAL
        return self._error(call, f"gave status {_STATUS[status] if status in range(6) else status}")

    def _error(self, call: str, problem: str) -> BlockError:
        return BlockError(self.name, call, problem, log=self.log)
