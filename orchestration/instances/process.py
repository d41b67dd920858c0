"""The process of an isolated FMU with all that it starts: its start, its end, and why it ended."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep
from typing import Any

GRACE = 2.0
"""Seconds that a process has for ending once its pipes are closed, and a call once the run is to end."""
_START = "import sys; sys.path.append(sys.argv[1]); from orchestration.instances.worker import main; main()"
"""This process's own path may hold what FMUs have put there, so the worker makes one of its own."""
_WINDOWS = {0xC0000005: "an access violation", 0xC00000FD: "a stack overflow", 0xC0000409: "an abort"}


@dataclass(frozen=True)
class Limits:
    """Limits of an isolated FMU."""

    timeout: float
    """Seconds that any one call may take."""
    memory: int
    """Bytes that the FMU may take."""


class Process:
    """A worker's process, which leads a group of its own."""

    def __init__(self, home: Path, files: Sequence[int] = ()) -> None:
        """Starts it in the folder `home`, where its temporary files go, too; `files` are descriptors that it keeps."""
        own: dict[str, Any] = {"start_new_session": True}  # Ctrl-C is for the master alone
        if sys.platform == "win32":
            own = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
        environment = {"OPENBLAS_NUM_THREADS": "1", **os.environ, **dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(home))}
        self._popen = subprocess.Popen(
            [sys.executable, "-P", "-c", _START, str(Path(__file__).resolve().parents[2])],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            cwd=home,
            pass_fds=files,
            env=environment,
            **own,
        )
        assert self._popen.stdin is not None
        assert self._popen.stdout is not None
        assert self._popen.stderr is not None
        self._pipes = self._popen.stdin, self._popen.stdout
        self.to, self.source = (pipe.fileno() for pipe in self._pipes)
        self.errors = self._popen.stderr.fileno()
        self.peak = 0
        """The most memory that it held, in bytes, where the system tells; known once it is reaped."""

    def gone(self, timeout: float) -> bool:
        """Returns whether it ends within this time. It keeps its number, so that its group can still be ended."""
        until = monotonic() + timeout
        while not self._has_ended():
            if monotonic() >= until:
                return False
            sleep(0.001)
        return True

    def _has_ended(self) -> bool:
        if self._popen.returncode is not None:
            return True
        if sys.platform == "win32":
            return self._popen.poll() is not None
        try:
            return os.waitid(os.P_PID, self._popen.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
        except ChildProcessError:
            return True

    def kill(self) -> None:
        """Ends it at once, with its group."""
        self._popen.kill()
        self.kill_group()

    def kill_group(self) -> None:
        """Ends what it has started and left behind, which is of its group."""
        if sys.platform != "win32" and self._popen.returncode is None:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._popen.pid, signal.SIGKILL)

    def end(self) -> None:
        """Closes its pipes, upon which it ends by itself or is ended; nothing of its group is left."""
        for pipe in self._pipes:
            with suppress(OSError):
                pipe.close()
        if not self.gone(GRACE):
            self._popen.kill()
            self.gone(GRACE)
        self.kill_group()

    def reap(self) -> None:
        """Takes note of its end, after which its number may be another's."""
        process = self._popen
        if sys.platform == "win32" or process.returncode is not None or not self._has_ended():
            with suppress(subprocess.TimeoutExpired):
                process.wait(GRACE)
            return
        try:
            _, status, usage = os.wait4(process.pid, 0)
        except ChildProcessError:
            return
        process.returncode = os.waitstatus_to_exitcode(status)
        self.peak = usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)

    @property
    def cause(self) -> str:
        """Its end in words, by its exit status."""
        status = self._popen.returncode
        if status is not None and status < 0:
            text = signal.strsignal(-status) or ""
            return f"crashed with {signal_name(-status)}" + (f" ({text.lower()})" if text else "")
        if status in _WINDOWS:
            return f"crashed with {_WINDOWS[status]}"
        return f"ended its process, with exit status {status}"


def signal_name(number: int) -> str:
    """Returns the name of a signal; those of real time have none."""
    return signal.Signals(number).name if number in set(signal.Signals) else f"signal {number}"
