"""The page of margins: what is kept belongs to today's flights, and the page to what is kept."""

import json
from dataclasses import replace

import numpy as np
import pytest

from evidence.margins import cases, make, page


@pytest.fixture(scope="module")
def kept():
    return json.loads(make.KEPT.read_text("utf-8"))


def test_the_page_is_that_of_what_is_kept(kept):
    text = page.render(page.Path(page.__file__).parent, **page.fields(kept))
    assert page.PAGE.read_text("utf-8") == text


def test_an_equilibrium_measured_today_is_that_of_the_page(kept):
    (found,) = cases.equilibrium((-1, 1, -1))
    stated = next(one for one in kept["equilibria"] if one["turn"] == [-1, 1, -1])
    np.testing.assert_allclose(found["rates"], stated["rates"], atol=1e-6)


def test_vb_has_margins_at_every_place_and_they_bracket_the_loss_of_stability_within_a_tenth(kept):
    delay = next(one for one in kept["changes"] if (one["case"], one["name"]) == (cases.VB, "delay"))
    rows = [row for row in kept["places"] if row["case"].startswith("V.B")]
    assert [row["place"] for row in rows] == list(cases.PLACES)
    for row in rows:
        assert row["delay"] == pytest.approx(delay["holds"], rel=0.1)
        assert row["delay"] == pytest.approx(delay["lost"], rel=0.1)


def test_the_paper_has_one_stable_equilibrium_and_saddles_of_one_two_and_three_directions(kept):
    rates = {tuple(one["turn"]): sorted(one["rates"], key=abs)[1:] for one in kept["equilibria"]}
    assert {turn: sum(rate > 0 for rate in found) for turn, found in rates.items()} == {
        (1, 1, 1): 0,
        (-1, -1, 1): 1,
        (-1, 1, -1): 2,
        (1, -1, -1): 3,
    }


def test_answers_of_the_planned_hold_predict_the_delay_that_loses_it_within_a_quarter(kept):
    losses = page.losses(kept["delays"])
    assert list(losses) == list(make.DELAYS)
    for predicted, flown in losses.values():
        assert predicted == pytest.approx(flown, rel=0.25)


def test_answers_that_cross_a_level_are_found_by_their_logarithm():
    rows = [{"name": name, "error": 0.0} for name in make.DELAYS for _ in range(2)]
    for row, (delay, left, flown) in zip(rows, [(4.0, 0.1, 0.05), (6.0, 10.0, 5.0)] * 3, strict=True):
        row |= {"delay": delay, "left": left, "flown": flown}
    assert page.losses(rows) == {name: (pytest.approx(5.0), pytest.approx(5.0)) for name in make.DELAYS}


def test_a_place_whose_loop_is_not_linear_has_no_number():
    row = {"place": 90, "refused": "the loop is not linear here", "left": 0.3, "error": 0.9}
    assert page._left("hold", [row])[1:4] == ["not measured", "not measured", "not linear"]
    assert page._orbits("hold", [row])[3] == "none"


def test_every_hold_was_measured_at_every_place(kept):
    assert {(row["case"], row["place"]) for row in kept["places"]} == {
        (name, place) for name in cases.CASES for place in cases.PLACES
    }


def test_what_is_kept_of_the_same_inputs_is_not_measured_again(tmp_path, monkeypatch):
    """A file keeps count of the measurements, which other processes make."""
    count = tmp_path / "count"
    monkeypatch.setattr(make, "KEPT", tmp_path / "margins.json")
    job = make.Job("delays", cases.PLANNED, measured, (count, 2))
    for jobs, lines in (([job], 1), ([job], 1), ([replace(job, arguments=(count, 3))], 2)):
        monkeypatch.setattr(make, "jobs", lambda jobs=jobs: jobs)
        make.make(1)
        assert len(count.read_text("utf-8").splitlines()) == lines
    (row,) = json.loads(make.KEPT.read_text("utf-8"))["delays"]
    assert row["value"] == 3  # what is no job any more is left out
    make.make(1, anew=True)
    assert len(count.read_text("utf-8").splitlines()) == 3


def measured(count, value):
    with count.open("a", encoding="utf-8") as file:
        file.write("flown\n")
    return [{"value": value}]
