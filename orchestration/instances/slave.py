"""An FMU loaded into this process, as a block of the master.

library.py loads and instantiates it; the calls of the step loop are made in calls.py.

Longer than 250 lines: one class has each call of an FMU, and what becomes of a status of any of them.
"""

from __future__ import annotations

import ctypes as c
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import BlockError, InputError
from ..fmu.archive import Fmu
from ..fmu.model import TYPES, Element, Floats, Model
from ..fmu.types import Native
from . import calls
from .calls import ANSWERS, BEYOND, WARNING, Call, Exchange, Gather, Stepper, Stride
from .layout import Arrays, Layout, exchanges
from .library import VERSIONS, Library
from .loading import in_words
from .log import Log
from .record.recorder import Record

_STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")
_DISCARD, _ERROR, _FATAL = 2, 3, 4
_TERMINATED = 3
"""fmi2Terminated of fmi2StatusKind."""


def asks_to_end(error: BlockError) -> bool:
    """Returns whether an FMU has not failed but ends the simulation: by a step that it discards (FMI 2.0), or by its
    answer (3.0).
    """
    return error.call.endswith("DoStep") and error.problem in (f"gave status {_STATUS[_DISCARD]}", ANSWERS[1])


class Slave:
    """One instance of an FMU. See `block.Block`."""

    def __init__(
        self,
        name: str,
        fmu: Fmu,
        folder: Path | None,
        verbose: bool | Callable[[str], None] = False,
        record: Record | None = None,
    ) -> None:
        """Loads the library from `folder`, where the FMU has been unpacked, and instantiates it.

        `verbose` prints what it logs, or takes each line of it. Without a folder the library is loaded once for all
        instances and stays until the process ends, which only suits one without a state of its own. Its calls are
        written to `record`.
        """
        self.name: str = name
        self.model: Model = fmu.model
        self.version = VERSIONS[fmu.model.prefix]
        self._log = Log(name, echo=verbose)
        self._initialized = self._dead = False
        self._arrays = Arrays(fmu.model)
        self._library = self._load(fmu, folder, record)
        self._states: list[c.c_void_p] = []
        self._library.instantiate(name, fmu.model.guid, self._log)
        if not self._library.component:
            self._library.unload()
            token = self.version.token
            hint = "" if self._log.lines else f"; it gives no reason, but often the {token} is not that of the binary"
            if fmu.kind.needs_tool:
                hint += "; it needs the tool that made it to be at hand (needsExecutionTool)"
            raise self._error(self.version.instantiate, f"gave no instance{hint}")
        self.component = c.c_void_p(self._library.component)
        self._argument = c.c_void_p.from_param(self._library.component)  # converted once, for the calls of every step

    def _load(self, fmu: Fmu, folder: Path | None, record: Record | None) -> Library:
        try:
            return Library(self.version, fmu, folder, record)
        except InputError:
            raise
        except Exception as error:
            raise self._error("loading its library", in_words(str(error).replace(f"{folder}{os.sep}", ""))) from None

    @property
    def log(self) -> Sequence[str]:
        return tuple(self._log.lines)

    # ------------------------------------------------------------ initialization

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        for native, pairs in self._by_native(values):
            elements = [element for element, _ in pairs]
            layout = Layout.of(self.model, elements)
            buffer = np.zeros(layout.length, native.code)
            arrays = self._arrays.into(layout, buffer)
            for slot, (element, value) in zip(layout.slots, pairs, strict=True):
                buffer[slot] = self._as_native(native, element, value)
            self._exchange("Set", native, elements, layout, buffer)
            self._arrays.keep(arrays)

    def get(self, elements: Sequence[Element]) -> list[float]:
        by_element: dict[Element, float] = {}
        for native, pairs in self._by_native((element, None) for element in elements):
            wanted = [element for element, _ in pairs]
            layout = Layout.of(self.model, wanted)
            buffer = np.zeros(layout.length, native.code)
            self._exchange("Get", native, wanted, layout, buffer)
            by_element.update((e, float(buffer[slot])) for e, slot in zip(wanted, layout.slots, strict=True))
        return [by_element[element] for element in elements]

    def _by_native(self, values: Iterable[tuple[Element, Any]]) -> Iterator[tuple[Native, list[tuple[Element, Any]]]]:
        groups: dict[Native, list[tuple[Element, Any]]] = {}
        for element, value in values:
            groups.setdefault(self.model.native(element), []).append((element, value))
        yield from groups.items()

    def _exchange(
        self, verb: str, native: Native, elements: list[Element], layout: Layout, buffer: NDArray[Any]
    ) -> None:
        name = f"{self.model.prefix}{verb}{native.function}"
        references = np.array(layout.references, np.uint32)
        texts = (c.c_char_p * len(buffer))(*(text.encode() for text in buffer)) if native.type == "string" else None
        values = texts if texts is not None else c.c_void_p(buffer.ctypes.data)
        more = [c.c_size_t(len(buffer))] if self.version.three else []
        count = c.c_size_t(len(references))
        status = self._function(name)(self.component, c.c_void_p(references.ctypes.data), count, values, *more)
        if status > WARNING:
            names = ", ".join(dict.fromkeys(element.variable for element in elements))
            raise self.failed(f"{name} of {names}", status)

    def _as_native(self, native: Native, element: Element, value: Any) -> Any:
        if native.code in ("f8", "O"):
            return value
        low, beyond = native.bounds
        if not low <= value < beyond:
            raise self._error(f"{self.model.prefix}Set{native.function}", self._beyond(native, element, value))
        return value if native.type == "real" else int(value)

    def enter(self, stop: float) -> None:
        for name, arguments in self.version.initialize(stop):
            self._plain(name, *arguments)

    def leave(self) -> None:
        self._plain(f"{self.model.prefix}ExitInitializationMode")
        self._initialized = True

    def _plain(self, call: str, *arguments: Any) -> None:
        status = self._function(call)(self.component, *arguments)
        if status > WARNING:
            raise self.failed(call, status)

    def reset(self) -> None:
        """Back to where it stood after it was instantiated, by fmi2Reset or fmi3Reset; what is wired stays so.

        Raises BlockError where it cannot.
        """
        self._log.lines.clear()
        self._initialized = False
        self._arrays.reset()
        self._plain(f"{self.model.prefix}Reset")

    def save(self) -> c.c_void_p:
        """Returns its state by fmi2GetFMUstate, which lasts as long as the instance. Raises BlockError without it."""
        state = c.c_void_p()
        self._plain(f"{self.model.prefix}GetFMU{self.version.state}", c.byref(state))
        self._states.append(state)
        return state

    def restore(self, state: c.c_void_p) -> None:
        """Takes it back to a state that it gave. Raises BlockError."""
        self._plain(f"{self.model.prefix}SetFMU{self.version.state}", state)
        self._initialized = True

    def slopes(self, outputs: Sequence[Element], inputs: Sequence[Element]) -> Floats:
        """Returns the derivatives of outputs by inputs, (outputs, inputs), by fmi2 or fmi3GetDirectionalDerivative.

        Raises BlockError where it gives none.
        """
        call = f"{self.model.prefix}GetDirectionalDerivative"
        function, three = self._function(call), self.version.three
        of, by = Layout.of(self.model, outputs), Layout.of(self.model, inputs)
        names = [np.array(layout.references, np.uint32) for layout in (of, by)]
        known = [argument for refs in names for argument in (c.c_void_p(refs.ctypes.data), c.c_size_t(len(refs)))]
        seed, answer = np.zeros(by.length), np.zeros(of.length)
        ends = [(c.c_void_p(v.ctypes.data), *([c.c_size_t(len(v))] if three else [])) for v in (seed, answer)]
        found = np.empty((len(outputs), len(inputs)))
        for column, slot in enumerate(by.slots):
            seed[slot] = 1.0
            if (status := function(self.component, *known, *ends[0], *ends[1])) > WARNING:
                raise self.failed(call, status)
            seed[slot] = 0.0
            found[:, column] = answer[of.slots]
        return found

    # ------------------------------------------------------------ steps

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        values = np.zeros(len(inputs))
        model, arrays, function = self.model, self._arrays, self._function
        self.setters = exchanges("Set", model, inputs, [0] * len(TYPES), values, function, arrays)
        self.getters = exchanges("Get", model, outputs, live, into, function)
        self.step_function = function(f"{self.model.prefix}DoStep")
        for name, value in vars(Slave).items():  # the calls of an earlier wiring have pointers to its arrays
            if isinstance(value, cached_property):
                self.__dict__.pop(name, None)
        return values

    setters: list[Exchange]
    getters: list[Exchange]
    step_function: Any

    # The calls of the loop in Python, made where they are asked for: the loop in C needs none of them.

    @cached_property
    def _stepper(self) -> Stepper:
        return Stepper(f"{self.model.prefix}DoStep", self.step_function, self._argument, self.version.three)

    @cached_property
    def set_inputs(self) -> Call:
        return calls.sequence([e.call(self._argument, e.all, self.failed) for e in self.setters])

    @cached_property
    def get_all(self) -> Call:
        return calls.sequence([e.call(self._argument, e.all, self.failed) for e in self.getters])

    @cached_property
    def get_live(self) -> Call:
        live = [e for e in self.getters if e.live.references]
        return calls.sequence([e.call(self._argument, e.live, self.failed) for e in live])

    @cached_property
    def do_step(self) -> Stride:
        return self._stepper.call(self.failed)

    def stride(self, gather: Gather, step: float, live: bool) -> Callable[[float], None]:
        """Returns a whole step of this length in one: `gather`, `set_inputs`, `do_step`, `get_live` or `get_all`."""
        one = calls.strider(gather, self.setters, self.getters, self._stepper, self._argument, self.failed, step, live)
        get = self.get_live if live else self.get_all
        return one or calls.stride(gather, self.set_inputs, self.do_step, get, step)

    # ------------------------------------------------------------ end

    def close(self) -> None:
        """Terminates and frees the instance. After a fatal status nothing of it is called any more."""
        self._log.close()
        if self._dead:
            return
        self._dead = True
        for state in self._states:
            with suppress(BlockError):
                self._plain(f"{self.model.prefix}FreeFMU{self.version.state}", c.byref(state))
        if self._initialized:
            with suppress(BlockError):  # a library without fmi2Terminate
                self._function(f"{self.model.prefix}Terminate")(self.component)
        self._library.free()

    # ------------------------------------------------------------ helpers

    def _function(self, name: str) -> Any:
        try:
            function = self._library.dll[name]
        except AttributeError:
            raise self._error(name, "is missing in its library") from None
        function.restype = c.c_int
        return function

    def failed(self, call: str, status: int) -> BlockError:
        """The error of a call that gave this status, or of what stands in its place; it decides what may still be
        called."""
        if status == BEYOND:
            return self._error(call, self._first_beyond(call))
        if status < 0:
            return self._error(call, " and ".join(text for i, text in enumerate(ANSWERS) if -status >> i & 1))
        if status >= _ERROR:
            self._initialized = False  # FMI allows nothing but freeing it
        self._dead = self._dead or status == _FATAL
        if status == _DISCARD and self._has_terminated(call):
            return self._error(call, ANSWERS[1], status)
        known = _STATUS[:-1] if self.version.three else _STATUS  # FMI 3.0 has no pending
        return self._error(call, f"gave status {known[status] if status < len(known) else status}", status)

    def _has_terminated(self, call: str) -> bool:
        """Returns whether an FMU of FMI 2.0 says that it ends the simulation, of a step that it discards."""
        has = c.c_int(0)
        try:
            function = self._function("fmi2GetBooleanStatus") if call == "fmi2DoStep" else None
        except BlockError:  # which it lacks
            return False
        return function is not None and function(self.component, _TERMINATED, c.byref(has)) <= WARNING and bool(has)

    def _first_beyond(self, call: str) -> str:
        for setter in (setter for setter in self.setters if setter.name == call):
            low, beyond = setter.native.bounds
            for element, value in zip(setter.elements, setter.values[setter.places].tolist(), strict=True):
                if not low <= value < beyond:
                    return self._beyond(setter.native, element, value)
        return "was given a value that its type cannot hold"

    def _beyond(self, native: Native, element: Element, value: float) -> str:
        label, (low, beyond) = self.model.variables[element.variable].label(element.position), native.bounds
        last = beyond - 1 if native.whole else -low
        return f"was given {value:.10g} for {label}; {native.function} holds {low:.10g} to {last:.10g}"

    def _error(self, call: str, problem: str, status: int | None = None) -> BlockError:
        return BlockError(self.name, call, problem, log=self.log, status=status)
