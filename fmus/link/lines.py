"""Lines of the link in Python: UDP, TCP, a serial line, a pair of named pipes. It needs nothing but Python; a kit holds
a copy of it.
"""

from __future__ import annotations

import os
import select
import selectors
import socket
import sys
from collections.abc import Callable
from contextlib import suppress

KINDS = ("udp", "tcp", "serial", "pipe")


USE = "use: udp PORT [--listen ADDRESS] | tcp PORT [--listen ADDRESS] | serial PATH | pipe ADDRESS"
CALLERS = 8
"""By TCP at the same time; one more takes the place of the one that has been quiet longest."""
Receive = Callable[[bytes, str, bool], bytes]
"""The answers to bytes; from whom they come; whether another datagram or sender begins with them."""


def serve(receive: Receive, arguments: list[str]) -> None:
    """Answers for ever with what `receive` returns: `udp PORT`, `tcp PORT`, `serial PATH`, `pipe ADDRESS`.

    UDP and TCP listen at 127.0.0.1; `--listen 0.0.0.0` behind the port: at all addresses of this computer.
    Serial lines (115200 baud) and pipes (ADDRESS.in, ADDRESS.out) are those of Linux and macOS; on Windows take
    pyserial.
    """
    place, listen = arguments[:2], arguments[2:]
    if len(place) != 2 or place[0] not in KINDS or (listen and (len(listen) != 2 or listen[0] != "--listen")):
        sys.exit(USE)
    host = listen[1] if listen else "127.0.0.1"
    if place[0] == "udp":
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            line.bind((host, int(place[1])))
            print("ready", flush=True)
            while True:
                data, peer = line.recvfrom(65536)
                if answers := receive(data, _name(peer), True):
                    with suppress(OSError):  # a sender that cannot be reached asks again
                        line.sendto(answers, peer)
    elif place[0] == "tcp":
        with socket.create_server((host, int(place[1]))) as server:
            print("ready", flush=True)
            _answer_callers(receive, server)
    else:
        source, target = _files(place[0], place[1], "in", "out")
        print("ready", flush=True)
        while data := os.read(source, 65536):
            _write(target, receive(data, "", False))


def _name(peer: tuple[str, int]) -> str:
    return f"{peer[0]}:{peer[1]}"


def _answer_callers(receive: Receive, server: socket.socket) -> None:
    """Serves each that sends something; one that sends nothing keeps nobody else waiting."""
    callers: list[socket.socket] = []
    last: socket.socket | None = None
    with selectors.DefaultSelector() as ready:
        ready.register(server, selectors.EVENT_READ)
        while True:
            for line in [key.fileobj for key, _ in ready.select()]:
                if line is server:
                    if len(callers) == CALLERS:
                        _leave(ready, callers, callers[0])
                    callers.append(server.accept()[0])
                    callers[-1].setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    callers[-1].settimeout(1.0)  # one that takes no answers
                    ready.register(callers[-1], selectors.EVENT_READ)
                elif line in callers:
                    if not _answer_caller(receive, line, line is not last):
                        _leave(ready, callers, line)
                    else:  # the one that has been quiet longest comes first
                        callers.append(callers.pop(callers.index(line)))
                    last = line


def _leave(ready: selectors.BaseSelector, callers: list[socket.socket], line: socket.socket) -> None:
    ready.unregister(line)
    callers.remove(line)
    line.close()


def _answer_caller(receive: Receive, line: socket.socket, turned: bool) -> bool:
    """Returns whether the caller stays; one that leaves with answers unread resets the line."""
    with suppress(OSError):
        if data := line.recv(65536):
            line.sendall(receive(data, _name(line.getpeername()), turned))
            return True
    return False


class Line:
    """The other end: a line to a device at HOST:PORT, a serial PATH or the pipe ADDRESS."""

    def __init__(self, kind: str, place: str) -> None:
        if kind in ("udp", "tcp"):
            host, _, port = place.rpartition(":")
            stream = kind == "tcp"
            self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM if stream else socket.SOCK_DGRAM)
            self._socket.connect((host or "127.0.0.1", int(port)))
            self._source = self._target = self._socket.fileno()
        else:
            self._source, self._target = _files(kind, place, "out", "in")

    def send(self, data: bytes) -> None:
        _write(self._target, data)

    def receive(self, wait: float) -> bytes:
        """Returns the bytes that come within the time; none where none come."""
        if not select.select([self._source], [], [], max(wait, 0.0))[0]:
            return b""
        try:
            return os.read(self._source, 65536)
        except ConnectionRefusedError:  # nobody listens at the UDP port yet
            return b""


def _files(kind: str, place: str, source: str, target: str) -> tuple[int, int]:
    if kind == "serial":
        import termios  # here, since Windows has none  # noqa: PLC0415
        import tty  # here, since Windows has none  # noqa: PLC0415

        line = os.open(place, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(line)
        state = termios.tcgetattr(line)
        state[4] = state[5] = termios.B115200
        termios.tcsetattr(line, termios.TCSANOW, state)
        return line, line
    for end in (source, target):
        if not os.path.exists(f"{place}.{end}"):
            os.mkfifo(f"{place}.{end}", 0o600)
    return os.open(f"{place}.{source}", os.O_RDWR), os.open(f"{place}.{target}", os.O_RDWR)


def _write(file: int, data: bytes) -> None:
    while data:
        data = data[os.write(file, data) :]
