"""A run keeps its device: strangers at its line are refused and named, and neither end nor silence the run."""

from __future__ import annotations

import os
import socket
import struct
import subprocess
import sys
import textwrap
import threading
import time
from contextlib import AbstractContextManager
from pathlib import Path
from random import Random

import numpy as np
import pytest

from fmus.interface import load
from fmus.link import device, wire
from fmus.link.device import GREETING, Device, Reader, frame
from tests.native.driver import Instance, Refused

from . import devices
from .test_link import H, asked, flown
from .test_protocol import PORTS, TOKEN, greeted, lamp

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the devices of these tests use POSIX")
HASH = wire.interface_hash(load("controller"))
OTHER = b"stranger"
STRANGE = {
    "a hello of another run": frame(device.HELLO, 77, 1, GREETING.pack(0, 0, HASH, b"controller", OTHER)),
    "a hello of the first version": frame(device.HELLO, 77, 1, GREETING.pack(0, 0, HASH, b"controller", OTHER)[:-8]),
    "a step of another session": frame(device.STEP, 77, 10**9, bytes(250)),
    "an end of another session": frame(device.END, 77, 10**9, b""),
    "the head of a long frame": struct.pack("<2sBBIIH", b"\xa5\x5a", 2, 4, 77, 1, 280),
    "bytes of no frame": Random(1).randbytes(500),
    "nothing": b"",
}


def direct() -> np.ndarray:
    with Instance("controller") as block:
        return flown(block, 40)


@pytest.mark.parametrize("kind", STRANGE)
def test_datagrams_of_a_stranger_before_each_step_change_no_bit_and_cost_no_request(kind):
    """Each is sent once."""
    port, own = devices.free_port(), direct()
    stop = threading.Event()
    with (
        devices.running("controller", "udp", port),
        asked(f"127.0.0.1:{port}", tries=1) as block,
        _caller(port) as stranger,
    ):
        rows = [flown(block, 0)]

        def disturb() -> None:
            while not stop.is_set():
                stranger.send(STRANGE[kind])
                time.sleep(0.0005)

        thread = threading.Thread(target=disturb)
        thread.start()
        time.sleep(0.01)
        try:
            rows.append(flown(block, 40, begin=False)[1:])
        finally:
            stop.set()
            thread.join()
        assert block.get("link_silent_steps") == 0
        np.testing.assert_array_equal(np.concatenate(rows), own)


@pytest.mark.parametrize("kind", STRANGE)
def test_a_datagram_of_a_stranger_before_the_start_costs_no_run(kind):
    port = devices.free_port()
    with (
        devices.running("controller", "udp", port),
        asked(f"127.0.0.1:{port}", tries=1) as block,
        _caller(port) as stranger,
    ):
        stranger.send(STRANGE[kind])
        np.testing.assert_array_equal(flown(block, 40), direct())


def _caller(port: str) -> socket.socket:
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    line.connect(("127.0.0.1", int(port)))
    return line


@pytest.mark.parametrize("transport", ["udp", "tcp"])
def test_a_second_run_is_refused_by_the_token_of_the_first_and_both_are_named(transport):
    port = devices.free_port()
    with (
        devices.running("controller", transport, port, stderr=subprocess.PIPE) as process,
        asked(f"127.0.0.1:{port}", transport) as first,
    ):
        flown(first, 5)
        with asked(f"127.0.0.1:{port}", transport, time_out=0.3) as second, pytest.raises(Refused) as refused:
            second.initialize()
        first.step(5 * H, H)
        assert first.get("link_restarts") == 0
        process.terminate()
        said = process.communicate()[1].decode()
    words = str(refused.value)
    assert (
        f"device at {transport} 127.0.0.1:{port}: expected a device that no other run uses, found 'in use by" in words
    )
    token = words.partition("in use by run ")[2][:16]
    assert int(token, 16) != 0
    assert said.startswith("refused 127.0.0.1:")
    assert f": in use by run {token}; free when that ends, or 2 s after its last request" in said


def test_the_device_is_free_when_a_run_ends_and_soon_after_one_that_was_killed():
    port = devices.free_port()
    with devices.running("controller", "udp", port):
        for _ in range(2):  # the first has ended
            with asked(f"127.0.0.1:{port}", time_out=0.3) as block:
                flown(block, 3)
        killed = asked(f"127.0.0.1:{port}", time_out=0.3)
        flown(killed.__enter__(), 3)  # it never says that it ends
        with asked(f"127.0.0.1:{port}", time_out=6.0) as block:
            begin = time.monotonic()
            flown(block, 3)
            assert time.monotonic() - begin > 1.5
        killed.__exit__(None, None, None)


def _python(*line: str) -> list[str]:
    """A Python device with the ports of a lamp."""
    program = f"""
        import sys
        from fmus.link.device import Device
        from fmus.link.lines import serve
        from tests.fmus.link.test_protocol import lamp
        serve(lamp().receive, {list(line)!r})
    """
    return [sys.executable, "-c", textwrap.dedent(program)]


def _c(*line: str) -> list[str]:
    return [str(devices.program("controller")), *line]


def _started(command: list[str]) -> AbstractContextManager[subprocess.Popen[bytes]]:
    root = str(Path(__file__).parents[3])
    return devices.started(command, stderr=subprocess.PIPE, env={**os.environ, "PYTHONPATH": root})


@pytest.mark.parametrize("end", [_c, _python], ids=["C", "Python"])
def test_idle_callers_and_one_that_resets_block_no_device(end):
    port = devices.free_port(socket.SOCK_STREAM)
    ports = PORTS if end is _python else None
    digest = ports.hash if ports else HASH
    hello = frame(device.HELLO, 5, 1, GREETING.pack(0, 0, digest, b"x", TOKEN))
    with _started(end("tcp", port)):
        idle = [socket.create_connection(("127.0.0.1", int(port))) for _ in range(12)]
        idle[3].sendall(hello[:20])  # a frame that it never ends
        idle[4].setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        idle[4].close()
        with socket.create_connection(("127.0.0.1", int(port)), timeout=5.0) as caller:
            for k in range(3):
                caller.sendall(frame(device.HELLO, 5, 1 + k, GREETING.pack(0, 0, digest, b"x", TOKEN)))
                (answer,) = Reader(500).feed(caller.recv(500))
                assert (answer.type, answer.sequence) == (device.HELLO | device.ANSWER, 1 + k)
        for line in idle:
            line.close()


@pytest.mark.parametrize("end", [_c, _python], ids=["C", "Python"])
@pytest.mark.parametrize("transport", ["udp", "tcp"])
@pytest.mark.parametrize("listen", [(), ("--listen", "0.0.0.0")], ids=["unless told", "where told"])
def test_a_device_listens_at_loopback_alone_unless_told(end, transport, listen):
    port = devices.free_port(socket.SOCK_STREAM if transport == "tcp" else socket.SOCK_DGRAM)
    with _started(end(transport, port, *listen)) as process:
        table = Path(f"/proc/{process.pid}/net/{transport}")
        if not table.exists():
            pytest.skip("the addresses of sockets are looked up in /proc")
        rows = [row.split()[1].split(":") for row in table.read_text().splitlines()[1:]]
        at = [address for address, number in rows if int(number, 16) == int(port)]
    assert at == ["00000000" if listen else "0100007F"]


@pytest.mark.parametrize("end", [_c, _python], ids=["C", "Python"])
@pytest.mark.parametrize(
    "arguments", [("udp",), ("udp", "1", "--listen"), ("udp", "1", "--other", "0.0.0.0"), ("fax", "1")]
)
def test_wrong_arguments_of_a_device_show_its_use(end, arguments):
    done = subprocess.run(end(*arguments), capture_output=True, text=True, check=False, timeout=30)
    assert (done.returncode, done.stderr.count("use:")) == (1, 1)
    assert "udp PORT [--listen ADDRESS]" in done.stderr


# ---------------------------------------------------------------- the device in Python


def _hello(session: int, token: bytes) -> bytes:
    return frame(device.HELLO, session, 1, GREETING.pack(0, 0, PORTS.hash, b"lamp", token))


def test_a_python_device_refuses_and_names_a_stranger_and_keeps_the_run_s_answer(capsys):
    it = greeted(lamp())
    step = frame(device.STEP, 1, 4, struct.pack("<ddd", 0.0, 1.0, 2.0))
    answer = it.receive(step)
    (refusal,) = Reader(200).feed(it.receive(_hello(9, OTHER), "10.0.0.7:99", True))
    assert (refusal.type, refusal.session, refusal.payload[0]) == (device.REFUSED, 9, device.IN_USE)
    assert refusal.payload[1:].startswith(b"in use by run 0102030405060708; free when")
    assert capsys.readouterr().err == f"refused 10.0.0.7:99: {refusal.payload[1:].rstrip(bytes(1)).decode()}\n"
    assert it.receive(step) == answer


def test_a_python_device_is_taken_by_another_run_after_an_end_or_when_it_was_quiet(monkeypatch):
    it = greeted(lamp())
    assert it.receive(frame(device.END, 1, 4, b"")) == b""
    assert next(Reader(200).feed(it.receive(_hello(9, OTHER)))).type == device.HELLO | device.ANSWER
    monkeypatch.setattr(device, "LEASE_OF_HELLO", 0.05)
    assert next(Reader(200).feed(it.receive(_hello(11, TOKEN)))).type == device.REFUSED
    time.sleep(0.06)
    greeting = next(Reader(200).feed(it.receive(_hello(11, TOKEN))))
    assert (greeting.type, GREETING.unpack(greeting.payload)[4]) == (device.HELLO | device.ANSWER, TOKEN)


def test_the_hello_of_a_run_whose_line_was_cut_is_its_own():
    """The same token, in the same session: the device keeps its memory."""
    it: Device = greeted(lamp())
    hello = frame(device.HELLO, 1, 9, GREETING.pack(0, 0, PORTS.hash, b"lamp", TOKEN))
    greeting = next(Reader(200).feed(it.receive(hello)))
    assert (greeting.type, greeting.payload[1]) == (device.HELLO | device.ANSWER, 1)


def test_a_datagram_is_not_the_end_of_one_before_it():
    it = greeted(lamp())
    step = frame(device.STEP, 1, 4, struct.pack("<ddd", 0.0, 1.0, 2.0))
    assert it.receive(step[:30], "a", True) == b""
    assert it.receive(step, "b", True) != b""


# ---------------------------------------------------------------- versions


def test_both_ends_and_both_pages_state_the_same_version_of_the_protocol():
    root = Path(__file__).parents[3]
    header = (root / "fmus" / "link" / "native" / "frame.h").read_text()
    page = (root / "docs" / "use" / "link-protocol.md").read_text()
    assert f"LINK_VERSION = {device.VERSION}," in header
    assert f"between a link FMU and a device: version {device.VERSION}." in page
    toml = (root / "fmus" / "link" / "link.toml").read_text()
    assert toml.startswith(f"# Version {device.VERSION} of the protocol")
    assert (
        f'"version {device.VERSION} of the protocol"' in (root / "fmus" / "link" / "native" / "exchange.c").read_text()
    )
