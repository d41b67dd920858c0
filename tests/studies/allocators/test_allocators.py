"""The comparison of the allocators: its figures of made-up runs, and two of its runs through the FMUs."""

import math

import numpy as np
import pytest

from studies.allocators.make import KEPT, NODES, Flown, comparison, compute, figures_of, load, rows, save
from studies.allocators.page import text
from studies.paper import DURATION, ORBIT
from studies.settling import settling_time


def test_settling_is_from_the_last_instant_outside():
    time = np.array([0.0, 0.1, 0.2, 0.3])
    for outside, expected in (([1, 0, 1, 0], 0.3), ([1, 1, 0, 0], 0.2), ([0, 0, 0, 0], 0.0)):
        assert settling_time(time, np.array(outside, bool)) == expected
    assert math.isnan(settling_time(time, np.array([0, 0, 0, 1], bool)))


def test_figures_of_a_run_part_the_manoeuvre_from_the_hold():
    time = np.arange(0.0, ORBIT, 1.0)
    late = time > DURATION + 1.0
    result = {
        "judge.attitude_error": np.where(time < 150.0, 1.0, 0.0) + np.where(time > ORBIT - 501.0, 1.0, 0.0),
        "judge.rate_error_B": np.zeros((len(time), 3)),
        "allocator.holding": time < 10.0,
        "plant.h_w": np.where(late, -7e-3, 2e-3),
        "plant.dipole": np.where(late[:, None], 3.0, [[1.0, -9.0, 2.0]]),
    }
    run = type("Run", (), {"time": time, "__getitem__": lambda self, name: result[name]})()
    settled, out, wheel, later, dipole, held, latched = figures_of(run)
    assert settled == 150.0
    assert out == pytest.approx(500.0 / (ORBIT - DURATION), rel=0.01)
    assert (wheel, later, dipole, latched) == (2e-3, 7e-3, 9.0, 0.0)
    assert held == pytest.approx(10.0 / len(time))


def test_kept_is_settled_and_never_out_again():
    nothing = np.zeros(3)
    f = Flown(np.array([math.nan, 180.0, 180.0]), np.array([0.0, 0.1, 0.0]), *[nothing] * 5)
    assert f.kept.tolist() == [False, False, True]


def test_where_the_papers_hold_latches_the_bounded_allocator_settles():
    """V.C at 200 deg E, which docs/reproduction.md shows latched."""
    chosen = {name: case for name, case in comparison().items() if case.which == "V.C"}
    done = compute(chosen, 1, [200.0])
    paper, bounded = done["V.C allocator a"], done["V.C allocator_bounded a"]
    assert paper.latched[0] == 1.0
    assert math.isnan(paper.settled[0])
    assert paper.wheel_later[0] == pytest.approx(0.03)
    assert bounded.held[0] == 0.0
    assert bounded.settled[0] < 200.0
    assert bounded.kept[0]
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
    """Remedy: python -m studies allocators --page."""
    assert KEPT.with_suffix(".md").read_text("utf-8") == text(load())
