"""QEMU's Cortex-M7 with a firmware: its line as a TCP port on this machine, and what each call cost.
Tests: tests/fmus/link/test_emulated.py."""

from __future__ import annotations

import socket
import subprocess
import threading
import time
from pathlib import Path
from types import TracebackType

import numpy as np
import numpy.typing as npt

from orchestration import InputError

from ..tools import tool
from .firmware import CORTEX_M7, Board

TICK = 40
"""Instructions in a tick of the board's counter: it counts at 25 MHz, and an instruction takes 1 ns of the board's
time."""
_START = 1 << 31
_PATIENCE = 10.0  # s, for QEMU to open its ports


class Emulator:
    """A running board, until the end of the `with` block.

    address      HOST:PORT of its line, for the parameter link_address
    calls        (n, 3) of the calls so far: instructions, to 40; bytes of stack used since power-up; 1 at the start
    of a run
    """

    def __init__(self, elf: Path, board: Board = CORTEX_M7) -> None:
        ports = _free_ports(2)
        self.address = f"127.0.0.1:{ports[0]}"
        serial = [
            option for port in ports for option in ("-serial", f"tcp:127.0.0.1:{port},server=on,wait=off,nodelay=on")
        ]
        command = [tool("qemu-system-arm"), "-M", board.machine, "-display", "none", "-monitor", "none"]
        self._qemu = subprocess.Popen([*command, "-icount", "shift=0", *serial, "-kernel", str(elf)])
        self._bytes = bytearray()
        self._report = _connected(ports[1], self._qemu)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        while data := self._report.recv(1 << 16):
            self._bytes += data

    @property
    def calls(self) -> npt.NDArray[np.int64]:
        whole = len(self._bytes) // 8 * 8
        ticks, stack = np.frombuffer(bytes(self._bytes[:whole]), "<u4").reshape(-1, 2).astype(np.int64).T
        return np.column_stack((TICK * (ticks & ~_START), stack, ticks >> 31))

    def __enter__(self) -> Emulator:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._qemu.kill()
        self._qemu.wait()
        self._reader.join(_PATIENCE)
        self._report.close()


def _free_ports(n: int) -> list[int]:
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(n)]
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


def _connected(port: int, qemu: subprocess.Popen[bytes]) -> socket.socket:
    end = time.monotonic() + _PATIENCE
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port))
        except ConnectionRefusedError:
            if qemu.poll() is not None or time.monotonic() > end:
                raise InputError(f"qemu-system-arm opened no port within {_PATIENCE:g} s") from None
            time.sleep(0.05)
