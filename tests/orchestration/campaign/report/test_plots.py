"""What the plots and bars of a campaign's page are made of, without the page."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest

from orchestration.campaign.report import page as report
from orchestration.campaign.report import plots
from orchestration.campaign.report.influence import _effect

from ...results.swing import Reader
from .. import synthetic

ARRAYS = SimpleNamespace(add=lambda values: np.asarray(values, float))


@pytest.mark.parametrize(("worst", "extreme"), [("largest", np.nanmax), ("smallest", np.nanmin)])
@pytest.mark.parametrize("values", [[1.0, 4.0, np.nan, 2.0, 6.0, 5.0], [3.0], [5.0, np.inf, 7.0]])
def test_a_search_is_drawn_beside_what_as_many_of_the_campaigns_runs_had_shown(worst, extreme, values):
    sign = 1.0 if worst == "largest" else -1.0
    searched = {"worst": worst, "runs": 10, "history": [(3, sign * 5.0), (7, sign * 8.0)]}
    shown = plots.search(searched, plots.Metric("m", "", "", sign * np.array(values)), ARRAYS)
    found, own = (curve["y"] for curve in shown["curves"])
    for x, a, b in zip(shown["x"], found, own, strict=True):
        assert a == sign * 8.0 if x >= 7 else a == sign * 5.0 if x >= 3 else np.isnan(a)
        there = sign * np.array(values[: int(x)])
        there = there[np.isfinite(there)]
        assert np.isnan(b) if x > len(values) or not len(there) else b == extreme(there)
    assert {3.0, 7.0, 10.0} <= set(shown["x"])


def test_a_search_without_a_finite_value_is_not_drawn():
    searched = {"worst": "largest", "runs": 10, "history": [(3, None)]}
    assert plots.search(searched, plots.Metric("m", "", "", np.ones(3)), ARRAYS) is None


def test_both_bounds_of_a_share_have_its_colour():
    metric = plots.Metric("m", "", "", np.linspace(0.0, 1.0, 50), high=0.9, probability=0.5)
    shown = plots.distribution(metric, ARRAYS, False)
    assert {curve["colour"] for curve in shown["curves"]} == {0}


@pytest.mark.parametrize("items", [None, ["quiet", "mean", "storm"]])
def test_numbers_stand_at_their_place_and_texts_are_spread_beside_theirs(items):
    x, rows = np.array([2.0, 0.0, 1.0, 1.0]), np.array([0, 1, 3, 4])
    metric = plots.Metric("m", "", "", np.array([5.0, 3.0, 99.0, 4.0, 6.0]))
    shown = plots.scatter(metric, rows, x, "density", items, np.arange(10, 15), ARRAYS)
    assert shown["runs"].tolist() in ([11, 13, 14, 10], [11, 14, 13, 10])
    off = np.abs(shown["x"] - np.sort(x))
    assert off.max() == 0.0 if items is None else 0.0 < off.min() <= off.max() < 0.25
    low, high = shown["range"]
    assert low < shown["x"].min()
    assert high > shown["x"].max()
    assert high - low == pytest.approx(np.ptp(shown["x"]) + (0.08 if items is None else 0.4))


def test_an_effect_is_a_bar_with_its_error_on_both_sides():
    numbers = re.findall(r"[\d.]+(?=%)", str(_effect({"effect": [5.0], "effect_error": [1.0]}, 0, 10.0)))
    assert {"50.0", "40.0", "20.0"} <= set(numbers)


@pytest.mark.parametrize(("bounds", "word"), [({"high": 9.0}, "from 2 s"), ({"low": 0.0}, "up to 2 s")])
def test_of_few_runs_a_quantile_has_a_bound_on_its_good_side_only(bounds, word):
    metric = plots.Metric("time", "", "s", np.full(6, 2.0), **bounds)
    assert word in Reader(str(report._metric(metric, 0, False)[3])).words


def test_plots_that_are_left_out_are_told_and_those_that_correlate_most_come_first(tmp_path, monkeypatch):
    folder = synthetic.write(tmp_path, 300, analyses=False)
    told = "Only the first 3 plots are drawn."
    whole = report.page(folder)
    assert told.replace("3", str(report._PLOTS)) not in whole
    assert "runs are drawn" not in whole
    assert re.search(r"scenario \S*\.yaml", Reader(whole).words)
    monkeypatch.setattr(report, "_PLOTS", 3)
    page = report.page(folder)
    assert told in page
    found = [abs(float(x.replace("\N{MINUS SIGN}", "-"))) for x in re.findall(r"rank correlation (\S\d?\.\d+)", page)]
    assert len(found) == 3
    assert found == sorted(found, reverse=True)


@pytest.mark.parametrize(("file", "told"), [("a/b.yaml", "a/b.yaml"), (None, "detumble")])
def test_the_scenario_of_a_campaign_is_told_by_its_file_or_else_by_its_name(tmp_path, file, told):
    folder = synthetic.write(tmp_path, 30, analyses=False, scenario_file=file, scenario="detumble")
    words = Reader(report.page(folder)).words
    assert f"scenario {told}" in words
