"""Campaign files, right and wrong, held against their scenario."""

from __future__ import annotations

import pytest

from orchestration.campaign.case import read_campaign
from orchestration.errors import InputError
from orchestration.session.read import read

from .. import vendor
from .toy import changed, command, fly, rows


def test_a_scenario_in_the_place_of_a_campaign_is_told_in_a_sentence(loop):
    result = command(loop)
    assert (result.exit_code, result.stderr) == (
        2,
        f"{loop}:1: is a scenario; expected a campaign, which names one under 'scenario'; remedy: orchestrate run\n",
    )


def test_a_metric_of_an_output_that_the_mapping_ignores_is_refused_with_the_reason(toy):
    vendor.write(
        toy.parent, ('name="samples[1]"', 'name="first"'), ('name="samples[2]"', 'name="second"'), runnable=True
    )
    swap = "swap: {regulator: vendor.fmu}\nmap: {regulator: mapping.yaml}"
    changed(
        toy,
        ("runs: 60", f"runs: 60\n{swap}"),
        ("signal: motor.speed, statistic", "signal: regulator.samples, statistic"),
    )
    with pytest.raises(InputError, match="regulator.samples is an output that its FMU lacks; remedy: map it"):
        fly(toy, runs=1)
    path = toy.with_name("mapping.yaml")
    path.write_text(path.read_text() + "ignore: [samples]\n")
    told = "regulator.samples is under 'ignore' in the mapping, so there is no such output; remedy: map it"
    with pytest.raises(InputError, match=told):
        fly(toy, runs=1)


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        ((("statistic: final", "statistic: last"),), r"toy.yaml:8: metrics\[1\].statistic: expected 'final'"),
        ((("metric: final", "metric: finl"),), r"toy.yaml:11: .*there is no metric 'finl'; did you mean 'final'"),
        ((("below: 0.2 rad/s", "below: 0.2 kg"),), r"toy.yaml:11: .*the unit 'kg' does not fit"),
        ((("signal: motor.speed, statistic", "signal: motor.sped, statistic"),), r"toy.yaml:8: .*no variable 'sped'"),
        ((("uniform: [1 rad/s, 2 rad/s]", "uniform: [2 rad/s, 1 rad/s]"),), r"toy.yaml:6: .*expected \[low, high\]"),
        ((("uniform: [1 rad/s", "unifrm: [1 rad/s"),), r"toy.yaml:6: .*unknown key 'unifrm'; did you mean 'uniform'"),
        ((("uniform: [1 rad/s, 2 rad/s]", "uniform: [1 m, 2 m]"),), r"toy.yaml:6: .*the unit 'm' does not fit"),
        (
            (("scenario: loop.yaml", "scenario: lop.yaml"),),
            r"lop.yaml: there is no such file; did you mean 'loop.yaml'",
        ),
        ((("runs: 60", "runs: 60\nset: {motor.speed0: 2}"),), r"toy.yaml:4: set.motor.speed0: motor.speed0 varies"),
        ((("runs: 60", "runs: 60\nsampling: grid"),), r"a grid needs an entry"),
        ((("runs: 60", "runs: 60\nstop: decided\nsampling: sobol"),), r"toy.yaml:4: stop: only runs drawn at random"),
        ((("runs: 60", "runs: 60\nsearch: {metric: fnal}"),), r"toy.yaml:4: search: .*no metric 'fnal'; did you mean"),
        ((("runs: 60", "runs: 60\nswap: {motor: gone.fmu}"),), r"toy.yaml:4: swap.motor: there is no FMU .*gone.fmu"),
        ((("runs: 60", "runs: 60\nswap: {engine: gone.fmu}"),), r"toy.yaml:4: swap.engine: there is no block"),
        (
            (("{uniform: [1 rad/s, 2 rad/s]}", '{expression: "[1, 2][3]"}'),),
            r"toy.yaml:6: vary.motor.speed0.expression: .*\[1, 2\] has 2 elements, found \[1, 2\]\[3\]",
        ),
        (
            (("{uniform: [1 rad/s, 2 rad/s]}", f"{{expression: '{'(' * 2000}'}}"),),
            r"toy.yaml:6: \S+: the expression is too long: expected at most 1000 characters, found 2000; "
            r"remedy: [^(]+$",
        ),
        (
            (("{uniform: [1 rad/s, 2 rad/s]}", "{grid: {from: 0, to: 1, points: 2000000}}"),),
            r"toy.yaml:6: vary.motor.speed0.grid: points: input should be less than or equal to 1000000, found "
            r"2000000$",
        ),
        (
            (
                ("signal: motor.speed, statistic: final", "python: 'gone:f', signals: [motor.speed]"),
                ("signal: motor.speed, settles: {below: 0.5}", "python: 'gone:g', signals: [motor.speed]"),
            ),
            r"toy.yaml:8: .*the module 'gone' cannot be loaded: there is no file .*gone.py, and no installed "
            r".*remedy: [^\n]*$",
        ),
        ((("{uniform: [1 rad/s, 2 rad/s]}", "{expression: gone}"),), r"toy.yaml:6: .*no value 'gone'"),
        (
            (("vary:", "vary:\n  motor.mode: {choice: [braek, normal]}"),),
            r"toy.yaml:6: vary.motor.mode: .*'braek'",
        ),
        (
            (("vary:", "vary:\n  motor.mode: {choice: [normal, braek, brake], weights: [8, 1, 1]}"),),
            r"toy.yaml:6: vary.motor.mode: .*'braek'",
        ),
        (
            (("vary:", "draw:\n  half: {choice: [1, 1, 1.2]}\nvary:\n  motor.poles: {expression: 2 * half}"),),
            r"toy.yaml:8: vary.motor.poles: .*expected a whole number, found 2.4",
        ),
        (
            (("vary:", "vary:\n  motor.inertia: {grid: {from: 1, to: 14, points: 1000000}}"),),
            r"toy.yaml:6: vary.motor.inertia: .*expected at most 10",
        ),
        (
            (("{uniform: [1 rad/s, 2 rad/s]}", "{sphere: {choice: [1, fast, 2]}}"),),
            r"toy.yaml:6: vary.motor.speed0.sphere: sphere: expected one number as its length, found 'fast'",
        ),
        (
            (("runs: 60", "runs: 60\nkeep: {runs: [9223372036854775808]}"),),
            r"toy.yaml:4: keep.runs\[1\]: expected less than 1e",
        ),
        ((("metric: final, below: 0.2 rad/s", "expectation: stops"),), r"toy.yaml:11: .*no expectation 'stops'"),
    ],
)
def test_a_wrong_file_is_told_with_its_line(toy, pairs, message):
    with pytest.raises(InputError, match=message):
        read_campaign(changed(toy, *pairs))


def test_a_run_to_be_kept_beyond_the_last_is_told(toy):
    case = read_campaign(changed(toy, ("runs: 60", "runs: 60\nkeep: {runs: [3, 60]}")))
    assert "keep.runs: 60: not flown, the last run is 59" in case.notes


def test_a_scenario_may_stand_in_the_file_with_what_it_changes(toy):
    changed(toy, ("scenario: loop.yaml", "scenario:\n  extends: loop.yaml\n  duration: 1 s"))
    fly(toy, runs=2)
    assert [row["final"] / row["motor.speed0"] for row in rows()] == pytest.approx([0.9**10] * 2)


def test_a_campaign_extends_another_and_replaces_a_distribution_as_a_whole(toy):
    folder = toy.parent / "deep"
    folder.mkdir()
    changed(toy, ("scenario: loop.yaml", "scenario: {extends: loop.yaml, duration: 1 s}"))
    over = folder / "over.yaml"
    over.write_text(
        f"extends: ../{toy.name}\nname: over\nruns: 3\nvary: {{motor.speed0: {{grid: [2, 4, 8]}}}}\nsampling: grid\n"
    )
    fly(over, out="over")
    assert [row["motor.speed0"] for row in rows("over")] == [2.0, 4.0, 8.0]
    assert [row["final"] / row["motor.speed0"] for row in rows("over")] == pytest.approx([0.9**10] * 3)


def test_a_start_value_for_all_runs_comes_from_the_file_or_the_command_line(toy):
    changed(toy, ("runs: 60", "runs: 3\nset: {regulator.gain: -2}"))
    command(toy, "--workers", 0, "--out", "file")
    command(toy, "--workers", 0, "--out", "option", "--set", "regulator.gain=-3")
    for out, factor in (("file", 0.8), ("option", 0.7)):
        assert [r["final"] / r["motor.speed0"] for r in rows(out)] == pytest.approx([factor**20] * 3)


def test_a_start_value_of_the_command_line_goes_beside_an_empty_set_and_leaves_the_callers_data(toy):
    changed(toy, ("runs: 60", "runs: 60\nset:"))
    assert read_campaign(toy, None, {"regulator.gain": -3}).campaign.set == {"regulator.gain": -3}
    source = read(toy)
    read_campaign(source, None, {"regulator.gain": -3})
    assert source.data["set"] is None
    changed(toy, ("set:", "set: [regulator.gain]"))
    with pytest.raises(InputError, match=r"toy.yaml:4: set: "):
        read_campaign(toy, None, {"regulator.gain": -3})


@pytest.mark.parametrize(
    ("section", "more", "fits"),
    [
        ("search: {metric: final, runs: 20}", "", True),
        ("sensitivity: {method: morris, points: 4}", "", False),
        ("sensitivity: {method: morris, points: 4}", "\n  regulator.gain: {uniform: [-2, -1]}", True),
    ],
)
def test_a_search_needs_one_number_that_varies_and_a_sensitivity_two(toy, section, more, fits):
    changed(toy, ("seed: 4", f"seed: 4\n{section}"), ("2 rad/s]}", "2 rad/s]}" + more))
    if fits:
        read_campaign(toy)
        return
    with pytest.raises(InputError, match="expected 2 or more numbers that vary, found 1"):
        read_campaign(toy)
