"""Saved states of a container: a flight that goes on from one has the bits of a flight that never stopped."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import fmpy
import pytest
from fmpy.fmi1 import FMICallException

import orchestration
from orchestration import Scenario, load

from .host import Host

ROOT = Path(__file__).parents[3]
STEP, HALF = 0.1, 10


def fly(host: Host, first: int, last: int) -> list[list[float]]:
    """All outputs after each step."""
    seen = []
    for k in range(first, last):
        host.fmu.doStep(k * STEP, STEP)
        seen.append(host.seen())
    return seen


def paper(exchange: str) -> Scenario:
    """The paper's V.B: plant, controller, allocator and judge."""
    source = load(ROOT / "scenarios" / "paper_no_singularity.yaml").source
    left = source.without([(key,) for key in ("expect", "figures", "consistency", "record", "live")])
    return load(left.with_value("duration", 2 * HALF * STEP, "").with_value("exchange", exchange, ""))


@pytest.fixture(scope="module", params=["sequential", "parallel"])
def container(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return orchestration.export_loop(paper(request.param), tmp_path_factory.mktemp("states") / "loop.fmu")


@pytest.fixture
def host(container: Path) -> Iterator[Host]:
    made = Host(container)
    made.begin()
    yield made
    made.end()


def test_a_flight_that_goes_back_to_a_state_has_the_same_bits(host: Host) -> None:
    before = fly(host, 0, HALF)
    assert before[0] != before[-1]
    state = host.fmu.getFMUstate()
    straight = fly(host, HALF, 2 * HALF)
    for _ in range(2):
        host.fmu.setFMUstate(state)
        assert host.seen() == before[-1]
        assert fly(host, HALF, 2 * HALF) == straight
    host.fmu.freeFMUstate(state)
    assert host.said == []


@pytest.mark.parametrize("begun", [False, True])
def test_the_bytes_of_a_state_begin_in_another_instance_where_they_were_written(
    host: Host, container: Path, begun: bool
) -> None:
    fly(host, 0, HALF)
    state = host.fmu.getFMUstate()
    written = host.fmu.serializeFMUstate(state)
    host.fmu.freeFMUstate(state)
    straight = fly(host, HALF, 2 * HALF)
    other = Host(container, "two")
    if begun:
        other.begin(start=50.0)
        other.fmu.doStep(50.0, STEP)
    read = other.fmu.deSerializeFMUstate(written)
    other.fmu.setFMUstate(read)
    assert fly(other, HALF, 2 * HALF) == straight
    assert other.fmu.serializeFMUstate(read) == written
    other.fmu.freeFMUstate(read)
    assert other.said == []
    other.end()


def test_bytes_that_are_not_those_of_a_state_are_refused_and_leave_the_flight_as_it_was(host: Host) -> None:
    now = fly(host, 0, HALF)[-1]
    state = host.fmu.getFMUstate()
    written = host.fmu.serializeFMUstate(state)
    mode = 8 + 40 + 3 * 8  # behind the mark, the GUID, a count and two times
    for wrong in (b"", written[:20], written[:-1], written[: len(written) // 2], b"\xff" * len(written)):
        with pytest.raises(FMICallException):
            host.fmu.deSerializeFMUstate(wrong)
    with pytest.raises(FMICallException):
        host.fmu.deSerializeFMUstate(written[:mode] + b"\xff" + written[mode + 1 :])
    refused = "fmi2DeSerializeFMUstate: expected the bytes that fmi2SerializeFMUstate of this FMU wrote"
    assert host.said.count(refused) >= 4
    assert host.seen() == now
    host.fmu.freeFMUstate(state)


def test_it_declares_that_it_can(container: Path) -> None:
    says = fmpy.read_model_description(str(container)).coSimulation
    assert (says.canGetAndSetFMUstate, says.canSerializeFMUstate) == (True, True)
