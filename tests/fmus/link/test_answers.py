"""An answer is taken only if it is of the instant that was asked for and finite; a slow device is used again after a
fault."""

from __future__ import annotations

import struct
import sys
import time
from math import inf, nan

import numpy as np
import pytest

from fmus.interface import load
from fmus.link.device import ANSWER, START, STEP, Layout, Reader, frame
from fmus.link.device import Field as Port
from tests.native.driver import Refused

from .proxy import Rule, as_they_are
from .test_link import H, asked, behind, flown, flown_on

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the devices of these tests use POSIX")
OUTPUTS = Layout(tuple(Port(v.name, v.type, v.shape) for v in load("controller").of("output")), 0)


def changed(n: int, change, kind: int = STEP) -> Rule:
    """A rule under which the n-th answer of this kind, and those after it, are changed."""
    count = 0

    def rule(data: bytes, way: str) -> list[tuple[float, bytes]]:
        nonlocal count
        if way == "to" or data[3] != kind | ANSWER:
            return [(0.0, data)]
        count += 1
        return [(0.0, change(data) if count >= n else data)]

    return rule


def at_another_time(by: float):
    """An answer whose time is another one, with a right check."""

    def change(data: bytes) -> bytes:
        (answer,) = Reader(2000).feed(data)
        (stamp,) = struct.unpack_from("<d", answer.payload)
        payload = struct.pack("<d", stamp + by) + answer.payload[8:]
        return frame(answer.type, answer.session, answer.sequence, payload)

    return change


def with_output(name: str, place: int, value: float):
    """An answer with another value of an output, with a right check."""

    def change(data: bytes) -> bytes:
        (answer,) = Reader(2000).feed(data)
        outputs = vars(OUTPUTS.unpack(answer.payload[8:]))
        outputs[name][place] = value
        return frame(answer.type, answer.session, answer.sequence, answer.payload[:8] + OUTPUTS.pack(outputs))

    return change


@pytest.mark.parametrize("by", [-5.0, -0.051, 0.051, 5.0, nan])
def test_an_answer_of_another_instant_stops_the_run_and_both_times_are_named(by):
    with behind(changed(6, at_another_time(by))) as (proxy, _), asked(proxy.address) as block:
        flown(block, 5)
        found = "NaN" if by != by else f"{0.6 + by:.9g}"
        with pytest.raises(Refused) as refused:
            block.step(5 * H, H)
        assert f"device at udp {proxy.address}: expected outputs for 0.6 s, found 'those for {found} s'" in str(
            refused.value
        )


def test_an_answer_within_half_a_step_is_of_its_instant(direct_rows):
    with behind(changed(1, at_another_time(0.049))) as (proxy, _), asked(proxy.address) as block:
        np.testing.assert_array_equal(flown(block, 5), direct_rows)
        assert block.get("link_age") == 0.0


@pytest.fixture(scope="module")
def direct_rows() -> np.ndarray:
    from tests.native.driver import Instance

    with Instance("controller") as block:
        return flown(block, 5)


def test_a_start_of_another_instant_is_refused():
    with (
        behind(changed(1, at_another_time(-5.0), START)) as (proxy, _),
        asked(proxy.address) as block,
        pytest.raises(Refused, match="expected outputs for 0 s, found 'those for -5 s'"),
    ):
        block.initialize()


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_a_value_that_is_not_finite_is_refused_with_its_port(value):
    rule = changed(6, with_output("tau_cmd_B", 1, value))
    with behind(rule) as (proxy, _), asked(proxy.address) as block:
        flown(block, 5)
        with pytest.raises(Refused, match=r"device at udp .* expected a finite number for tau_cmd_B\[2\], found 'NaN"):
            block.step(5 * H, H)


@pytest.mark.parametrize("policy", ["hold", "zero"])
@pytest.mark.parametrize(
    "change", [at_another_time(-5.0), with_output("tau_cmd_B", 1, nan)], ids=["another instant", "not finite"]
)
def test_an_answer_of_no_use_is_a_silent_step_for_hold_and_zero(policy, change):
    with behind(changed(6, change)) as (proxy, _), asked(proxy.address, when_silent=policy) as block:
        before = flown(block, 5)[-1]
        block.step(5 * H, H)
        np.testing.assert_array_equal(block.get("tau_cmd_B"), before[:3] if policy == "hold" else np.zeros(3))
        assert (block.get("link_silent"), block.get("link_silent_steps")) == (1, 1)
        assert block.get("link_age") == pytest.approx(0.1)


@pytest.mark.parametrize(("by", "words"), [(-5.0, "those for -"), (5.0, "those for "), (nan, "those for NaN s")])
def test_free_running_takes_no_sample_that_is_too_old_or_of_the_future(by, words):
    rule = changed(6, at_another_time(by))
    with behind(rule) as (proxy, _), asked(proxy.address, mode="free_running", time_out=0.15) as block:
        flown(block, 0)
        with pytest.raises(Refused, match=f"expected an answer within link_time_out .0.15 s., found '{words}"):
            flown_on(block, 0, 200)


def test_the_age_up_to_which_a_sample_is_taken_is_a_parameter():
    settings = {"mode": "free_running", "time_out": 0.4}
    for age_max, is_taken in ((60.0, True), (1.0, False)):
        rule = changed(1, at_another_time(-1.5))
        with behind(rule) as (proxy, _), asked(proxy.address, **settings, age_max=age_max) as block:
            flown(block, 0)
            taken = True
            try:
                for k in range(60):
                    block.step(k * H, H)
                    time.sleep(0.01)
            except Refused:
                taken = False
            assert taken == is_taken


def test_the_round_trip_is_measured_in_free_running_too():
    delay = 0.0

    def rule(data: bytes, way: str) -> list[tuple[float, bytes]]:
        return [(delay if way == "from" else 0.0, data)]

    with behind(rule) as (proxy, _), asked(proxy.address, mode="free_running") as block:
        flown(block, 0)
        for delay in (0.03, 0.06):
            for k in range(15):
                block.step((k + 15 * (delay > 0.05)) * H, H)
                time.sleep(0.01)
            assert delay <= block.get("link_round_trip") < delay + 0.025


@pytest.mark.parametrize("mode", ["lock_step", "free_running"])
@pytest.mark.parametrize("policy", ["hold", "zero"])
def test_a_device_whose_answers_take_35_ms_is_used_again_after_a_fault_of_the_line(policy, mode):
    """As at 115200 baud. Each frame takes its time, those of the calls for a silent device too."""

    def slow(data: bytes, way: str) -> list[tuple[float, bytes]]:
        return [(0.0175, data)]

    settings = {"time_out": 0.3, "when_silent": policy, "mode": mode, "age_max": 100.0, "tries": 1}
    with behind(slow) as (proxy, _), asked(proxy.address, **settings) as block:
        flown(block, 3)
        k = 3
        for _ in range(2):  # not the first time only
            proxy.is_cut = True
            while not block.get("link_silent"):
                block.step(k * H, H)
                k += 1
                time.sleep(0.01)
            silent = block.get("link_silent_steps")
            proxy.is_cut = False
            until = time.monotonic() + 5.0
            while block.get("link_silent") and time.monotonic() < until:
                time.sleep(0.01)
                block.step(k * H, H)
                k += 1
            assert (block.get("link_silent"), block.get("link_restarts")) == (0, 0)
            assert block.get("link_silent_steps") > silent
            for _ in range(10):
                time.sleep(0.01)
                block.step(k * H, H)
                k += 1
            assert (block.get("link_silent"), block.get("link_age") < (0.05 if mode == "lock_step" else 1.0)) == (
                0,
                True,
            )


def test_an_answer_that_came_too_late_is_not_taken_for_a_later_request():
    def rule(data: bytes, way: str) -> list[tuple[float, bytes]]:
        return [(0.15 if way == "from" and proxy.passed["from"] == 9 else 0.0, data)]

    settings = {"time_out": 0.1, "when_silent": "hold", "tries": 1}
    with behind(as_they_are) as (proxy, _), asked(proxy.address, **settings) as block:
        proxy.rule = rule
        flown(block, 10)
        assert block.get("link_silent_steps") >= 1
        until, k = time.monotonic() + 5.0, 10
        while block.get("link_silent") and time.monotonic() < until:
            time.sleep(0.02)
            block.step(k * H, H)
            k += 1
        block.step(k * H, H)
        assert (block.get("link_silent"), block.get("link_age"), block.get("link_restarts")) == (0, 0.0, 0)
