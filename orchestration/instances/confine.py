"""What the process of an isolated FMU does to itself: its memory is bounded, it ends with the master, it prints at
once."""

from __future__ import annotations

import ctypes
import os
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

_PARENT_DEATH_SIGNAL, _SIGKILL = 1, 9


def end_with(master: int) -> None:
    """Lets this process end when the master does, also where the FMU does not return."""
    if sys.platform == "linux":
        with suppress(Exception):
            ctypes.CDLL(None).prctl(_PARENT_DEATH_SIGNAL, _SIGKILL, 0, 0, 0)
            if os.getppid() != master:
                os._exit(1)
            return
    threading.Thread(target=_outlived, args=(master,), daemon=True).start()


def _outlived(master: int) -> NoReturn:
    if sys.platform == "win32":
        kernel = ctypes.windll.kernel32
        kernel.OpenProcess.restype = ctypes.c_void_p
        synchronize, forever = 0x00100000, -1
        kernel.WaitForSingleObject(ctypes.c_void_p(kernel.OpenProcess(synchronize, False, master)), forever)
    else:
        while os.getppid() == master:
            time.sleep(0.5)
    os._exit(1)


def limit_memory(bytes_max: int | None) -> None:
    """Bounds memory, where the system can, and leaves no core file after a crash."""
    if sys.platform == "win32":
        return
    import resource  # here, since Windows has none  # noqa: PLC0415

    with suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if bytes_max is not None and sys.platform == "linux":
        with suppress(ValueError, OSError):
            limit = bytes_max + _data_now()
            resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))


def _data_now() -> int:
    status = Path("/proc/self/status").read_text()
    return 1024 * int(status.partition("VmData:")[2].split()[0])


def print_at_once() -> None:
    """Sends each line on as it is printed: a pipe would else keep much back, and a crash lose it."""
    with suppress(Exception):
        sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    by_line = 1  # _IOLBF of glibc, musl and macOS
    for name in ("stdout", "__stdoutp"):
        with suppress(Exception):
            c = ctypes.CDLL(None)
            c.setvbuf(ctypes.c_void_p.in_dll(c, name), None, by_line, ctypes.c_size_t(1024))


def flush() -> None:
    """Out with what C and Python still hold back."""
    with suppress(Exception):
        sys.stdout.flush()
        sys.stderr.flush()
        ctypes.CDLL(None).fflush(None)


def take_pipes() -> tuple[int, int]:
    """The pipes from and to the master, in the places of which standard input is empty and prints go to standard
    error."""
    source, to = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    os.close(nothing)
    if sys.platform == "win32":
        import msvcrt  # here, since only Windows has it  # noqa: PLC0415

        for pipe in (source, to):
            msvcrt.setmode(pipe, os.O_BINARY)
    return source, to
