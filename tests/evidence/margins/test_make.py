"""The page of margins: what is kept belongs to today's flights, and the page to what is kept."""

import json

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
    found = cases.equilibrium((-1, 1, -1))
    stated = next(one for one in kept["equilibria"] if one["turn"] == [-1, 1, -1])
    np.testing.assert_allclose(found["rates"], stated["rates"], atol=1e-6)


def test_vb_has_margins_at_every_place_and_they_bracket_the_loss_of_stability_within_a_tenth(kept):
    delay = next(one for one in kept["changes"] if one["name"] == "delay")
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


def test_every_hold_was_measured_at_every_place_or_the_page_says_that_it_was_not(kept):
    places = {(row["case"], row["place"]) for row in kept["places"]}
    without = {name for name in cases.CASES if not {(name, place) for place in cases.PLACES} <= places}
    assert without <= {name for name in cases.CASES if any(name in said for said in page.fields(kept)["missing"])}
