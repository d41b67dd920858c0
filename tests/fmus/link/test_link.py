"""A device in the place of a block: lock-step gives the block's own bits on every line, and each fault of a line ends
as documented."""

from __future__ import annotations

import os
import struct
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from random import Random

import numpy as np
import pytest

from fmus import link
from fmus.interface import load
from fmus.link.device import ANSWER, BLOCK_REFUSES, REFUSED, STEP, Reader, frame
from tests.native.driver import Instance, Refused

from . import devices
from .proxy import Proxy, as_they_are, datagrams, terminals

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the devices of these tests use POSIX")
STEPS, H = 40, 0.1
OUTPUTS = [v.name for v in load("controller").of("output")]
NO_PORT = "link_address: expected HOST:PORT with a port from 1 to 65535, found "


def inputs(k: int) -> dict[str, object]:
    """Inputs at step k: an attitude that turns about an oblique axis, on an orbit."""
    a, axis = 0.02 * k + 0.3, np.array([0.48, 0.6, 0.64])
    hat = np.cross(np.eye(3), axis)
    R = np.eye(3) + np.sin(a) * hat + (1 - np.cos(a)) * hat @ hat
    return {"R_NB": R, "omega_B": 0.2 * axis, "r_N": [6.9e6 - k, 1e5, 9e5 + 7e2 * k], "v_N": [90.0, -1e3, 7.4e3]}


def flown(block: Instance, steps: int = STEPS, begin: bool = True) -> np.ndarray:
    """The controller's outputs, (steps + 1, n); ends at a refused step."""
    rows = []
    for k in range(steps + 1):
        for name, value in inputs(k).items():
            block.set(name, value)
        if k:
            block.step((k - 1) * H, H)
        elif begin:
            block.initialize()
        rows.append(np.concatenate([np.ravel(block.get(name)) for name in OUTPUTS]))
    return np.array(rows)


def flown_on(block: Instance, first: int, end: int) -> None:
    """Steps at 200 Hz of wall time."""
    for k in range(first, end):
        block.step(k * H, H)
        time.sleep(0.005)


@pytest.fixture(scope="module")
def direct() -> np.ndarray:
    with Instance("controller") as block:
        return flown(block)


@contextmanager
def asked(address: str, transport: str = "udp", **settings: object) -> Iterator[Instance]:
    settings = {"time_out": 2.0, **settings}
    with devices.instance("controller", transport=transport, address=address, **settings) as block:
        yield block


@contextmanager
def behind(rule) -> Iterator[tuple[Proxy, object]]:
    """A device behind a UDP line with faults."""
    port = devices.free_port()
    with devices.running("controller", "udp", port) as process, datagrams(port, rule) as proxy:
        yield proxy, process


@contextmanager
def served(transport: str) -> Iterator[str]:
    """A device at a line without faults: its address."""
    if transport == "serial":
        with terminals() as (proxy, path, _), devices.running("controller", "serial", path):
            yield proxy.address
        return
    with tempfile.TemporaryDirectory() as folder:
        place = f"{folder}/line" if transport == "pipe" else devices.free_port()
        with devices.running("controller", transport, place):
            yield place if transport == "pipe" else f"127.0.0.1:{place}"


# ---------------------------------------------------------------- lock-step


@pytest.mark.parametrize("transport", ["udp", "tcp", "serial", "pipe"])
def test_lock_step_gives_the_bits_of_the_block_itself_on_every_line(transport, direct):
    with served(transport) as address, asked(address, transport) as block:
        np.testing.assert_array_equal(flown(block), direct)
        assert (block.get("link_age"), block.get("link_silent_steps"), block.get("link_damaged_frames")) == (0.0, 0, 0)
        assert 0.0 < block.get("link_round_trip") < 1.0


def test_the_other_byte_order_gives_the_same_bits_and_single_precision_its_rounding(direct):
    with served("udp") as address:
        with asked(address, byte_order="big") as block:
            np.testing.assert_array_equal(flown(block), direct)
        with asked(address, precision="single") as block:
            single = flown(block)
    assert 0.0 < np.abs(single - direct).max() < 1e-5


def test_a_parameter_that_is_tuned_in_the_run_reaches_the_device():
    def tuned(block: Instance) -> np.ndarray:
        flown(block, 3)
        block.set("kappa0", 0.2)
        block.step(3 * H, H)
        return block.get("tau_cmd_B")

    with Instance("controller") as block:
        own = tuned(block)
    with served("udp") as address, asked(address) as block:
        np.testing.assert_array_equal(tuned(block), own)


def test_a_reset_instance_and_one_after_it_begin_anew(direct):
    with served("tcp") as address:
        with asked(address, "tcp") as block:
            flown(block, 5)
            block.call("Reset")
            block.set("link_transport", "tcp")
            block.set("link_address", address)
            np.testing.assert_array_equal(flown(block), direct)
        with asked(address, "tcp") as block:
            np.testing.assert_array_equal(flown(block), direct)


# ---------------------------------------------------------------- refusals


def test_a_device_of_another_interface_is_refused_by_name():
    port = devices.free_port()
    other = "expected one built for the interface controller, found 'allocator'"
    with (
        devices.running("allocator", "udp", port),
        asked(f"127.0.0.1:{port}") as block,
        pytest.raises(Refused, match=other),
    ):
        block.initialize()


def test_what_the_block_on_the_device_refuses_stops_the_run_with_its_words():
    with served("udp") as address, asked(address) as block:
        block.set("K0", [0.3, 0.2, 0.1])
        with pytest.raises(Refused, match=r"device at udp .*, found 'K0\[2\]: expected 0 < K0\[1\] < K0\[2\]"):
            block.initialize()


def test_a_line_may_have_the_number_of_a_standard_input_that_was_closed():
    """A service without one: the first descriptor that is opened is 0."""
    port, kept = devices.free_port(), os.dup(0)
    with devices.running("controller", "udp", port):
        os.close(0)
        try:
            with asked(f"127.0.0.1:{port}") as block:
                flown(block, 2)
        finally:
            os.dup2(kept, 0)
            os.close(kept)


@pytest.mark.parametrize(("said", "found"), [("x", "x"), ("", "a refusal without a reason"), ("y" * 96, "y" * 96)])
def test_a_refusal_is_told_with_the_device_s_words_however_long_they_are(said, found):
    def refused(data: bytes, way: str) -> list[tuple[float, bytes]]:
        if way == "to" or data[3] != STEP | ANSWER:
            return [(0.0, data)]
        (answer,) = Reader(2000).feed(data)
        payload = struct.pack("<B96s", BLOCK_REFUSES, said.encode())
        return [(0.0, frame(REFUSED, answer.session, answer.sequence, payload))]

    with behind(refused) as (proxy, _), asked(proxy.address) as block:
        with pytest.raises(Refused) as told:
            flown(block, 3)
        assert f"expected that it accepts the request, found '{found}'" in str(told.value)


@pytest.mark.parametrize(
    ("transport", "address", "message"),
    [
        ("udp", "127.0.0.1:9", "udp 127.0.0.1:9: expected an answer within link_time_out (0.1 s), found 'no answer'"),
        ("tcp", "127.0.0.1:9", "expected a line that can be opened, found 'Connection refused'"),
        ("tcp", "127.0.0.1", f"{NO_PORT}'127.0.0.1'"),
        ("udp", "127.0.0.1:70000", f"{NO_PORT}'127.0.0.1:70000'"),
        ("udp", "127.0.0.1:0x10", f"{NO_PORT}'127.0.0.1:0x10'"),
        ("udp", "", f"{NO_PORT}''"),
        ("serial", "/dev/no-such-line", "expected a line that can be opened, found 'No such file or directory'"),
        ("pipe", "/tmp/no-such-line", "found 'No such file or directory'"),
    ],
)
def test_a_line_without_a_device_ends_in_time_and_is_named(transport, address, message):
    with asked(address, transport, time_out=0.1) as block:
        begin = time.monotonic()
        with pytest.raises(Refused) as refused:
            block.initialize()
    assert message in str(refused.value)
    assert time.monotonic() - begin < 1.0


def test_no_state_is_saved_and_the_description_says_so():
    assert not link.CAPABILITIES.canGetAndSetFMUstate
    assert not link.CAPABILITIES.canSerializeFMUstate
    with devices.instance("controller") as block, pytest.raises(Refused, match="memory of a device is out of reach"):
        block.call("GetFMUstate", None)


# ---------------------------------------------------------------- faults on the line


def _every(n: int, otherwise):
    """A rule that lets a fault befall each n-th part of what goes in each direction."""
    count = {"to": 0, "from": 0}

    def rule(data: bytes, way: str) -> list[tuple[float, bytes]]:
        count[way] += 1
        return otherwise(data) if count[way] % n == 0 else [(0.0, data)]

    return rule


def _damaged(data: bytes) -> list[tuple[float, bytes]]:
    random = Random(len(data))
    spoilt = bytearray(data)
    for _ in range(3):
        spoilt[random.randrange(len(spoilt))] ^= 1 << random.randrange(8)
    return [(0.0, bytes(spoilt))]


@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(_every(4, lambda data: []), id="loss"),
        pytest.param(_every(5, lambda data: [(0.03, data)]), id="delay"),
        pytest.param(_every(2, lambda data: [(0.0, data), (0.0, data), (0.004, data)]), id="duplicates and reordering"),
        pytest.param(_every(4, _damaged), id="damage"),
        pytest.param(_every(3, lambda data: [(0.0, data[: len(data) // 2])]), id="cut short"),
        pytest.param(_every(3, lambda data: [(0.0, b"\xa5\x5a\x01" + data)]), id="bytes of no frame before"),
    ],
)
def test_lock_step_keeps_every_sample_on_a_bad_line(fault, direct):
    with behind(fault) as (proxy, _), asked(proxy.address, tries=100) as block:
        np.testing.assert_array_equal(flown(block), direct)
        assert block.get("link_silent_steps") == 0
        assert max(proxy.passed.values()) > STEPS


def test_lock_step_keeps_every_sample_on_a_serial_line_that_damages_bytes(direct):
    random = Random(1)

    def rule(data: bytes, way: str) -> list[tuple[float, bytes]]:
        return _damaged(data) if random.random() < 0.1 else [(0.0, data)]

    with (
        terminals(rule) as (proxy, path, _),
        devices.running("controller", "serial", path),
        asked(proxy.address, "serial", tries=100) as block,
    ):
        np.testing.assert_array_equal(flown(block), direct)


def test_a_serial_line_that_brings_one_byte_at_a_time_costs_no_request(direct):
    """One try in two seconds: a byte that is lost alone would end the run."""

    def bytewise(data: bytes, way: str) -> list[tuple[float, bytes]]:
        return [(2e-4 * i, data[i : i + 1]) for i in range(len(data))] if way == "from" else [(0.0, data)]

    with (
        terminals(bytewise) as (proxy, path, _),
        devices.running("controller", "serial", path),
        asked(proxy.address, "serial", tries=1) as block,
    ):
        np.testing.assert_array_equal(flown(block, 6), direct[:7])


def test_what_is_of_no_frame_is_counted_once_however_long_it_is():
    def noisy(data: bytes, way: str) -> list[tuple[float, bytes]]:
        return [(0.0, b"\x00" * 7 + data)] if way == "from" else [(0.0, data)]

    with behind(noisy) as (proxy, _), asked(proxy.address) as block:
        flown(block, 5)
        assert 6 <= block.get("link_damaged_frames") <= proxy.passed["from"]


def test_a_cut_cable_stops_the_run_in_time_and_says_where():
    with behind(as_they_are) as (proxy, _), asked(proxy.address, time_out=0.2) as block:
        flown(block, 5)
        proxy.is_cut = True
        begin = time.monotonic()
        with pytest.raises(Refused, match="fmi2DoStep: device at udp .*: expected an answer within link_time_out"):
            block.step(5 * H, H)
        assert 0.15 < time.monotonic() - begin < 0.5


def test_an_unplugged_serial_line_stops_the_run_at_once():
    with (
        terminals() as (proxy, path, unplug),
        devices.running("controller", "serial", path),
        asked(proxy.address, "serial", time_out=5.0) as block,
    ):
        flown(block, 5)
        unplug()
        begin = time.monotonic()
        with pytest.raises(Refused, match="found 'the line is closed or blocked at the other end'"):
            block.step(5 * H, H)
        assert time.monotonic() - begin < 1.0


@pytest.mark.parametrize("policy", ["hold", "zero"])
def test_a_silent_device_is_held_or_zero_without_waiting_and_used_again_when_it_is_back(policy):
    settings = {"time_out": 0.1, "when_silent": policy}
    with behind(as_they_are) as (proxy, _), asked(proxy.address, **settings) as block:
        before = flown(block, 5)[-1]
        proxy.is_cut = True
        begin = time.monotonic()
        for k in range(5, 1005):
            block.step(k * H, H)
        assert time.monotonic() - begin < 0.9, "only the first of them waits"
        np.testing.assert_array_equal(block.get("tau_cmd_B"), before[:3] if policy == "hold" else np.zeros(3))
        assert (block.get("link_silent"), block.get("link_silent_steps")) == (1, 1000)
        assert block.get("link_age") == pytest.approx(100.0)
        if policy == "zero":
            return
        proxy.is_cut = False
        k, until = 1005, time.monotonic() + 5.0
        while block.get("link_silent") and time.monotonic() < until:  # it is looked for once a second
            time.sleep(0.02)
            block.step(k * H, H)
            k += 1
        assert (block.get("link_silent"), block.get("link_age"), block.get("link_restarts")) == (0, 0.0, 0)


@pytest.mark.parametrize("policy", ["stop", "hold"])
def test_a_device_that_restarts_stops_the_run_or_begins_anew_and_is_counted(policy):
    port = devices.free_port()
    with asked(f"127.0.0.1:{port}", when_silent=policy) as block:
        with devices.running("controller", "udp", port):
            flown(block, 5)
        with devices.running("controller", "udp", port):
            if policy == "stop":
                with pytest.raises(Refused, match="expected that it keeps its memory, found 'it has restarted'"):
                    block.step(5 * H, H)
                return
            block.step(5 * H, H)
            assert (block.get("link_restarts"), block.get("link_silent"), block.get("link_age")) == (1, 0, 0.0)
            block.step(6 * H, H)
            assert np.all(np.isfinite(block.get("tau_cmd_B")))


# ---------------------------------------------------------------- free running


def test_free_running_takes_the_latest_sample_and_says_how_old_it_is(direct):
    def late(data: bytes, way: str) -> list[tuple[float, bytes]]:
        return [(0.015 if way == "from" else 0.0, data)]

    with behind(late) as (proxy, _), asked(proxy.address, mode="free_running") as block:
        ages, rows = [], [flown(block, 0)[0]]
        for k in range(1, 21):
            for name, value in inputs(k).items():
                block.set(name, value)
            block.step((k - 1) * H, H)
            ages.append(block.get("link_age"))
            rows.append(np.concatenate([np.ravel(block.get(name)) for name in OUTPUTS]))
            time.sleep(0.01)
        lags = np.rint(np.array(ages) / H).astype(int)
        assert lags.max() >= 1
        assert lags[-1] < 10
        for k, lag in enumerate(lags, start=1):
            np.testing.assert_array_equal(rows[k], direct[k - lag])


def test_free_running_keeps_the_newest_of_samples_that_come_in_another_order_and_tells_silence():
    order = _every(2, lambda data: [(0.02, data)])
    with behind(order) as (proxy, _), asked(proxy.address, mode="free_running", time_out=0.4) as block:
        flown(block, 0)
        times = [0.0]
        for k in range(20):
            block.step(k * H, H)
            times.append((k + 1) * H - block.get("link_age"))
            time.sleep(0.005)
        assert np.all(np.diff(times) >= -1e-9)
        assert times[-1] > 1.0
        proxy.is_cut = True
        begin = time.monotonic()
        with pytest.raises(Refused, match="expected an answer within link_time_out"):
            flown_on(block, 20, 420)
        assert 0.3 < time.monotonic() - begin < 1.5
