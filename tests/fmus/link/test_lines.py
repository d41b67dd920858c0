"""The Python lines of a device, as a kit has them."""

from __future__ import annotations

import os
import socket
import struct
import threading
from time import monotonic

import pytest

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


def test_a_line_waits_as_long_as_it_is_told_for_what_comes_and_not_at_all_for_less_than_nothing():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as device:
        device.bind(("127.0.0.1", 0))
        line = lines.Line("udp", f"127.0.0.1:{device.getsockname()[1]}")
        line.send(b"a")
        _, caller = device.recvfrom(10)
        begun = monotonic()
        assert line.receive(0.1) == b""
        assert monotonic() - begun >= 0.1
        assert line.receive(-1.0) == b""
        timer = threading.Timer(0.05, device.sendto, (b"b", caller))
        timer.start()
        assert line.receive(30.0) == b"b"
        timer.join()


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="terminals are of Linux and macOS")
def test_a_device_answers_on_a_serial_line_byte_by_byte_as_it_is_asked(capsys):
    host, line = os.openpty()
    threading.Thread(target=lines.serve, args=(upper, ["serial", os.ttyname(line)]), daemon=True).start()
    assert any("ready" in capsys.readouterr().out or threading.Event().wait(0.01) for _ in range(3000))
    for asked in (b"a", b"\x03\r\n", b"bc"):  # also what a terminal would take for its own
        os.write(host, asked)
        assert os.read(host, 10) == asked.upper()


def upper(data: bytes, sender: str, turned: bool) -> bytes:
    return data.upper()


def connected(port: int) -> socket.socket:
    for _ in range(500):
        try:
            return socket.create_connection(("127.0.0.1", port), timeout=10.0)
        except ConnectionRefusedError:
            threading.Event().wait(0.02)
    raise TimeoutError(f"nobody listens at {port}")


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["udp"],
        ["fax", "7001"],
        ["7001", "udp"],
        ["udp", "7001", "--listen"],
        ["udp", "7001", "--hear", "0.0.0.0"],
        ["udp", "7001", "--listen", "0.0.0.0", "more"],
    ],
)
def test_what_is_no_place_to_listen_at_is_refused_with_the_use(arguments):
    with pytest.raises(SystemExit) as ended:
        lines.serve(lambda *_: pytest.fail("it listens"), arguments)
    assert ended.value.code == lines.USE


@pytest.mark.parametrize("kind", ["udp", "tcp"])
@pytest.mark.parametrize("more", [[], ["--listen", "127.0.0.1"]])
def test_a_port_that_is_none_is_looked_at_behind_the_use(kind, more):
    """These are well formed: it is the socket that refuses them."""
    with pytest.raises((OverflowError, OSError)):
        lines.serve(lambda *_: b"", [kind, "99999", *more])
