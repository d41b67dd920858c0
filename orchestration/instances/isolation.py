"""An FMU in a process of its own, as a block of the master.

Its crash, hang, endless memory and prints stay its own, and so do the names of its modules: two FMUs
made by PythonFMU that hold modules of one name run the first one's code where they share a process.
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from .. import interrupt
from ..errors import BlockError, InputError
from ..fmu.archive import Fmu
from ..fmu.interfaces import is_path
from ..fmu.model import Element, Floats, Model
from ..scenario.scenario import Scenario
from .channel import ANSWER, CALL, DONE, GETTING, MARK, SETTING, STEP, STEPPING, Closed, Memory, receive, send
from .log import LINES_MAX, shortened
from .worker import Setup

_START = "import sys; sys.path.append(sys.argv[1]); from orchestration.instances.worker import main; main()"
"""This process's own path may hold what FMUs have put there, so the worker makes one of its own."""
TIMEOUT = 60.0
"""Seconds that a call may take, where the scenario says nothing."""
MEMORY = 4 * 10**9
_START_TIMEOUT = 120.0
_GRACE = 2.0
"""Seconds that a process has for ending once its pipes are closed, and a call once the run is to end."""


@dataclass(frozen=True)
class Limits:
    timeout: float
    """Seconds that any one call may take."""
    memory: int
    """Bytes that the FMU may take."""


def limits(scenario: Scenario, name: str) -> Limits | None:
    """The limits of a block's process; None where it has none of its own. Raises InputError."""
    entry = scenario.blocks[name]
    default = "process" if is_path(entry.fmu) else "none"
    if (entry.isolation or scenario.isolation or default) == "process":
        return Limits(entry.timeout or TIMEOUT, entry.memory or _memory())
    for key in ("timeout", "memory"):
        if getattr(entry, key) is not None:
            message = "only an FMU in a process of its own has this limit; remedy: isolation: process"
            raise InputError(scenario.error(("blocks", name, key), message))
    return None


def _memory() -> int:
    try:
        return min(MEMORY, os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2)
    except (AttributeError, ValueError, OSError):
        return MEMORY


class IsolatedBlock:
    """One instance of an FMU behind a process. See `block.Block`.

    It starts at once, but only `started` waits for it, so that several start side by side.
    """

    def __init__(self, name: str, fmu: Fmu, folder: Path, limits: Limits, verbose: bool = False) -> None:
        """`folder` holds the unpacked FMU; beside it are made the mapped file and the folder that it works in."""
        self.name: str = name
        self.model: Model = fmu.model
        self.failure: BlockError | None = None
        """What went wrong when it was closed."""
        self._limits, self._verbose = limits, verbose
        self._lines: deque[str] = deque(maxlen=LINES_MAX)
        self._marked = threading.Event()
        self._ended = threading.Event()
        self._deadline, self._overdue = inf, False
        self._stop_by, self._abandoned = inf, False
        self._earlier = interrupt.latest()
        self._peak = 0
        self._instantiated = self._stepping = False
        home = folder.with_name(f"{folder.name}.home")
        home.mkdir()
        shared = folder.with_name(f"{folder.name}.memory")
        self._memory = Memory(shared, fmu.model)
        self._memory.call = "starting its process"
        self._process = _start(home)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        self._to, self._from = self._process.stdin.fileno(), self._process.stdout.fileno()
        self._listener = threading.Thread(target=self._listen, args=(self._process.stderr.fileno(),), daemon=True)
        self._listener.start()
        threading.Thread(target=self._watch, daemon=True).start()
        fmi = fmu.description.coSimulation
        setup = Setup(
            name,
            fmu.model,
            fmu.description.guid,
            fmi.modelIdentifier,
            bool(fmi.needsExecutionTool),
            folder,
            shared,
            limits.memory,
            os.getpid(),
        )
        with suppress(Closed):
            send(self._to, CALL, pickle.dumps(setup))
            send(self._to, CALL, pickle.dumps(("instantiate", ())))

    def started(self) -> None:
        """Waits until it has been instantiated. Raises BlockError."""
        self._wait(max(self._limits.timeout, _START_TIMEOUT))
        self._wait(self._limits.timeout)
        self._instantiated = True

    @property
    def log(self) -> Sequence[str]:
        if self._instantiated and not self._stepping and not self._ended.is_set():
            with suppress(BlockError):  # what it has said may still be on its way
                self._ask("mark")
                self._heard()
        return tuple(self._lines)

    def _heard(self) -> None:
        """Waits for the mark that ends what has been said until now."""
        self._marked.wait(_GRACE)
        self._marked.clear()

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

    def _ask(self, method: str, *arguments: Any) -> Any:
        if self._ended.is_set():
            raise BlockError(self.name, method, "its process has ended", log=self.log)
        try:
            send(self._to, CALL, pickle.dumps((method, arguments)))
        except Closed:
            raise self._lost() from None
        return self._wait(self._limits.timeout)

    def _wait(self, timeout: float) -> Any:
        self._memory.part[0] = 0
        self._deadline = monotonic() + timeout
        kind = os.read(self._from, 1)
        answer = self._answer(kind)
        self._deadline = inf
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
        self._deadline = inf
        self._heard()
        raise BlockError(self.name, str(answer.get("call")), str(answer.get("problem")), log=tuple(self._lines))

    # ------------------------------------------------------------ steps

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        self._ask("wire", list(inputs), list(outputs))
        shared_inputs, shared_outputs = self._memory.values(len(inputs), len(outputs))
        clock, to, source, write, read = self._memory.clock, self._to, self._from, os.write, os.read
        timeout = self._limits.timeout

        def do_step(time: float, step: float) -> None:
            if self._stepping:
                finish()
            clock[0], clock[1] = time, step
            self._deadline = monotonic() + timeout
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
                if self._interrupted():  # the second Ctrl-C, which does without the grace
                    raise interrupt.Abandoned(interrupt.latest()[0]) from None
                raise
            if kind != DONE:
                raise self._step_failed(kind)
            self._deadline = inf

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
        if self._ended.is_set():
            return
        if self._deadline < inf and not self._stepping:  # Ctrl-C has broken off a call
            self._process.kill()
        elif self._instantiated:
            try:
                if self._stepping and (kind := os.read(self._from, 1)) != DONE:
                    raise self._step_failed(kind)  # another block has failed in the same step
                if self._interrupted():
                    self._stop_by = monotonic() + _GRACE
                self._ask("close")
            except interrupt.Abandoned:
                pass
            except BlockError as error:
                self.failure = error
                error.time = self._memory.clock[0] + self._memory.clock[1]
        self._end()

    def _end(self) -> None:
        """Ends the process; nothing of it is left."""
        process = self._process
        self._deadline = inf
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        if not _gone(process, _GRACE):
            process.kill()
            _gone(process, _GRACE)
        _kill_all(process)
        self._ended.set()
        self._peak = _reap(process)
        self._listener.join(_GRACE)

    def _interrupted(self) -> bool:
        return interrupt.latest() is not self._earlier and bool(interrupt.latest())

    def _lost(self) -> BlockError:
        """What to say of a process that has ended, or that does not answer as it should. Raises Abandoned."""
        overdue, self._deadline = self._overdue, inf
        alive = not _gone(self._process, _GRACE)
        self._end()
        if self._abandoned:
            raise interrupt.Abandoned(interrupt.latest()[0])
        if overdue:
            limit = f"{self._limits.timeout:.10g} s"
            how = f"did not return within {limit} (the block's 'timeout'), so its process was ended"
        elif alive:
            how = "broke off its connection, so its process was ended"
        else:
            how = _cause(self._process.returncode) + self._held()
        return BlockError(self.name, self._call(), how, log=self.log)

    def _held(self) -> str:
        """Whether it had run out of memory."""
        limit = self._limits.memory
        return (
            f"; it had used up the {_amount(limit)} that the block's 'memory' allows"
            if self._peak > 0.8 * limit
            else ""
        )

    def _call(self) -> str:
        part = self._memory.part[0]
        return {SETTING: "fmi2Set", STEPPING: "fmi2DoStep", GETTING: "fmi2Get"}.get(part) or self._memory.call

    # ------------------------------------------------------------ beside the master's loop

    def _watch(self) -> None:
        """Ends the process where a call takes too long, and where it has ended but for what it has started."""
        while not self._ended.wait(min(0.2, self._limits.timeout / 4)):
            now = monotonic()
            if self._stop_by == inf and self._interrupted():
                self._stop_by = now + _GRACE
            self._abandoned = self._abandoned or (self._stop_by < now and self._deadline < inf)
            if self._abandoned or now > self._deadline:
                self._overdue = not self._abandoned
                self._process.kill()
                _kill_all(self._process)
            elif _gone(self._process, 0.0):
                _kill_all(self._process)

    def _listen(self, source: int) -> None:
        """Takes in what the FMU logs and prints, and keeps the last lines of it."""
        rest = b""
        while True:
            try:
                chunk = os.read(source, 1 << 16)
            except OSError:
                return
            *lines, rest = (rest + chunk).split(b"\n")
            if not chunk and rest:
                lines.append(rest)
            for line in lines:
                if line.endswith(MARK):
                    line = line[: -len(MARK)]
                    self._hear(line)
                    self._marked.set()
                else:
                    self._hear(line)
            if not chunk:
                return
            rest = rest[: 1 << 16]

    def _hear(self, line: bytes) -> None:
        text = shortened(line.decode("utf-8", "replace").rstrip())
        if text:
            self._lines.append(text)
            if self._verbose:
                print(f"{self.name}: {text}", file=sys.stderr)


def _start(home: Path) -> subprocess.Popen[bytes]:
    root = str(Path(__file__).resolve().parents[2])
    own: dict[str, Any] = {"start_new_session": True}  # Ctrl-C is for the master alone
    if sys.platform == "win32":
        own = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    environment = {"OPENBLAS_NUM_THREADS": "1", **os.environ, **dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(home))}
    pipe = subprocess.PIPE
    return subprocess.Popen(
        [sys.executable, "-P", "-c", _START, root],
        stdin=pipe,
        stdout=pipe,
        stderr=pipe,
        bufsize=0,
        cwd=home,
        env=environment,
        **own,
    )


def _gone(process: subprocess.Popen[bytes], timeout: float) -> bool:
    """Whether it ends within this time. It keeps its number, so that its group can still be ended."""
    until = monotonic() + timeout
    while not _has_ended(process):
        if monotonic() >= until:
            return False
        sleep(0.001)
    return True


def _has_ended(process: subprocess.Popen[bytes]) -> bool:
    if process.returncode is not None:
        return True
    if sys.platform == "win32":
        return process.poll() is not None
    try:
        return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except ChildProcessError:
        return True


def _kill_all(process: subprocess.Popen[bytes]) -> None:
    """Ends what it has started and left behind, which is of its group."""
    if sys.platform != "win32" and process.returncode is None:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)


_WINDOWS = {0xC0000005: "an access violation", 0xC00000FD: "a stack overflow", 0xC0000409: "an abort"}


def _reap(process: subprocess.Popen[bytes]) -> int:
    """Takes note of its end. Returns the most memory that it held, in bytes, where the system tells."""
    if sys.platform == "win32" or process.returncode is not None or not _has_ended(process):
        with suppress(subprocess.TimeoutExpired):
            process.wait(_GRACE)
        return 0
    try:
        _, status, usage = os.wait4(process.pid, 0)
    except ChildProcessError:
        return 0
    process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def _cause(status: int | None) -> str:
    """How a process ended, by its exit status."""
    if status is not None and status < 0:
        name = signal.Signals(-status).name if -status in set(signal.Signals) else f"signal {-status}"
        text = signal.strsignal(-status) or ""
        return f"crashed with {name}" + (f" ({text.lower()})" if text else "")
    if status in _WINDOWS:
        return f"crashed with {_WINDOWS[status]}"
    return f"ended its process, with exit status {status}"


def _amount(count: int) -> str:
    return f"{count / 1e9:.3g} GB" if count >= 1e9 else f"{count / 1e6:.3g} MB"


def _plain(value: Any) -> Any:
    return value.item() if hasattr(value, "item") else value
