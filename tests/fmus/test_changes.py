"""The FMU of faults, delays and set values, by the tables that it has to make of small sequences."""

from __future__ import annotations

from pathlib import Path

import pytest
from fmpy.validation import validate_fmu

from fmus.changes import Channel, Operation, packed

from .host import Host

RISING = [10.0, 11.0, 12.0, 13.0, 14.0, 15.0]
"""The input at t = 0, 1 ... 5 s."""


def host(tmp_path: Path, *channels: Channel) -> Host:
    path = tmp_path / "changes.fmu"
    path.write_bytes(packed(channels, "a test", 10.0, 1.0))
    assert validate_fmu(str(path)) == []
    return Host(path)


def shown(tmp_path: Path, *operations: Operation, start: float = 10.0, delayed: bool = False) -> list[float]:
    """The output at t = 0 ... 5 s of a channel whose input rises by 1 each second."""
    channel = Channel("x", "real", start, operations, True, delayed, 10.0)
    instance = host(tmp_path, channel)
    instance.fmu.setupExperiment(startTime=0.0)
    instance.fmu.enterInitializationMode()
    instance.set("x_given", RISING[0])
    seen = [instance.get("x")]
    instance.fmu.exitInitializationMode()
    for k, value in enumerate(RISING[1:]):
        instance.set("x_given", value)
        instance.step(k, 1.0)
        seen.append(instance.get("x"))
    return seen


@pytest.mark.parametrize(
    ("operations", "expected"),
    [
        ([], [10, 11, 12, 13, 14, 15]),
        ([Operation("replace", 2.0, 4.0, 7.0)], [10, 11, 7, 7, 14, 15]),
        ([Operation("add", 2.0, value=0.5)], [10, 11, 12.5, 13.5, 14.5, 15.5]),
        ([Operation("freeze", 2.0, 4.0)], [10, 11, 12, 12, 14, 15]),
        ([Operation("replace", 2.0, 4.0, 7.0, before=True)], [10, 11, 12, 7, 7, 15]),
        ([Operation("replace", 0.0, 2.0, 7.0, at_start=True)], [7, 7, 12, 13, 14, 15]),
        ([Operation("add", 1.0, value=1.0), Operation("freeze", 2.0)], [10, 12, 13, 13, 13, 13]),
        ([Operation("freeze", 2.0), Operation("add", 3.0, value=1.0)], [10, 11, 12, 13, 13, 13]),
        ([Operation("replace", 1.0, value=1.0), Operation("replace", 2.0, 4.0, 2.0)], [10, 1, 2, 2, 1, 1]),
    ],
)
def test_a_signal_is_changed_from_the_first_instant_to_before_the_last(
    operations: list[Operation], expected: list[float], tmp_path: Path
) -> None:
    assert shown(tmp_path, *operations) == expected


def test_a_delay_shows_its_start_and_then_what_came_a_step_before(tmp_path: Path) -> None:
    assert shown(tmp_path, start=-1.0, delayed=True) == [-1, 10, 11, 12, 13, 14]
    frozen = Operation("freeze", 2.0, 4.0, before=True)
    assert shown(tmp_path, frozen, start=-1.0, delayed=True) == [-1, 10, 11, 12, 12, 14]


def test_values_of_all_types_are_set_at_their_times_and_after_a_reset_again(tmp_path: Path) -> None:
    at = Operation("replace", 2.0, value=2.0, before=True)
    rows = [("c", "integer", -1.0), ("m", "enumeration", 1.0), ("b", "boolean", 0.0)]
    items = (("low", 1), ("high", 2))
    made = [Channel(n, kind, start, (at,), items=items if n == "m" else ()) for n, kind, start in rows]
    instance = host(tmp_path, *made)
    for _ in range(2):
        instance.started()
        seen = [[instance.get(name) for name, *_ in rows]]
        for k in range(4):
            instance.step(k, 1.0)
            seen.append([instance.get(name) for name, *_ in rows])
        assert seen == [[-1, 1, 0]] * 3 + [[2, 2, 1]] * 2
        instance.fmu.reset()


@pytest.mark.parametrize("adds_up", [False, True])
def test_times_that_are_added_up_are_the_same_instants(adds_up: bool, tmp_path: Path) -> None:
    """A thousand steps of 0.1 s add up to 1e-12 s beside 100 s."""
    instance = host(tmp_path, Channel("x", "real", 0.0, (Operation("replace", 100.0, value=1.0),)))
    instance.started()
    time, first = 0.0, None
    for k in range(1001):
        instance.fmu.doStep(time if adds_up else k * 0.1, 0.1)
        time += 0.1
        first = k if first is None and instance.get("x") == 1.0 else first
    assert first == 999


def test_what_is_not_finite_and_a_table_of_another_fmu_are_refused(tmp_path: Path) -> None:
    instance = host(tmp_path, Channel("x", "real", 0.0, (), True)).started()
    assert "expected a finite number" in instance.refuses(lambda: instance.set("x_given", float("nan")))
    with pytest.raises(ValueError, match="at most 512 signals"):
        packed([Channel(f"x[{i}]", "real", 0.0, ()) for i in range(513)], "", 1.0, 1.0)
