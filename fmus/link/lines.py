"""Lines of the link in Python: UDP, TCP, a serial line, a pair of named pipes. It needs nothing but Python; a kit holds
a copy of it.
"""

from __future__ import annotations

import os
import select
import socket
import sys
from collections.abc import Callable
from contextlib import suppress

KINDS = ("udp", "tcp", "serial", "pipe")


def serve(receive: Callable[[bytes], bytes], arguments: list[str]) -> None:
    """Answers for ever with what `receive` returns: `udp PORT`, `tcp PORT`, `serial PATH`, `pipe ADDRESS`.

    Serial lines (115200 baud) and pipes (ADDRESS.in, ADDRESS.out) are those of Linux and macOS; on Windows take
    pyserial.
    """
    if len(arguments) != 2 or arguments[0] not in KINDS:
        sys.exit("use: udp PORT | tcp PORT | serial PATH | pipe ADDRESS")
    kind, place = arguments
    if kind == "udp":
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            line.bind(("", int(place)))
            print("ready", flush=True)
            while True:
                data, peer = line.recvfrom(65536)
                if answers := receive(data):
                    line.sendto(answers, peer)
    elif kind == "tcp":
        with socket.create_server(("", int(place))) as server:
            print("ready", flush=True)
            while True:
                _answer_caller(receive, server.accept()[0])
    else:
        source, target = _files(kind, place, "in", "out")
        print("ready", flush=True)
        while data := os.read(source, 65536):
            _write(target, receive(data))


def _answer_caller(receive: Callable[[bytes], bytes], line: socket.socket) -> None:
    with line, suppress(ConnectionError):  # a caller that leaves with answers unread resets the line
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        while data := line.recv(65536):
            line.sendall(receive(data))


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
