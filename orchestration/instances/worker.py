"""The process in which an FMU runs that is kept apart: it does what the master asks, until the master goes.

Its standard input and output are the pipes of channel.py; what the FMU prints goes to standard error,
together with what it logs. Whatever becomes of the master, this process ends with it.
"""

from __future__ import annotations

import json
import os
import pickle
import signal
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NoReturn

from ..errors import BlockError
from ..fmu.model import Element
from . import confine
from .channel import ANSWER, DONE, GETTING, MARK, SETTING, STEP, STEPPING, Closed, Memory, Setup, receive, send, write
from .law import Law
from .library import Library
from .own_parameters import SUFFIX
from .slave import Slave


class Watched(Slave):
    """A slave that leaves in the mapped memory which function of FMI's it is about to call."""

    def __init__(self, memory: Memory, *arguments: Any) -> None:
        self._memory = memory
        super().__init__(*arguments)

    def _load(self, *arguments: Any) -> Library:
        self._memory.call = "loading its library"
        library = super()._load(*arguments)
        free = library.free

        def free_instance() -> None:
            self._memory.call = f"{self.model.prefix}FreeInstance"
            free()

        library.free = free_instance  # type: ignore[method-assign]
        self._memory.call = self.version.instantiate
        return library

    def _function(self, name: str) -> Any:
        self._memory.call = name
        return super()._function(name)


class Worker:
    def __init__(self, source: int, to: int) -> None:
        self._source, self._to = source, to
        setup: Setup = pickle.loads(self._call())
        confine.end_with(setup.master)
        confine.limit_memory(setup.bytes_max)
        self._memory = Memory(setup.memory, setup.model)
        if isinstance(setup.memory, int):
            os.close(setup.memory)
        self._setup = setup
        self._slave: Slave | Law | None = None
        self._answer({"value": None})

    def _call(self) -> bytes:
        os.read(self._source, 1)
        return receive(self._source)

    def serve(self) -> None:
        """Answers calls until the pipe is closed. Raises Closed or OSError where the FMU has closed ours."""
        try:
            self._serve()
        except (Closed, OSError):
            self._memory.cut[0] = 1
            raise

    def _serve(self) -> None:
        part = self._memory.part
        source, to, read, put, own, getpid = self._source, self._to, os.read, os.write, os.getpid(), os.getpid
        while True:
            order = read(source, 1)
            if order == STEP:
                try:
                    self._step()
                except BlockError as error:
                    self._refuse(error)
                else:
                    if getpid() != own:  # a copy that the FMU has made by fork
                        os._exit(0)
                    part[0] = STEPPING  # until it is answered: what closes our pipes is seen no earlier
                    put(to, DONE)
            elif order:
                method, arguments = pickle.loads(receive(source))
                try:
                    value = getattr(self, f"_do_{method}")(*arguments)
                except BlockError as error:
                    self._refuse(error)
                else:
                    self._answer({"value": value})
            else:
                return

    def _step(self) -> None:
        raise NotImplementedError("not wired")

    def _answer(self, answer: dict[str, Any]) -> None:
        send(self._to, ANSWER, json.dumps(answer).encode())

    def _refuse(self, error: BlockError) -> None:
        self._do_mark()
        self._answer({"call": error.call, "problem": error.problem, "status": error.status})

    # ------------------------------------------------------------ what may be asked

    def _do_instantiate(self) -> None:
        setup = self._setup
        if setup.library.endswith(SUFFIX):
            self._memory.call = "reading the law"
            self._slave = Law(setup.name, setup.model, Path(setup.library))
            return
        fmu = SimpleNamespace(model=setup.model, kind=setup.kind, library=setup.library)
        self._slave = Watched(self._memory, setup.name, fmu, setup.folder, say, setup.record)

    def _do_mark(self) -> None:
        confine.flush()
        say(MARK.decode())

    def _do_set(self, values: list[tuple[Element, Any]]) -> None:
        self._fmu.set(values)

    def _do_get(self, elements: list[Element]) -> list[float]:
        self._initializing()
        return self._fmu.get(elements)

    def _do_enter(self, stop: float) -> None:
        self._fmu.enter(stop)

    def _do_leave(self) -> None:
        self._initializing()
        self._fmu.leave()

    def _initializing(self) -> None:
        if isinstance(self._slave, Law):
            self._memory.call = "step"

    def _do_reset(self) -> None:
        self._fmu.reset()

    def _do_get_all(self) -> None:
        self._memory.call = f"{self._fmu.model.prefix}Get"
        self._fmu.get_all()

    def _do_wire(self, inputs: Sequence[Element], outputs: Sequence[Element]) -> None:
        """Each step fetches all outputs, so that one exchange with the master is enough."""
        slave, clock, part = self._fmu, self._memory.clock, self._memory.part
        shared_inputs, shared_outputs = self._memory.values(len(inputs), len(outputs))
        values = slave.wire(inputs, outputs, [0] * 4, shared_outputs)
        set_inputs, do_step, get_all = slave.set_inputs, slave.do_step, slave.get_all

        def step() -> None:
            part[0] = SETTING
            values[:] = shared_inputs
            set_inputs()
            part[0] = STEPPING
            do_step(clock[0], clock[1])
            part[0] = GETTING
            get_all()

        self._step = step  # type: ignore[method-assign]

    def _do_close(self) -> None:
        if self._slave is not None:
            self._slave.close()

    @property
    def _fmu(self) -> Slave | Law:
        assert self._slave is not None
        return self._slave


def say(line: str) -> None:
    """A line among all that the FMU prints and logs."""
    with suppress(Closed):
        write(2, line.encode("utf-8", "replace") + b"\n")


def main() -> NoReturn:
    source, to = confine.take_pipes()
    confine.print_at_once()
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # in Python it would be an error of whatever runs
    status = 0
    try:
        Worker(source, to).serve()
    except (Closed, OSError):
        status = 1
    # Nothing more of the FMU is to run, such as what its library does at exit.
    os._exit(status)


if __name__ == "__main__":
    main()
