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
