"""The generated set of vendors' FMUs: each kind can be made, and of some is said what was written beforehand."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestration.session.open import open_scenario
from orchestration.session.read import load, read

from .vendors import kinds, wrapper
from .vendors.judge import Verdict, judge

SCENARIO = Path(__file__).parents[1] / "scenarios" / "paper_no_singularity.yaml"


def judged(case: kinds.Case, folder: Path, flavour: str = "FMI 2") -> Verdict:
    """What is said of the FMU of a case, packed in the folder."""
    ours = read(SCENARIO)
    opened, block = open_scenario(load(ours)), case.vendor.block
    starts = [(start.element, start.value) for start in opened.plan.starts[block]]
    return judge(case, wrapper.pack(folder / "vendor.fmu", case.vendor, opened.fmus[block], starts, flavour), ours)


def test_each_kind_can_be_made_alone_and_has_a_truth_of_every_port():
    for number, name in enumerate(kinds.KINDS):
        case = kinds.make(number, [name], units=True)
        assert case is not None
        assert set(case.truth) == {port.ours for port in case.vendor.ports}
        assert bool(case.named) == (case.answer == "wrong")
        assert bool(case.causes) == (case.answer == "cause")


@pytest.mark.parametrize(
    ("kind", "seed", "flavour"),
    [
        ("Euler angles", 5, "FMI 2"),
        ("axes of all, untold", 2, "FMI 2"),
        ("rate in N, untold", 1, "Python"),
        ("late", 3, "FMI 3"),
    ],
)
@pytest.mark.compile
def test_what_was_written_beforehand_is_said_and_nothing_false(kind, seed, flavour, tmp_path):
    verdict = judged(kinds.make(seed, [kind], units=True), tmp_path, flavour)
    assert not verdict.false
    assert (verdict.proposed, verdict.named) in ((True, None), (None, True)), verdict.said


@pytest.mark.parametrize(
    ("seed", "pair", "units"),
    [
        (9210155, ["other parameter"], True),
        (9210102, ["opposite sign, untold", "left-handed port, untold"], True),
        (9208064, ["position along the Earth's axes", "stuck"], True),
        (9208306, ["axes of a port, untold", "opposite sign, untold"], False),
        (9204042, ["saturated", "rate in N, untold"], True),
        (9204045, ["position along the Earth's axes", "rate relative to LVLH"], True),
        (9204060, ["single precision", "rate relative to LVLH"], True),
        (9204075, ["position along the Earth's axes", "left-handed port, untold"], True),
        (9204121, ["position along the Earth's axes", "unit, untold"], True),
        (9204085, ["orbit along the axes of J2000", "left-handed port, untold"], True),
        (9206140, ["bias of an axis", "position along the Earth's axes"], True),
        (9206085, ["orbit along the axes of J2000", "bias of an axis"], True),
        (9207189, ["unit, untold", "noise"], True),
        (9207344, ["unit, untold", "own sample time"], True),
    ],
)
@pytest.mark.thorough
def test_pairs_that_were_missed_once_are_named(seed, pair, units, tmp_path):
    verdict = judged(kinds.make(seed, pair, units=units), tmp_path)
    assert verdict.named, verdict.said
    assert not verdict.false


@pytest.mark.parametrize(
    ("seed", "pair", "units"),
    [
        (9208088, ["noise", "orbit along the axes of J2000"], True),
        (9208164, ["unit, untold", "other parameter"], False),
        (9209261, ["rate relative to LVLH", "other parameter"], True),
    ],
)
@pytest.mark.thorough
def test_what_cannot_be_told_apart_is_not_stated(seed, pair, units, tmp_path):
    verdict = judged(kinds.make(seed, pair, units=units), tmp_path)
    assert verdict.detected
    assert not verdict.false


@pytest.mark.compile
def test_a_turn_of_all_is_named_where_theirs_has_no_limit_at_which_ours_would_hold(tmp_path):
    case = kinds.make(1, ["axes of all, untold"], units=True)
    assert case.vendor.block == "allocator"
    for name in ("dipole_max", "wheel_torque_max"):
        case.vendor.changed[name, 0] = 100.0
    verdict = judged(case, tmp_path)
    assert verdict.named, verdict.said
    assert not verdict.false


@pytest.mark.thorough
def test_of_one_that_never_gives_anything_it_is_told_that_it_is_stuck_and_no_wiring(tmp_path):
    case = kinds.make(3, ["names only"], units=True)
    outputs = [port for port in case.vendor.ports if port.causality == "output"]
    case.vendor.effects = [("dead", port.ours, i, 1e9) for port in outputs for i in range(port.size)]
    case.causes = [("stuck", port.ours, 0.0) for port in outputs]
    verdict = judged(case, tmp_path)
    assert not verdict.false
    assert [words for words in verdict.said if "stuck at 0" in words] == verdict.said != []
