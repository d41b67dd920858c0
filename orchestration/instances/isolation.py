"""An FMU in a process of its own, as a block of the master.

Its crash, hang, endless memory and prints stay its own, and so do the names of its modules: two FMUs
made by PythonFMU that hold modules of one name run the first one's code where they share a process.

Longer than 250 lines: each call of an FMU has here what becomes of it when the process ends, hangs or answers wrongly.
"""

from __future__ import annotations

import json
import os
import pickle
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from math import inf
from pathlib import Path
from time import monotonic
from typing import Any

from .. import interrupt
from ..errors import BlockError, NoRoom
from ..fmu.archive import Fmu
from ..fmu.model import Element, Floats, Model
from ..fmu.zipped import size_text
from .channel import ANSWER, CALL, DONE, GETTING, SETTING, STEP, STEPPING, Closed, Memory, Setup, receive, sealed, send
from .listener import Listener
from .own_parameters import SUFFIX
from .process import GRACE, Limits, Process
from .record.recorder import Record, complete
from .watchdog import Watchdog

_START_TIMEOUT = 120.0
"""Seconds that a process may take to start."""


STARTING = "starting its process"
"""The call of an error before anything of the FMU is loaded: it is not the FMU's, nor one of the scenario."""


class IsolatedBlock:
    """One instance of an FMU behind a process. See `block.Block`.

    It starts at once, but only `started` waits for it, so that several start side by side.
    """

    def __init__(
        self,
        name: str,
        fmu: Fmu,
        folder: Path,
        limits: Limits,
        verbose: bool = False,
        record: Record | None = None,
    ) -> None:
        """`folder` holds the unpacked FMU; beside it are made the mapped file and the folder that it works in. Its
        calls are written to `record`."""
        self.name: str = name
        self.model: Model = fmu.model
        self.failure: BlockError | None = None
        """What went wrong when it was closed."""
        self._limits, self._record, self._is_law = limits, record, str(fmu.library).endswith(SUFFIX)
        self._instantiated = self._stepping = False
        home = folder.with_name(f"{folder.name}.home")
        home.mkdir()
        shared: Path | int = folder.with_name(f"{folder.name}.memory")
        try:
            descriptor = sealed(fmu.model)
            shared = shared if descriptor is None else descriptor
            self._memory = Memory(shared, fmu.model)
        except OSError as error:
            raise NoRoom(f"{name}: the memory shared with its process cannot be made", folder.parent, error) from None
        self._memory.call = STARTING
        self._process = Process(home, [] if descriptor is None else [descriptor])
        if descriptor is not None:
            os.close(descriptor)
        self._to, self._from = self._process.to, self._process.source
        self._listener = Listener(name, self._process.errors, verbose)
        self._watchdog = Watchdog(self._process, limits.timeout)
        setup = Setup(name, fmu.model, fmu.kind, fmu.library, folder, shared, limits.memory, os.getpid(), record)
        with suppress(Closed):
            send(self._to, CALL, pickle.dumps(setup))
            send(self._to, CALL, pickle.dumps(("instantiate", ())))

    def started(self) -> None:
        """Waits until it has been instantiated. Raises BlockError."""
        self._wait(max(self._limits.timeout, _START_TIMEOUT))
        self._wait(self._limits.timeout)
        self._memory.call = ""
        self._instantiated = True

    @property
    def log(self) -> Sequence[str]:
        if self._instantiated and not self._stepping and not self._watchdog.ended.is_set():
            with suppress(BlockError):  # what it has printed may still be on its way
                self._ask("mark")
                self._listener.wait()
        return tuple(self._listener.lines)

    # ------------------------------------------------------------ calls before and between steps

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        self._ask("set", [(element, _plain(value)) for element, value in values])

    def get(self, elements: Sequence[Element]) -> list[float]:
        values = self._ask("get", list(elements))
        return [float(value) for value in values]

    def enter(self, stop: float) -> None:
        self._ask("enter", stop)

    def leave(self) -> None:
        self._ask("leave")

    def reset(self) -> None:
        """As that of an FMU in this process, see `Slave.reset`."""
        self._listener.lines.clear()
        self._ask("reset")

    def _ask(self, method: str, *arguments: Any) -> Any:
        if self._watchdog.ended.is_set():
            raise BlockError(self.name, method, "its process has ended", log=self.log)
        self._memory.part[0] = 0
        try:
            send(self._to, CALL, pickle.dumps((method, arguments)))
        except Closed:
            raise self._lost() from None
        try:
            return self._wait(self._limits.timeout)
        finally:
            self._memory.call = ""

    def _wait(self, timeout: float) -> Any:
        self._watchdog.deadline = monotonic() + timeout
        kind = os.read(self._from, 1)
        answer = self._answer(kind)
        self._watchdog.deadline = inf
        return answer

    def _answer(self, kind: bytes) -> Any:
        """The value of an answer. Raises BlockError where it is a refusal, or no answer at all."""
        try:
            answer = json.loads(receive(self._from)) if kind == ANSWER else None
            if isinstance(answer, dict) and "value" in answer:
                return answer["value"]
        except (Closed, ValueError):
            answer = None
        if not isinstance(answer, dict):
            raise self._lost()
        self._watchdog.deadline = inf
        self._listener.wait()
        call, problem, status = (answer.get(name) for name in ("call", "problem", "status"))
        raise BlockError(self.name, str(call), str(problem), log=tuple(self._listener.lines), status=status)

    # ------------------------------------------------------------ steps

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        self._ask("wire", list(inputs), list(outputs))
        shared_inputs, shared_outputs = self._memory.values(len(inputs), len(outputs))
        clock, part, to, source = self._memory.clock, self._memory.part, self._to, self._from
        write, read = os.write, os.read
        timeout = self._limits.timeout

        def do_step(time: float, step: float) -> None:
            if self._stepping:
                finish()
            clock[0], clock[1], part[0] = time, step, 0
            self._watchdog.deadline = monotonic() + timeout
            self._stepping = True
            try:
                write(to, STEP)
            except OSError:
                error = self._lost()
                error.time = time
                raise error from None

        def finish() -> None:
            self._stepping = False
            try:
                kind = read(source, 1)
            except KeyboardInterrupt:
                if self._watchdog.interrupted():  # the second Ctrl-C, which does without the grace
                    raise interrupt.Abandoned(interrupt.latest()[0]) from None
                raise
            if kind != DONE:
                raise self._step_failed(kind)
            self._watchdog.deadline = inf

        def get() -> None:
            if self._stepping:
                finish()
            else:
                self._ask("get_all")
            into[:] = shared_outputs

        self.do_step, self.get_live, self.get_all = do_step, get, get
        return shared_inputs

    do_step: Callable[[float, float], None]
    get_live: Callable[[], None]
    get_all: Callable[[], None]

    def set_inputs(self) -> None:
        """They lie in the mapped memory; the step hands them over."""

    def _step_failed(self, kind: bytes) -> BlockError:
        try:
            self._answer(kind)
            error = self._lost()
        except BlockError as refusal:
            error = refusal
        error.time = self._memory.clock[0]
        return error

    # ------------------------------------------------------------ end

    def close(self) -> None:
        """Terminates and frees the instance, and ends the process with all that it has started; never raises."""
        if self._watchdog.ended.is_set():
            return
        if self._watchdog.deadline < inf and not self._stepping:  # Ctrl-C has broken off a call
            self._process.kill()
        elif self._instantiated:
            try:
                if self._stepping and (kind := os.read(self._from, 1)) != DONE:
                    raise self._step_failed(kind)  # another block has failed in the same step
                if self._watchdog.interrupted():
                    self._watchdog.stop_by = monotonic() + GRACE
                self._ask("close")
            except interrupt.Abandoned:
                pass
            except BlockError as error:
                self.failure = error
                error.time = self._memory.clock[0] + self._memory.clock[1]
        self._end()

    def _end(self) -> None:
        """Ends the process; nothing of it is left."""
        self._watchdog.deadline = inf
        self._process.end()
        self._watchdog.ended.set()
        self._process.reap()
        self._listener.join()
        if self._record is not None:
            with suppress(OSError):
                complete(self._record.path)

    def _lost(self) -> BlockError:
        """The error of a process that has ended, or that does not answer as it should. Raises Abandoned."""
        overdue, self._watchdog.deadline = self._watchdog.overdue, inf
        alive = not self._process.gone(GRACE)
        self._end()
        if self._watchdog.abandoned:
            raise interrupt.Abandoned(interrupt.latest()[0])
        if overdue:
            limit = f"{self._limits.timeout:.10g} s"
            how = f"did not return within {limit} (the block's 'timeout'), so its process was ended"
        elif alive or self._memory.cut[0]:
            how = "broke off its connection, so its process was ended"
        else:
            how = self._process.cause + self._held()
        return BlockError(self.name, self._call(), how, log=self.log)

    def _held(self) -> str:
        """Returns whether it had run out of memory."""
        limit = self._limits.memory
        return (
            f"; it had used up the {size_text(limit)} that the block's 'memory' allows"
            if self._process.peak > 0.8 * limit
            else ""
        )

    def _call(self) -> str:
        part = self._memory.part[0]
        if part and self._is_law:
            return "step"
        verb = {SETTING: "Set", STEPPING: "DoStep", GETTING: "Get"}.get(part)
        return f"{self.model.prefix}{verb}" if verb else self._memory.call or "between two calls"


def _plain(value: Any) -> Any:
    return value.item() if hasattr(value, "item") else value
