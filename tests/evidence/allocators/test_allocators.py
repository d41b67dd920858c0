"""The comparison of the allocators: its figures of made-up runs, and two of its runs through the FMUs."""

import math
from dataclasses import fields

import numpy as np
import pytest

from evidence.allocators.make import KEPT, NODES, Flown, comparison, compute, figures_of, load, rows, save
from evidence.allocators.metrics import END, out
from evidence.allocators.page import text
from evidence.paper import ORBIT, STEP


def test_what_is_out_of_tolerance_after_the_manoeuvre_counts_and_what_is_before_does_not():
    time = STEP * np.arange(round(ORBIT / STEP))
    late = time > END + 0.01
    angle = np.where(time < 150.0, 1.0, 0.0) + np.where(time > ORBIT - 500.0, 1.0, 0.0)
    rate = np.zeros((len(time), 3))
    rate[(time > 1000.0) & (time < 1100.0), 1] = 1e-3
    expected = 600.0 / (ORBIT - END)
    signals = {"judge.attitude_error": angle, "judge.rate_error_B": rate}
    assert out(time, signals) == pytest.approx(expected, rel=1e-3)
    assert (
        out(time, {**signals, "judge.attitude_error": np.where(late, 0.0, 1.0), "judge.rate_error_B": 0.9 * rate})
        == 0.0
    )


def test_a_manoeuvre_is_settled_when_both_errors_are():
    metrics = dict.fromkeys(("out", "wheel", "wheel_later", "dipole", "held", "latched"), np.zeros(3))
    metrics |= {"angle": np.array([150.0, 150.0, math.inf]), "rate": np.array([10.0, 160.0, 10.0])}
    np.testing.assert_array_equal(figures_of(metrics.__getitem__).settled, [150.0, 160.0, math.nan])


def test_kept_is_settled_and_never_out_again():
    nothing = np.zeros(3)
    f = Flown(np.array([math.nan, 180.0, 180.0]), np.array([0.0, 0.1, 0.0]), *[nothing] * 5)
    assert f.kept.tolist() == [False, False, True]


def test_where_the_papers_hold_latches_the_bounded_allocator_settles(tmp_path):
    """V.C at 200 deg E, which docs/evidence/reproduction.md shows latched."""
    chosen = {name: case for name, case in comparison().items() if case.which == "V.C"}
    done = compute(chosen, 0, [200.0], tmp_path)
    paper, bounded = done["V.C allocator a"], done["V.C allocator_bounded a"]
    assert paper.latched[0] == 1.0
    assert math.isnan(paper.settled[0])
    assert paper.wheel_later[0] == pytest.approx(0.03)
    assert bounded.held[0] == 0.0
    assert bounded.settled[0] < 200.0
    assert bounded.kept[0]
    written = load()["V.C allocator a"]
    assert [getattr(paper, f.name)[0] for f in fields(Flown)] == pytest.approx(
        [getattr(written, f.name)[20] for f in fields(Flown)], rel=1e-5, nan_ok=True
    )
    told = rows(done | {name.replace("C", "B"): f for name, f in done.items()}, "a")
    assert [row[2] for row in told] == ["0 of 1", "1 of 1"] * 2


def test_runs_that_are_kept_come_back(tmp_path):
    rng = np.random.default_rng(1)
    done = {name: Flown(*rng.random((7, len(NODES)))) for name in ("V.B allocator a", "V.C wheel_weight 0.2")}
    done["V.B allocator a"].settled[3] = math.nan
    save(done, tmp_path / "runs.csv")
    again = load(tmp_path / "runs.csv")
    assert again.keys() == done.keys()
    for name, runs in done.items():
        np.testing.assert_allclose(again[name].settled, runs.settled, rtol=1e-5)
        np.testing.assert_allclose(again[name].latched, runs.latched, rtol=1e-5)


def test_the_page_is_what_its_template_makes_of_the_kept_runs():
    """Remedy: python -m evidence allocators --page."""
    assert KEPT.with_suffix(".md").read_text("utf-8") == text(load())
