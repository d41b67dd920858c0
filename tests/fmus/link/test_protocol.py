"""The protocol's page says what the code does, and the ends agree that are written apart: C, Python, and the page's own
bytes."""

from __future__ import annotations

import binascii
import re
import struct
import subprocess
import sys
import zlib
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import pytest

from fmus.interface import InterfaceError, load, parse
from fmus.kit import linked
from fmus.link import bench, device, wire
from fmus.link.device import Device, Field, Layout, Ports, Reader, Refused, frame

PAGE = (Path(__file__).parents[3] / "docs" / "use" / "link-protocol.md").read_text("utf-8")
LAMP = """
[block]
name = "lamp"
description = "A lamp"
[experiment]
stop = 1.0
step = 0.1
[variables.light_B]
causality = "output"
shape = [3]
unit = "cd"
frame = "B"
description = "its light"
depends_on = ["demand"]
[variables.demand]
causality = "input"
unit = "V"
description = "its voltage"
start = 0.0
[variables.dimmed]
causality = "parameter"
variability = "fixed"
type = "boolean"
description = "less of it"
start = false
"""
TOKEN = bytes(range(1, 9))
PORTS = Ports(
    "lamp",
    wire.interface_hash(parse(LAMP)),
    (Field("dimmed", "boolean", (), False),),
    (Field("demand", "real", (), 0.0),),
    (Field("light_B", "real", (3,)),),
)


def blocks() -> list[bytes]:
    """The bytes that the page's example shows."""
    shown = re.findall(r"```\n((?:[0-9a-f]{2}[ \n])+)```", PAGE.partition("## Example")[2])
    return [binascii.unhexlify(re.sub(r"\s", "", text)) for text in shown]


def lamp(calls: list[float] | None = None) -> Device:
    def sample(p, memory, u, t, h):
        if u.demand > 100.0:
            raise Refused("demand: expected at most 100 V")
        if calls is not None:
            calls.append(t + h)
        return {"light_B": [u.demand, t, h]}

    return Device(PORTS, sample)


def greeted(device_: Device, session: int = 1) -> Device:
    hello = device.GREETING.pack(0, 0, PORTS.hash, b"lamp", TOKEN)
    device_.receive(frame(device.HELLO, session, 1, hello) + frame(device.PARAMETERS, session, 2, b"\0"))
    device_.receive(frame(device.START, session, 3, struct.pack("<ddd", 0.0, 0.0, 1.0)))
    return device_


def test_the_page_s_example_is_what_the_code_sends():
    digest, hello, told, step = blocks()
    assert digest == wire.interface_hash(parse(LAMP))
    assert hello == frame(device.HELLO, 1, 1, device.GREETING.pack(0, 0, digest, b"lamp", TOKEN))
    assert told == frame(device.PARAMETERS | device.ANSWER, 1, 2, b"")
    assert step == frame(device.STEP, 1, 4, struct.pack("<ddd", 0.5, 0.1, -2.0))
    answer = greeted(lamp()).receive(step)
    assert Layout(PORTS.outputs, 0).unpack(next(Reader(200).feed(answer)).payload[8:]).light_B == [-2.0, 0.5, 0.1]
    assert f"`{zlib.crc32(b'123456789'):08X}`" in PAGE


@pytest.mark.parametrize(
    ("old", "new"),
    [('unit = "V"', 'unit = "mV"'), ('unit = "V"', 'type = "integer"'), ("[3]", "[1, 3]"), ('"B"', '"N"')],
)
def test_a_change_of_meaning_changes_the_hash(old, new):
    assert wire.interface_hash(parse(LAMP.replace(old, new))) != wire.interface_hash(parse(LAMP))


def test_a_change_of_words_or_limits_does_not_change_the_hash():
    told = LAMP.replace("its voltage", "another text").replace("start = 0.0", "start = 1.0\nmax = 100.0")
    assert wire.interface_hash(parse(told)) == wire.interface_hash(parse(LAMP))


def test_each_request_is_met_once_and_a_late_one_not_at_all():
    calls: list[float] = []
    it = greeted(lamp(calls))
    step = [frame(device.STEP, 1, 4 + k, struct.pack("<ddd", k, 1.0, 0.0)) for k in range(3)]
    first = it.receive(step[0])
    assert it.receive(step[0]) == first
    second = it.receive(step[1])
    assert it.receive(step[0]) == b""
    assert it.receive(step[1] + step[1]) == second * 2
    assert it.receive(frame(device.STEP, 2, 9, b"")) == b"", "of another session"
    assert calls == [0.0, 1.0, 2.0]


def test_a_device_that_a_run_has_left_is_free_for_the_next_at_once_and_knows_nothing_each_time():
    it = lamp()
    for session in (1, 2, 3):
        greeted(it, session)
        assert it.receive(frame(device.END, session, 4, b"")) == b""
        for asked in (device.STEP, device.START):
            answer = next(Reader(200).feed(it.receive(frame(asked, session, 5 + asked, struct.pack("<ddd", 0, 1, 0)))))
            assert (answer.type, answer.payload[0]) == (device.REFUSED, device.NOT_STARTED)
        other = device.GREETING.pack(0, 0, PORTS.hash, b"lamp", bytes(range(session, session + 8)))
        answer = next(Reader(200).feed(it.receive(frame(device.HELLO, 9 + session, 1, other))))
        assert answer.type == device.HELLO | device.ANSWER
        it.receive(frame(device.END, 9 + session, 2, b""))


@pytest.mark.parametrize(("rows", "fits"), [(8189, True), (8190, False)])
def test_an_interface_that_a_length_of_two_bytes_cannot_tell_is_refused(rows, fits):
    """8 bytes of each input, and two times before them."""
    demands = f"shape = [{rows}]\nstart = {[0.0] * rows}"
    interface = parse(LAMP.replace("start = 0.0", demands))
    with nullcontext() if fits else pytest.raises(InterfaceError, match="at most 65535 bytes .*found 65536"):
        assert wire.frame_max(interface) > 65528


@pytest.mark.parametrize(
    ("request_", "code", "text"),
    [
        (frame(device.STEP, 1, 9, b"\0" * 5), device.WRONG_SIZE, b"another number of bytes"),
        (frame(device.STEP, 1, 9, struct.pack("<ddd", 0, 1, 200.0)), device.BLOCK_REFUSES, b"demand: expected at most"),
    ],
)
def test_a_refusal_has_its_code_and_says_why(request_, code, text):
    answer = next(Reader(200).feed(greeted(lamp()).receive(request_)))
    assert (answer.type, answer.payload[0], answer.payload[1:].startswith(text)) == (device.REFUSED, code, True)


@pytest.mark.parametrize("asked", [device.STEP, device.START, device.PARAMETERS])
def test_a_device_that_has_just_begun_says_that_it_knows_nothing(asked):
    answer = next(Reader(200).feed(lamp().receive(frame(asked, 7, 9, b""))))
    assert (answer.type, answer.session, answer.sequence, answer.payload[0]) == (
        device.REFUSED,
        7,
        9,
        device.NOT_STARTED,
    )


@pytest.mark.parametrize(
    "before", [b"\xa5", b"\xa5\x5a", b"\xa5\x5a" * 9, bytes(300), b"\xa5\x5a\x01\x04" + b"\xff" * 10]
)
def test_a_frame_is_found_behind_any_bytes_and_however_they_are_cut(before):
    good = frame(device.STEP, 1, 4, b"payload")
    for size in (1, 3, 1000):
        reader, stream = Reader(200), before + good + good
        cut = [stream[i : i + size] for i in range(0, len(stream), size)]
        assert [f.payload for part in cut for f in reader.feed(part)] == [b"payload"] * 2


def test_a_text_ends_at_its_first_zero_whatever_is_behind_it():
    layout = Layout((Field("epoch", "string", (), "", 8), Field("on", "boolean", (), False)), 0)
    assert layout.unpack(b"2009\0old\1") == SimpleNamespace(epoch="2009", on=1)
    assert layout.unpack(b"20090810\0").epoch == "20090810"


class Inside:
    """A line to a Python device in this process."""

    def __init__(self, device_: Device) -> None:
        self._device, self._answers = device_, b""

    def send(self, data: bytes) -> None:
        self._answers += self._device.receive(data)

    def receive(self, wait: float) -> bytes:
        data, self._answers = self._answers, b""
        return data


def test_the_bench_plays_a_vector_and_names_what_differs(tmp_path, capsys):
    (tmp_path / "parameters.csv").write_text("name,value\ndimmed,1\n")
    (tmp_path / "vector.csv").write_text(
        "time,demand,light_B[1],light_B[2],light_B[3]\n0.0,3.0,3.0,0.0,0.0\n0.5,4.0,4.0,0.0,0.5\n1.0,5.0,5.1,0.5,0.5\n"
    )
    assert not bench.compare(PORTS, tmp_path, Inside(lamp()))
    shown = capsys.readouterr().out
    assert re.search(r"^DIFFER  light_B\[1\] +0.1 +0.02  1 s$", shown, re.M)
    assert shown.count("ok    ") == 2
    (tmp_path / "vector.csv").write_text("time,demand,light_B[1]\n0.0,0.001,0.001\n0.5,0.002,0.0020001\n")
    assert not bench.compare(PORTS, tmp_path, Inside(lamp())), "5e-5 of a small output"
    capsys.readouterr()
    with pytest.raises(
        bench.Failed, match="built for the interface lamp with other ports or parameters; expected lamp"
    ):
        bench.compare(
            Ports("lamp", bytes(8), *(PORTS.parameters, PORTS.inputs, PORTS.outputs)), tmp_path, Inside(lamp())
        )


def test_the_bench_does_not_wait_for_ever(tmp_path, monkeypatch):
    class Dead(Inside):
        def send(self, data: bytes) -> None:
            pass

    monkeypatch.setattr(bench, "WAIT", 0.01)
    (tmp_path / "parameters.csv").write_text("name,value\n")
    (tmp_path / "vector.csv").write_text("time,demand\n0.0,3.0\n")
    with pytest.raises(bench.Failed, match=re.escape("expected an answer within 0.04 s, found none")):
        bench.compare(PORTS, tmp_path, Dead(lamp()))


def test_the_kit_s_python_ports_are_those_of_the_interface():
    scope: dict = {}
    exec(linked.python_ports(load("plant")).replace("from link.device", "from fmus.link.device"), scope)
    ports, plant = scope["PORTS"], load("plant")
    assert (ports.hash, ports.name) == (wire.interface_hash(plant), "plant")
    assert [f.name for f in ports.parameters] == [v.name for v in plant.of("parameter")]
    assert ports.largest >= wire.frame_max(plant)
    sizes = {c: Layout(getattr(ports, f"{c}s"), 0).size for c in wire.RECORDS}
    assert sizes == {c: sum(wire.SIZES[v.type] * len(v.elements) for v in plant.of(c)) for c in wire.RECORDS}


@pytest.mark.skipif(sys.platform == "win32", reason="what it fuzzes uses POSIX")
@pytest.mark.parametrize("end", ["device", "master"])
def test_random_frames_under_sanitizers(end):
    from tests.native.fuzzer import compiler

    from .fuzzer import fuzzer

    program = fuzzer(end, compiler("system") or compiler("zig"))
    run = subprocess.run([program, "1", "20000"], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert int(run.stdout.split()[0]) >= 20000
