"""The page of margins: what is kept belongs to today's flights, and the page to what is kept."""

import json
import re
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from evidence.margins import cases, make, page
from fmus.build import ensure
from orchestration.fmu.archive import open_fmu


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
    assert page._decay("hold", [row]) == ["hold", "none; not linear at 1 places", "none", "none", "none"]
    known = {"refused": "", "left": 0.25, "orbit": 0.5, "wrong": 0.01, "rest": 0.3, "flown": 2.0}
    beneath = {**known, "left": 1e-5, "rest": 0.01}
    assert page._decay("hold", [known, beneath]) == ["hold", "1e-05 to 0.25", "0.5 to 0.5", "30%", "2°"]


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


def test_a_build_with_other_comments_and_identity_is_the_same_code_and_one_with_another_number_is_not(tmp_path):
    was = ensure("allocator")

    def built(number, **texts):
        """The FMU with a text put before the one that an entry has, or something replaced in it."""
        path = tmp_path / f"{number}.fmu"
        with zipfile.ZipFile(was) as old, zipfile.ZipFile(path, "w") as new:
            for name in old.namelist():
                data = old.read(name)
                for end, change in texts.items():
                    data = change(data) if name.endswith((f"{end}.c", f"{end}.xml")) else data
                new.writestr(name, data)
        return make.code(open_fmu(path))

    stated = make.code(open_fmu(was))
    assert any(name.endswith("allocator.c") for name in stated[1])
    assert built(1, allocator=lambda data: b"/* why */ // so\n" + data.replace(b"\n", b"\n  ")) == stated
    assert built(2, lifecycle=lambda data: data + b"int more;", table=lambda data: data + b"int more;") == stated
    assert built(3, allocator=lambda data: data + b"int more;") != stated
    later = lambda data: re.sub(rb'(name="hold_fraction".*?start=")[^"]*', rb"\g<1>0.25", data, flags=re.S)  # noqa: E731
    starts, code = built(4, modelDescription=later)
    assert (starts != stated[0], code == stated[1]) == (True, True)


def measured(count, value):
    with count.open("a", encoding="utf-8") as file:
        file.write("flown\n")
    return [{"value": value}]
