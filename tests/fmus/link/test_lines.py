"""The Python lines of a device, as a kit has them."""

from __future__ import annotations

import socket
import struct
import threading

from fmus.link import lines


def test_a_device_answers_the_next_caller_after_one_that_reset_the_line():
    """A caller that closes with an answer unread, or at once, resets the line; the device goes on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    threading.Thread(target=lines.serve, args=(upper, ["tcp", f"{port}"]), daemon=True).start()
    for _ in range(3):
        with connected(port) as line:
            line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            line.sendall(b"a")
    with connected(port) as line:
        line.sendall(b"b")
        assert line.recv(10) == b"B"


def upper(data: bytes, sender: str, turned: bool) -> bytes:
    return data.upper()


def connected(port: int) -> socket.socket:
    for _ in range(500):
        try:
            return socket.create_connection(("127.0.0.1", port), timeout=10.0)
        except ConnectionRefusedError:
            threading.Event().wait(0.02)
    raise TimeoutError(f"nobody listens at {port}")
