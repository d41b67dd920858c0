"""The timeline: values at given times, phases, and what is expected during a phase."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestration import InputError, load, run
from orchestration.cli.summary import summary
from orchestration.quantities import SECOND, Quantity
from orchestration.results.figures import draw
from orchestration.results.phases import bands
from orchestration.scenario.source import StartName
from orchestration.session.flight import fly
from orchestration.session.open import open_scenario
from orchestration.session.session import Session

BASE: dict[str, Any] = {
    "name": "timeline",
    "step": 0.5,
    "duration": 10.0,
    "blocks": {
        "supervisor": {
            "fmu": "supervisor",
            "start": {
                "R_NB": {"axis": [0, 0, 1], "angle": 0},
                "omega_B": [0, 0, 0],
                "attitude_valid": True,
                "r_N": [6971e3, 0, 0],
                "v_N": [0, -1052.3891, 7488.1109],
                "rate_time": "2 s",
                "target_latitude": "10 deg",
                "target_longitude": "20 deg",
                "target_height": 0,
            },
        },
    },
    "record": {"signals": ["supervisor.mode", "supervisor.target_elevation"]},
}


TIMELINE: list[dict[str, Any]] = [
    {"at": 0.0, "phase": "waiting"},
    {"at": "5 s", "set": {"supervisor.target_height": "1 km", "supervisor.command": 1}, "phase": "commanded"},
    {"at": 8.0, "set": {"supervisor.command": 0}, "phase": "waiting"},
]


def flown(compiled: bool = True, **changes: Any) -> Any:
    return run({**BASE, **changes}, compiled=compiled)


def refused(**changes: Any) -> str:
    with pytest.raises(InputError) as error:
        flown(**changes)
    return str(error.value)


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
@pytest.mark.parametrize("every", [1, 2])
def test_a_value_is_given_from_its_time_on_and_both_loops_give_the_same_bits(exchange: str, every: int) -> None:
    blocks = {"supervisor": {**BASE["blocks"]["supervisor"], "every": every}}
    in_c, in_python = (flown(c, timeline=TIMELINE, exchange=exchange, blocks=blocks) for c in (True, False))
    for name in in_c:
        np.testing.assert_array_equal(in_c[name], in_python[name])
    without = flown(exchange=exchange, blocks=blocks)
    changed = in_c["supervisor.target_elevation"] != without["supervisor.target_elevation"]
    seen = 5.0 + 0.5 * every  # the end of the first step that begins with it
    assert changed[in_c.time >= seen].all()
    assert not changed[in_c.time < seen].any()
    mode = in_c["supervisor.mode"]
    assert mode[in_c.time == 5.0] == 2  # acquisition since 2 s
    assert (mode[(in_c.time >= seen) & (in_c.time <= 8.0)] == 1).all()
    assert mode[-1] == 2


def test_a_scenario_flown_again_and_again_begins_its_timeline_anew() -> None:
    """As a campaign flies it: the FMU is reset from run to run, and the values of its timeline with it."""
    expect = [{"name": "safe", "signal": "supervisor.mode", "during": "commanded", "ever": {"equals": 2}}]
    with Session(open_scenario(load({**BASE, "timeline": TIMELINE, "expect": expect})), resets=True) as session:
        name = StartName("supervisor", "rate_time")
        seen = [fly(session, {name: value}).outcomes[0].passed for value in (2.0, Quantity(6.0, SECOND), 2.0)]
    assert seen == [True, False, True]


def test_an_expectation_of_a_phase_looks_at_its_samples_alone() -> None:
    """Of the phase 'commanded' from 5 s on and before 8 s; of a signal while it has the phase's value."""
    expect = [
        {"name": "safe", "signal": "supervisor.mode", "during": "commanded", "after": "5.1 s", "always": {"equals": 1}},
        {"name": "waits", "signal": "supervisor.mode", "during": "waiting", "always": {"within": [1, 2]}},
        {"name": "either", "signal": "supervisor.mode", "during": ["safe", "acquiring"], "always": {"below": 3}},
        {"name": "off", "signal": "supervisor.mode", "during": "acquiring", "ever": {"equals": 1}},
        {"name": "never", "signal": "supervisor.mode", "during": "sun", "always": {"equals": 7}},
    ]
    phases = {"signal": "supervisor.mode", "names": {"safe": 1, "acquiring": 2, "sun": 7}}
    result = flown(timeline=TIMELINE, phases=phases, expect=expect)
    by_name = {outcome.name: outcome for outcome in result.outcomes}
    assert [by_name[name].status for name in ("safe", "waits", "either")] == ["met", "met", "met"]
    assert by_name["safe"].samples == 5
    assert by_name["waits"].samples == 10 + 5
    assert by_name["either"].samples == 21
    assert by_name["off"].status == "failed"
    assert by_name["never"].status == "not reached"
    assert by_name["never"].note == "there is no sample in the phase sun"


def test_each_wrong_phase_of_a_signal_is_told_and_a_signal_of_real_numbers_has_none() -> None:
    told = refused(timeline=TIMELINE, phases={"signal": "supervisor.mode", "names": {"waiting": 1, "odd": "two"}})
    assert "is a phase of the timeline, too" in told
    assert "phases.names.odd" in told
    told = refused(phases={"signal": "supervisor.target_elevation", "names": {"low": 0}})
    assert "expected one boolean, whole number or enumeration" in told


def test_a_pattern_records_the_outputs_that_match_it_alone() -> None:
    assert list(flown(record={"signals": ["supervisor.mo*e"]})) == ["supervisor.mode"]


def test_values_of_the_signal_of_phases_are_told_by_their_names() -> None:
    phases = {"signal": "supervisor.mode", "names": {"safe": 1, "acquiring": 2}}
    expect = [
        {"name": "safe first", "signal": "supervisor.mode", "before": "1 s", "always": {"equals": 1}},
        {"name": "always safe", "signal": "supervisor.mode", "always": {"equals": 1}},
        {"name": "no other mode", "signal": "supervisor.mode", "always": {"below": 3}},
        {"name": "not named", "signal": "supervisor.mode", "ever": {"equals": 7}},
    ]
    result = flown(timeline=TIMELINE, phases=phases, expect=expect)
    assert [(o.text.partition(" at")[0], o.expected) for o in result.outcomes] == [
        ("safe", "always safe"),
        ("acquiring", "always safe"),
        ("2", "always < 3"),
        ("acquiring", "ever = 7"),
    ]


def test_phases_are_drawn_from_the_signal_or_else_from_the_timeline() -> None:
    found = bands(flown(timeline=TIMELINE))
    assert [(b.name, b.begin, b.end, b.colour) for b in found] == [
        ("waiting", 0.0, 5.0, 0),
        ("commanded", 5.0, 8.0, 1),
        ("waiting", 8.0, 10.0, 0),
    ]
    phases = {"signal": "supervisor.mode", "names": {"safe": 1, "acquiring": 2}}
    record = {"signals": ["supervisor.target_elevation"]}
    found = bands(flown(timeline=TIMELINE, phases=phases, record=record))
    assert [(b.name, b.begin, b.end) for b in found] == [
        ("safe", 0.0, 2.0),
        ("acquiring", 2.0, 5.5),
        ("safe", 5.5, 8.5),
        ("acquiring", 8.5, 10.0),
    ]


def test_the_manifest_the_figures_and_the_report_tell_of_it(tmp_path: Path) -> None:
    figures = [{"name": "modes", "panels": [{"signals": ["supervisor.mode"]}]}]
    result = run({**BASE, "timeline": TIMELINE, "figures": figures}, out=tmp_path / "out")
    assert result.manifest["timeline"][1] == (
        "at 5 s: phase 'commanded', supervisor.target_height = 1 km, supervisor.command = 1"
    )
    assert result.manifest["scenario"]["timeline"][2]["at"] == 8.0
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "<h2>Timeline</h2>" in page
    assert "phase &#39;commanded&#39;" in page
    assert '"phases":[["waiting",0.0,5.0,0],["commanded",5.0,8.0,1]' in page
    assert (tmp_path / "out" / "manifest.json").exists()
    draw(result, tmp_path / "figures")
    assert (tmp_path / "figures" / "modes.png").stat().st_size > 1000


def test_a_start_value_of_an_option_holds_until_the_timeline_sets_another() -> None:
    result = run({**BASE, "timeline": TIMELINE}, {"supervisor.command": 1})
    mode = result["supervisor.mode"]
    assert (mode[result.time <= 8.0] == 1).all()
    assert mode[-1] == 2


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"timeline": [{"at": 1, "set": {"supervisor.comand": 3}}]},
            "timeline[1].set.supervisor.comand: supervisor has no input or output or parameter 'comand'; did "
            "you mean 'command'?",
        ),
        (
            {"timeline": [{"at": 1, "set": {"super.command": 3}}]},
            "timeline[1].set.super.command: there is no block 'super'; did you mean 'supervisor'?",
        ),
        ({"timeline": [{"at": 1, "set": {"supervisor.target_height": "3 kg"}}]}, "the unit 'kg' does not fit"),
        ({"timeline": [{"at": 1, "set": {"supervisor.first_mode": "sun"}}]}, "supervisor.first_mode is fixed"),
        ({"timeline": [{"at": 1, "set": {"supervisor.mode": 3}}]}, "supervisor.mode is an output"),
        (
            {"timeline": [{"at": 11, "phase": "late"}]},
            "timeline[1].at: 11 s lies at or after the end of the run, 10 s; no step sees it",
        ),
        (
            {"timeline": [{"at": 10, "phase": "late"}]},
            "timeline[1].at: 10 s lies at or after the end of the run, 10 s; no step sees it",
        ),
        (
            {"timeline": [{"at": 5, "phase": "b"}, {"at": 3, "phase": "a"}]},
            "timeline[2].at: 3 s lies before the entry above, 5 s; expected entries in the order of time",
        ),
        (
            {"timeline": [{"at": 5, "phase": "b"}, {"at": 5, "phase": "a"}]},
            "timeline[2].phase: 'a' begins at the same time as 'b', 5 s; expected one phase at a time",
        ),
        (
            {"timeline": [{"at": 5, "set": {"supervisor.command": 1}}, {"at": 5, "set": {"supervisor.command": 3}}]},
            "timeline[2].set.supervisor.command: is set at 5 s by timeline[1].set.supervisor.command, too; "
            "expected one value at a time",
        ),
        (
            {
                "timeline": [
                    {"at": 5, "set": {"supervisor.R_goal": {"diagonal": [1, 1, 1]}, "supervisor.R_goal[1,2]": 0.1}}
                ]
            },
            "timeline[1].set.supervisor.R_goal[1,2]: is set at 5 s by timeline[1].set.supervisor.R_goal, too",
        ),
        (
            {"timeline": [{"at": 5, "phase": "a/b"}]},
            "timeline[1].phase: expected a name of letters, digits and _ . -, and spaces within, found 'a/b'",
        ),
        (
            {"phases": {"signal": "supervisor.mode", "names": {"a": 1, "b": 1}}},
            "phases.names.b: has the value of 'a', 1; expected one name for a value",
        ),
        ({"timeline": [{"at": -1, "phase": "early"}]}, "at: expected zero or more, found -1 s"),
        ({"timeline": [{"at": 1}]}, "expected set, phase or both, found neither"),
        (
            {"expect": [{"name": "a", "signal": "supervisor.mode", "during": "slew", "always": {"below": 9}}]},
            "expect[1].during: there is no phase 'slew'; remedy: a 'phase' in the timeline, or 'phases'",
        ),
        (
            {
                "timeline": TIMELINE,
                "expect": [{"name": "a", "signal": "supervisor.mode", "during": "comanded", "always": {"below": 9}}],
            },
            "expect[1].during: there is no phase 'comanded'; did you mean 'commanded'?",
        ),
        (
            {"phases": {"signal": "supervisor.R_ref", "names": {"a": 1}}},
            "phases.signal: expected one boolean, whole number or enumeration, but supervisor.R_ref is",
        ),
        ({"phases": {"signal": "supervisor.mode", "names": {"a": "one"}}}, "phases.names.a: "),
        (
            {"timeline": TIMELINE, "phases": {"signal": "supervisor.mode", "names": {"waiting": 1}}},
            "phases.names.waiting: is a phase of the timeline, too; expected another name",
        ),
    ],
)
def test_what_does_not_fit_is_refused_with_its_place(changes: dict[str, Any], message: str) -> None:
    assert message in refused(**changes)


def test_an_entry_beyond_an_end_that_an_option_brings_forward_is_noted(capsys: pytest.CaptureFixture[str]) -> None:
    loaded = load({**BASE, "timeline": TIMELINE})
    result = run(loaded, duration=5.0)
    late = "does not happen, since the run ends before: at 5 s: phase 'commanded', supervisor.target_height = 1 km"
    assert any(late in note for note in result.manifest["notes"])
    summary(result)
    assert [line for line in capsys.readouterr().out.splitlines() if line.startswith("timeline: at")] == [
        "timeline: at 0 s: phase 'waiting'"
    ]


def test_a_timeline_whose_phases_are_not_drawn_is_noted() -> None:
    result = flown(timeline=TIMELINE, phases={"signal": "supervisor.mode", "names": {"safe": 1}})
    text = "timeline: its phases are not drawn, since 'phases' is given"
    assert any(text in n for n in result.manifest["notes"])
    without = [{key: value for key, value in entry.items() if key != "phase"} for entry in TIMELINE[1:]]
    for other in (
        {"timeline": TIMELINE},
        {"timeline": without, "phases": {"signal": "supervisor.mode", "names": {"safe": 1}}},
    ):
        assert not any(text in note for note in flown(**other).manifest["notes"])


@pytest.mark.parametrize("compiled", [True, False])
def test_a_fault_stands_over_the_timeline_while_it_acts_and_leaves_the_last_value_behind(compiled: bool) -> None:
    """Heights of 1, 2 and 3 km by the timeline at 1, 4 and 9 s; 50 km by a fault from 3 to 6 s, 60 km by another from
    5 to 7 s."""
    height = "supervisor.target_height"
    timeline = [{"at": at, "set": {height: f"{km} km"}} for at, km in ((1.0, 1), (4.0, 2), (9.0, 3))]
    faults = [
        {"at": 3.0, "until": 6.0, "set": f"{height} = 50 km"},
        {"at": 5.0, "until": 7.0, "set": f"{height} = 60 km"},
    ]
    seen = flown(compiled, timeline=timeline, faults=faults)
    levels = {
        km: flown(
            blocks={
                "supervisor": {
                    **BASE["blocks"]["supervisor"],
                    "start": {**BASE["blocks"]["supervisor"]["start"], "target_height": f"{km} km"},
                }
            }
        )["supervisor.target_elevation"]
        for km in (0, 1, 2, 3, 50, 60)
    }
    spans = [(0.0, 0), (1.0, 1), (3.0, 50), (5.0, 60), (7.0, 2), (9.0, 3)]
    for i, time in enumerate(seen.time[1:], 1):
        km = next(km for begin, km in reversed(spans) if begin < time)
        assert seen["supervisor.target_elevation"][i] == levels[km][i], time


def test_an_input_that_is_connected_is_refused_with_the_remedy(tmp_path: Path) -> None:
    chain = Path(__file__).parents[2] / "scenarios" / "paper_no_singularity.yaml"
    loaded = load(chain)
    timeline = [{"at": 1.0, "set": {"controller.omega_B": [0, 0, 0]}}]
    with pytest.raises(
        InputError, match="controller.omega_B is connected; remedy: 'cut: controller.omega_B' with 'to'"
    ):
        run(load(loaded.source.with_entry(("timeline",), timeline)), duration=2.0)
