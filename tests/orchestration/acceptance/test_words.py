"""A comparison in words: what "equivalent" stands for, and when a difference is nothing."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orchestration.acceptance.difference import difference
from orchestration.acceptance.tolerances import tolerances
from orchestration.acceptance.verdict import _cells, status
from orchestration.acceptance.words import meanings, of_orbit, rotation_form, scalar_last
from orchestration.fmu.model import Model, Variable
from orchestration.quantities import parse_unit
from tests.commands import orchestrate

from ..swapped import swapped
from .test_compare import ARGUMENTS, of_gain

TIME = np.array([0.0, 1.0, 2.0])


def found(ours, theirs, *wanted, nominal=1.0):
    variable = Variable("torque", "output", unit=parse_unit("N.m"), nominal=nominal)
    bound = tolerances(wanted, Model("regulator", {"torque": variable}))["torque"]
    return difference(variable, np.array(ours)[:, None], np.array(theirs)[:, None], TIME, bound)


def test_a_difference_of_rounding_is_zero_however_small_the_output_is():
    d = found([1e-20, 2e-20, 0.0], [0.2e-20, 2e-20, 0.0])
    assert (d.passed, status(d)) == (True, "ok")
    assert _cells(d)[1:4] == ("0", "0", "0")


def test_a_difference_is_shown_with_its_share_where_ours_is_not_zero():
    assert _cells(found([0.0, 1.0, 2.0], [0.0, 1.0, 3.0]))[2] == "1 N.m (0.5)"
    assert _cells(found([0.0, 0.0, 0.0], [0.0, 0.1, 0.0]))[2] == "0.1 N.m"


def test_no_difference_has_no_unit():
    assert _cells(replace(found([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]), zero=0.0))[2:4] == ("0", "0")


@pytest.mark.parametrize(("nominal", "passed"), [(1.0, True), (1e-9, False)])
def test_what_counts_as_rounding_goes_by_the_nominal_value(nominal, passed):
    assert found([1e-16, 0.0, 0.0], [2e-16, 0.0, 0.0], nominal=nominal).passed is passed


@pytest.mark.parametrize(
    ("wanted", "passed", "word"),
    [
        ((), False, "differs"),
        (("torque=0.6 N.m",), True, "allowed"),
        (("torque=0.4 N.m",), False, "differs"),
        (("torque=any",), True, "allowed"),
    ],
)
def test_a_difference_that_only_a_wide_tolerance_allows_is_no_plain_ok(wanted, passed, word):
    d = found([1.0, 1.0, 1.0], [1.0, 1.5, 1.0], *wanted)
    assert (d.passed, status(d), d.share, d.rms_share) == (passed, word, 0.5, pytest.approx(0.5 / 3**0.5))


def test_the_rms_of_a_vector_is_that_of_its_worst_element_and_the_time_that_of_its_largest_difference():
    variable = Variable("torque", "output", shape=(3,), unit=parse_unit("N.m"))
    bound = tolerances((), Model("regulator", {"torque": variable}))["torque"]
    theirs = np.array([[1.0, 1.0, 1.0], [1.0, 1.25, 1.0], [1.0, 0.5, 1.0]])
    d = difference(variable, np.ones((3, 3)), theirs, TIME, bound)
    assert (d.largest, d.element, d.time) == (0.5, variable.label(1), 2.0)
    assert d.rms == pytest.approx(((0.25**2 + 0.5**2) / 3) ** 0.5)


def test_of_flags_the_share_of_samples_with_a_difference_counts_and_the_first_is_told():
    variable = Variable("lost", "output", "boolean", shape=(2,))
    bound = tolerances((), Model("regulator", {"lost": variable}))["lost"]
    theirs = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    d = difference(variable, np.zeros((3, 2)), theirs, TIME, bound)
    assert (d.largest, d.time, d.note, d.passed) == (pytest.approx(2.0 / 3.0), 1.0, "2 of 3 samples", False)


def test_a_tolerance_of_the_rms_alone_leaves_the_default_for_the_largest(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text("torque: {rms: 1 N.m}\n")
    assert not found([1.0, 1.0, 1.0], [1.0, 1.5, 1.0], str(path)).passed
    path.write_text("torque: {largest: any, rms: 1 N.m}\n")
    assert found([1.0, 1.0, 1.0], [1.0, 1.5, 1.0], str(path)).passed


def test_the_verdict_says_what_was_compared_and_which_difference_is_wide(tmp_path, monkeypatch):
    swapped(tmp_path, monkeypatch)
    of_gain(1.1)
    result = orchestrate(*ARGUMENTS, "--tolerance", "11 %")
    assert result.exit_code == 0, result.output
    assert "equivalent within wide tolerances: 2 of 2 outputs within tolerance" in result.stdout
    assert "within its tolerance at 21 instants, every 0.1 s, from 0 to 2 s" in result.stdout
    assert re.search(
        r"voltage: its largest difference is 0\.1 of our largest value; only its tolerance, 0\.11", result.stdout
    )
    data = json.loads(Path("out/comparison.json").read_text())
    assert data["meaning"][-1] in result.stdout.replace("\n  ", " ")
    assert 'class="badge warn">equivalent within wide tolerances' in Path("out/comparison.html").read_text()


@pytest.mark.parametrize(
    ("names", "text", "last"),
    [
        ("att", "Quaternion [x,y,z,w] body to inertial", True),
        ("att", "attitude, vector part first", True),
        ("q_x q_y q_z q_s", "", True),
        ("att", "Quaternion (w, x, y, z)", False),
        ("att", "attitude, scalar first", False),
        ("att", "attitude quaternion", None),
    ],
)
def test_the_place_of_a_quaternion_s_scalar_is_read_from_names_and_words(names, text, last):
    assert scalar_last(tuple(names.split()), text) is last


@pytest.mark.parametrize(
    ("text", "form"),
    [
        ("euler angles 3-1-2", "euler ZXY"),
        ("euler angles yxz", "euler YXZ"),
        ("Euler angles, ZXZ", "euler ZXZ"),
        ("euler angles, fixed axes zxy", "euler zxy"),
        ("euler 112", ""),
    ],
)
def test_a_sequence_of_angles_is_read_from_digits_and_letters(text, form):
    assert rotation_form(text) == form


def test_words_with_accents_and_of_other_languages_mean_the_same():
    assert meanings("moment_x", "Moment magn\u00e9tique command\u00e9") == {"dipole"}
    assert "rate" in meanings("Drehrate_x", "")
    assert "momentum" in meanings("Drall_Rad", "")


def test_a_rate_that_is_told_to_be_relative_to_the_orbit_is_told_apart():
    assert of_orbit("Body rate relative to the orbital frame (LVLH), body components")
    assert of_orbit("rate w.r.t. LVLH")
    assert not of_orbit("Body rate relative to inertial axes")
