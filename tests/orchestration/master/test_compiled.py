"""The step loop in C against the readable one in Python: the same bits, the same errors, at the same place."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestration import BlockError, load, run
from orchestration.master import compiled

from .. import fmus, mocks

SCENARIOS = Path(__file__).parents[3] / "scenarios"


@pytest.fixture(autouse=True)
def _the_loop_in_c_can_be_had():
    assert compiled._library() is not None, "loop.c cannot be compiled here, so nothing would be compared"


@pytest.fixture
def ran_in_c(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Counts the runs of the loop in C."""
    runs: list[int] = []
    original = compiled.CompiledLoop.__init__

    def counted(self: Any, *arguments: Any) -> None:
        runs.append(1)
        original(self, *arguments)

    monkeypatch.setattr(compiled.CompiledLoop, "__init__", counted)
    return runs


def both(scenario: Any, ran: list[int], **options: Any):
    in_c = run(scenario, **options)
    assert ran == [1]
    in_python = run(scenario, **options, compiled=False)
    assert ran == [1]
    return in_c, in_python


def changed(name: str, **changes: Any) -> dict[str, Any]:
    """A scenario of the project without its expectations, with other top-level entries."""
    data = {**load(SCENARIOS / f"{name}.yaml").source.data, "duration": 20, "expect": [], "figures": [], **changes}
    return data


FAULTS = [
    {"at": 2, "until": 5, "cut": "allocator.dipole_cmd"},
    {"at": 4, "until": 9, "cut": "plant.b_B[2]", "to": "10 uT"},
    {"at": 3, "bias": "plant.omega_B", "by": ["0.1 deg/s", 0, 0]},
    {"at": 6, "until": 8, "freeze": "controller.R_NB"},
    {"at": 7, "freeze": "allocator.wheel_torque_cmd"},
    {"at": 7.5, "until": 8, "bias": "plant.wheel_torque_cmd", "by": "1 mN.m"},
]
RATES = {"judge": 1, "plant": 1, "controller": 2, "allocator": 5}


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"exchange": "parallel"},
        {"record": {"interval": 0.5}},
        {"delays": ["allocator.tau_cmd_B"]},
        {"faults": FAULTS},
        {"faults": FAULTS, "exchange": "parallel"},
        {"faults": FAULTS, "delays": ["allocator.tau_cmd_B"]},
        {"flavour": "python", "duration": 3},
    ],
    ids=[
        "sequential",
        "parallel",
        "recorded-now-and-then",
        "delayed",
        "faults",
        "faults-parallel",
        "faults-delayed",
        "python-fmus",
    ],
)
def test_both_loops_give_the_same_bits(changes, ran_in_c):
    a, b = both(changed("paper_singularity", **changes), ran_in_c)
    assert a.samples.tobytes() == b.samples.tobytes()
    assert a.time.tobytes() == b.time.tobytes()
    assert a["allocator.holding"].any(), "booleans are exchanged, too"


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
def test_blocks_at_their_own_rates_give_the_same_bits(exchange, ran_in_c):
    data = changed("paper_no_singularity", exchange=exchange)
    data["blocks"] = {name: {**entry, "every": RATES[name]} for name, entry in data["blocks"].items()}
    a, b = both(data, ran_in_c)
    assert a.samples.tobytes() == b.samples.tobytes()
    assert len(np.unique(a["allocator.dipole_cmd"][:, 0])) == 41, "the allocator acts at every fifth step only"


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
def test_a_slow_block_recorded_between_its_steps_shows_its_last_step(loop, exchange, ran_in_c):
    """It is stepped after 2, 4, 6 ... base steps and recorded after 3, 6, 9 ..., and nothing but the record asks for
    `steps`."""
    text = loop.read_text().replace("fmu: motor.fmu", "fmu: motor.fmu\n    every: 2")
    text = text.replace("record: {interval: 0.1 s}", "record: {interval: 0.3 s, signals: [motor.steps, motor.speed]}")
    loop.write_text(text + f"exchange: {exchange}\n")
    a, b = both(loop, ran_in_c)
    assert a["motor.steps"].tolist() == [*(3 * sample // 2 for sample in range(7)), 10], (
        "the end, 2 s, is recorded besides"
    )
    assert a.samples.tobytes() == b.samples.tobytes()


def test_a_conversion_of_units_gives_the_same_bits(loop, ran_in_c):
    xml = fmus.description("regulator").replace('<Real unit="V"', '<Real unit="mV"')
    fmus.write(loop.parent / "regulator.fmu", xml, fmus.library())
    a, b = both(loop, ran_in_c)
    assert a.samples.tobytes() == b.samples.tobytes()
    assert np.ptp(a["motor.speed"]) == pytest.approx(2.0 * (1.0 - 0.9999**20), rel=1e-9), "mV drive the motor"


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
@pytest.mark.parametrize("fault", [1, 2, 3, 4, 6])
def test_both_loops_fail_alike(loop, fault, exchange, ran_in_c):
    loop.write_text(loop.read_text() + f"exchange: {exchange}\n")
    faults = {"motor.fault": fault, "motor.fault_time": 1}
    told = []
    for in_c in (True, False):
        if fault == 6:  # a warning ends nothing
            told.append(run(loop, faults, compiled=in_c).samples.tobytes())
            continue
        with pytest.raises(BlockError) as info:
            run(loop, faults, compiled=in_c)
        told.append((str(info.value), info.value.time, info.value.result.samples.tobytes()))
        assert (fault == 2) == ("is nan, expected a finite number" in told[-1][0])
    assert told[0] == told[1]
    assert ran_in_c == [1]


def test_progress_is_reported_and_interrupts_are_seen(ran_in_c):
    seen: list[float] = []

    def progress(time: float) -> None:
        seen.append(time)
        raise KeyboardInterrupt

    data = changed("minimal", step=0.001, duration=600, record={"interval": 1})
    with pytest.raises(KeyboardInterrupt):
        run(data, progress=progress)
    assert len(seen) == 1
    assert 0.0 < seen[0] < 600.0


def test_blocks_that_are_no_fmus_in_this_process_take_the_loop_in_python(ran_in_c):
    result = mocks.run([mocks.ramp("a")], {"step": 0.1, "duration": 1}, start={"a": {"u": 0}}, compiled=True)
    assert result.steps == 10
    assert ran_in_c == []
