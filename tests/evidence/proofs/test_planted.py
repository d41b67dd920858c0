"""Planted faults: the list fits the sources, and with Frama-C a few of them are found.

Shows FC-1.
"""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from evidence.proofs.analysis import Alarm
from evidence.proofs.argued import Argument, arguments, unproved
from evidence.proofs.faults import Fault, faults
from evidence.proofs.make import prove
from evidence.proofs.planted import found, subject_of
from evidence.proofs.rounds import FLIGHT_CODE
from fmus.places import PACKAGES
from orchestration import InputError

FAULTS = faults()
needs_frama_c = pytest.mark.skipif(
    shutil.which("frama-c") is None, reason="frama-c is not installed (Debian: frama-c-base)"
)


def test_there_are_more_than_thirty_faults_in_each_kind_of_code():
    assert len(FAULTS) > 30
    assert {f.subject.partition(",")[0] for f in FAULTS} >= {
        "allocator",
        "allocator_bounded",
        "controller",
        "frame",
    }


@pytest.mark.parametrize("fault", FAULTS, ids=lambda f: f.about)
def test_a_fault_changes_its_file_in_one_place_and_names_a_proof_that_reads_it(fault, tmp_path):
    copy = tmp_path / fault.file
    copy.parent.mkdir(parents=True)
    shutil.copy(PACKAGES / fault.file, copy)
    fault.plant(tmp_path)
    assert copy.read_text("utf-8") != (PACKAGES / fault.file).read_text("utf-8")
    subject_of(fault.subject)


def test_a_fault_whose_text_is_gone_is_named(tmp_path):
    (tmp_path / "a.c").write_text("int x;\n")
    with pytest.raises(InputError, match="a loop: a.c has 'int y;' 0 times, expected once"):
        Fault("date", "a loop", "a.c", "int y;", "", "index_bound").plant(tmp_path)


def test_an_argument_holds_for_its_own_property_only():
    alarm = Alarm("vector.h", 76, "direction", "postcondition", "-1.25 ≤ \\result.x ≤ 1.25 ∧ ...")
    assert unproved([alarm], arguments()) == []
    rests_on = ("fmus/native/common/vector.h: direction",)
    its_own = Argument("vector.h", "direction", "postcondition", "-1.25", "since", rests_on, "")
    its_own = replace(its_own, code=its_own.digest())
    assert unproved([alarm], [its_own]) == []
    changes = {"file": "box.c", "function": "norm", "kind": "precondition of direction", "text": "-1.26"}
    for name, other in changes.items():
        assert unproved([alarm], [replace(its_own, **{name: other})]) == [alarm]


@pytest.mark.thorough
@needs_frama_c
def test_the_allocator_is_proved_with_and_without_limits():
    for _, result in prove(["allocator"]):
        assert result.statements[0] > 500
        assert result.alarms == () or unproved(result.alarms, arguments()) == []


@pytest.mark.thorough
@needs_frama_c
@pytest.mark.parametrize("number", [1, 3, 6, 30])
def test_a_planted_fault_is_found(number, tmp_path):
    assert found(FAULTS[number - 1], Path(tmp_path))


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("fmus/native/common/vector.h", "const double d = 1.0 / dot(m.a, u)", "const double d = 2.0 / dot(m.a, u)"),
        ("fmus/native/freestanding/elementary.c", "shift = 6755399441055744.0", "shift = 1.0"),
        ("allocator/native/allocator.c", "ACROSS_MIN = 1e-3", "ACROSS_MIN = 0.0"),
        ("controller/native/controller.c", "store_matrix(nearest_rotation(", "store_matrix(transposed("),
        ("fmus/native/common/rotation.h", "ensures -1.01 <= \\result.a.x <=", "ensures -0.5 <= \\result.a.x <="),
    ],
)
def test_an_argument_rests_on_what_its_functions_call_on_constants_and_on_callers(tmp_path, file, old, new):
    for package in FLIGHT_CODE:
        shutil.copytree(PACKAGES / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    path = tmp_path / file
    text = path.read_text("utf-8")
    assert text.count(old) == 1
    same = [a.digest(tmp_path) == a.code for a in arguments()]
    assert all(same)
    other = tmp_path / "other"
    for package in FLIGHT_CODE:
        shutil.move(tmp_path / package, other / package)
    (other / file).write_text(text.replace(old, new))
    assert not all(a.digest(other) == a.code for a in arguments())
