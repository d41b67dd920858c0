"""A device in a run of a scenario: its bits in the results, a late answer named at its time, and every sample kept when
it goes."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import orchestration
from orchestration import Result, load
from orchestration.errors import BlockError

from . import devices
from .proxy import Rule, as_they_are, datagrams

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the devices of these tests use POSIX")
SCENARIO = Path(__file__).parents[3] / "scenarios" / "paper_no_singularity.yaml"
SIGNALS = ["controller.tau_cmd_B", "plant.omega_B", "allocator.dipole_cmd"]
STEP_ANSWER = 0x84
"""Type of the frame that answers a step."""


def scenario(duration: float, realtime: dict | None = None, **settings: object):
    """The loop of V.B, with a device where settings of the link are given."""
    source = load(SCENARIO).source.without([(key,) for key in ("expect", "figures", "holds")])
    source = source.with_value("duration", duration, "").with_entry(("record",), {"signals": SIGNALS})
    if realtime is not None:
        source = source.with_entry(("realtime",), realtime)
    if settings:
        own = source.data["blocks"]["controller"]
        start = {**own["start"], **{f"link_{name}": value for name, value in settings.items()}}
        entry = {**own, "fmu": str(devices.fmu("controller")), "interface": "controller", "start": start}
        source = source.with_entry(("blocks", "controller"), entry)
    return load(source)


def at_step(n: int, fault: Rule) -> Rule:
    """A rule under which a fault befalls the answer to the n-th step."""
    count = 0

    def rule(data: bytes, way: str) -> list[tuple[float, bytes]]:
        nonlocal count
        count += way == "from" and data[3] == STEP_ANSWER
        return fault(data, way) if way == "from" and data[3] == STEP_ANSWER and count == n else as_they_are(data, way)

    return rule


def test_the_loop_with_a_device_has_the_bits_of_the_loop_without():
    own = orchestration.run(scenario(10.0))
    port = devices.free_port()
    with devices.running("controller", "udp", port):
        other = orchestration.run(scenario(10.0, address=f"127.0.0.1:{port}"))
    for signal in SIGNALS:
        np.testing.assert_array_equal(other[signal], own[signal])


def test_an_answer_that_comes_late_is_an_overrun_of_50_ms_at_its_time_and_names_the_device():
    port = devices.free_port()
    late = at_step(5, lambda data, way: [(0.15, data)])
    with devices.running("controller", "udp", port), datagrams(port, late) as proxy:
        result = orchestration.run(scenario(0.8, {"factor": 1}, address=proxy.address, tries=1))
    named = next(entry for entry in result.pace.listed if entry.time == 0.5)
    assert (named.block, named.overrun) == ("controller", True)
    assert named.lateness > 0.045
    assert named.block_took > 0.145
    assert "late at 0.5 s: overrun of" in named.text


def test_a_device_that_goes_silent_ends_the_run_there_and_every_sample_before_is_kept(tmp_path):
    own = orchestration.run(scenario(5.0))
    port = devices.free_port()

    def dead(data: bytes, way: str) -> list[tuple[float, bytes]]:
        proxy.is_cut = True
        return []

    with (
        devices.running("controller", "udp", port),
        datagrams(port, at_step(30, dead)) as proxy,
        pytest.raises(BlockError, match="within link_time_out") as ended,
    ):
        orchestration.run(scenario(5.0, address=proxy.address, time_out=0.2))
    result: Result = ended.value.result
    assert len(result.time) == 30, "the start, and 29 steps"
    for signal in SIGNALS:
        np.testing.assert_array_equal(result[signal], own[signal][:30])
