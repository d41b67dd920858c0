"""What was once accepted in silence, hung or ended as an internal error; and how it is refused."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from orchestration import InputError, load, run
from orchestration.quantities import QuantityError, parse, parse_unit
from tests.commands import orchestrate


def refused(loop, old, new):
    text = loop.read_text()
    assert old in text
    loop.write_text(text.replace(old, new, 1))
    result = orchestrate(loop.name)
    assert result.exit_code == 2, result.output
    return result.stderr.rstrip("\n")


START = "inertia: 0.5"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (START, f"poles: {'9' * 5000}", "expected a number, found '99999999999999999999' ... of 5000 digits"),
        (START, f"inertia: {'9' * 400}", "expected a number, found '99999999999999999999' ... of 400 digits"),
        (START, f"inertia: {'9' * 400}.5", "loop.yaml:9: blocks.motor.start.inertia: expected a finite number, found"),
        (START, "inertia: !!float abc", "loop.yaml:9: blocks.motor.start.inertia: expected a number, found 'abc'"),
        (START, "<<: {inertia: 0.5}", "loop.yaml:9: merging by '<<' is not supported; remedy: write the entries out"),
        (START, "inertia: 1 9**9**9**9 m", "loop.yaml:9: blocks.motor.start.inertia: unknown unit '9**9**9**9 m'"),
        (START, "inertia: 1 Pas", "the unit 'Pas' would be read as 'pascal'; did you mean 'Pa.s'?"),
        (START, '"\\uD800": 1', r"loop.yaml:9: expected text, found half a character (a surrogate) in '\ud800'"),
        (START, 'inertia: "\\uD800"', "loop.yaml:9: blocks.motor.start.inertia: expected text, found half a character"),
        (START, "inertia: 10 dB", "loop.yaml:9: blocks.motor.start.inertia: the unit 'dB' is logarithmic"),
        (START, "inertia: '0,5'", "loop.yaml:9: blocks.motor.start.inertia: expected a decimal point, 0.5, found"),
        (
            START,
            "'axis[1]': 1\n      'axis[ 1 ]': 2",
            "loop.yaml:10: blocks.motor.start.axis[ 1 ]: has a start value already, by 'axis[1]', in line 9",
        ),
        (
            START,
            "axis: [1, 0, 0]\n      'axis[2]': 2",
            "loop.yaml:10: blocks.motor.start.axis[2]: has a start value already, by 'axis', in line 9",
        ),
        (
            START,
            "'axis[2]': 2\n      axis: [1, 0, 0]",
            "loop.yaml:10: blocks.motor.start.axis: has a start value already, by 'axis[2]', in line 9",
        ),
        (
            "fmu: motor.fmu",
            "fmu: motor.fmu\n    flavour: python",
            "loop.yaml:7: blocks.motor.flavour: only this project's own blocks have a flavour; motor.fmu is a file",
        ),
        ("fmu: motor.fmu", "fmu: http://x/y.fmu", "http://x/y.fmu is an address; expected the path of an .fmu file"),
        (
            "interval: 0.1 s",
            "signals: []",
            "loop.yaml:16: record.signals: must not be empty; without it all outputs of all blocks are recorded",
        ),
        (
            "fmu: motor.fmu",
            f"memory: '{'9' * 400}'\n    fmu: motor.fmu",
            "loop.yaml:6: blocks.motor.memory: expected at",
        ),
        (
            "name: loop\n",
            "",
            "'name' is missing: its name, and that of the results' folder: letters, digits, `.`, `_` and `-`",
        ),
    ],
)
def test_it_is_refused_with_its_place(loop, old, new, message):
    assert message in refused(loop, old, new)


def test_an_option_still_takes_the_place_of_one_element_of_a_vector(loop):
    loop.write_text(loop.read_text().replace(START, "axis: [1, 0, 0]"))
    assert run(loop, {"motor.axis[2]": 0.5}).manifest["parameters"]["motor"]["axis"] == [1, 0.5, 0]


def test_what_a_block_of_the_python_flavour_refuses_is_told_in_its_words_and_not_by_its_code():
    """The traceback in its log has a line of code that names the value, too."""
    scenario = Path(__file__).parents[3] / "scenarios" / "minimal.yaml"
    with pytest.raises(InputError) as info:
        run(scenario, {"plant.orbit_start": "position_velocity", "plant.r_N0": [0, 0, 0], "flavour": "python"})
    assert "plant.r_N0=[0, 0, 0]: r_N0, v_N0: expected an orbit, found [0.0, 0.0, 0.0] m and " in str(info.value)
    assert "raise" not in str(info.value)


def test_whole_numbers_that_no_double_holds_are_refused_from_python_too(loop):
    with pytest.raises(InputError, match=r"expected a number below 1\.8e308"):
        run(loop, {"motor.inertia": 10**400})
    data = load(loop).source.data
    expectation = {**data["expect"][0], "always": {"below": 10**400}}
    for entry in data["blocks"].values():
        entry["fmu"] = str(loop.parent / entry["fmu"])
    with pytest.raises(InputError, match=r"always\.below: expected a number below 1\.8e308"):
        run({**data, "expect": [expectation]})


@pytest.mark.parametrize(
    "error", [NotADirectoryError(20, "Not a directory", "build/fmus"), OSError(28, "No space left")]
)
def test_a_build_folder_that_cannot_be_written_is_named(loop, monkeypatch, error):
    def ensure(*arguments, **named):
        raise error

    monkeypatch.setattr("orchestration.session.open.ensure", ensure)
    told = refused(loop, "fmu: motor.fmu", "fmu: plant")
    place = (
        "build/fmus: a part of this path is a file; expected a folder"
        if error.filename
        else "the disk: the disk is full"
    )
    assert told == f"loop.yaml:6: blocks.motor.fmu: the block 'plant' cannot be built: {place}"


def test_a_spoilt_build_is_told_with_its_remedy(loop, monkeypatch):
    spoilt = loop.parent / "plant.fmu"
    spoilt.write_bytes((loop.parent / "motor.fmu").read_bytes()[:-200])
    monkeypatch.setattr("orchestration.session.open.ensure", lambda *arguments, **named: spoilt)
    told = refused(loop, "fmu: motor.fmu", "fmu: plant")
    assert told.endswith("plant.fmu is a damaged or truncated zip archive; remedy: orchestrate build plant")
    told = refused(loop, "duration: 2 s", "flavour: python\nduration: 2 s")
    assert told.endswith("; remedy: orchestrate build plant --flavour python")


@pytest.mark.parametrize(
    "unit",
    ["9**9**9**9 m", "m**9**9**9", "m**9 **9 **9", "m2**9**9", "2 m", "m.9", "m999", "Mm99", "m2" * 45 + "!", "((m"],
)
def test_a_unit_that_nobody_writes_is_refused_at_once(unit):
    begun = time.monotonic()
    with pytest.raises(QuantityError):
        parse(f"1 {unit}")
    assert time.monotonic() - begun < 5.0


@pytest.mark.parametrize("unit", ["1/s", "m^(-2)", "kg*m**2", "N.m/(rad/s)", "cmH2O", "%", "A m2", "Wh"])
def test_what_is_usual_is_still_understood(unit):
    assert parse_unit(unit).exponents is not None


def test_units_that_are_run_together_or_in_another_case_are_guessed():
    for unit, meant in (("sA", "'s.A'"), ("Kg", "'kg'"), ("mPas", "'mPa.s'"), ("KM", "'km'")):
        with pytest.raises(QuantityError, match=f"did you mean .*{meant}"):
            parse_unit(unit)
