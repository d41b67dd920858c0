"""The page of a campaign, and what the console shows at its end."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from orchestration.campaign.file.analysis import Sensitivity
from orchestration.campaign.flying.rows import Rows
from orchestration.campaign.report import page as report
from orchestration.campaign.report import plots
from orchestration.campaign.report.overview import failures
from orchestration.campaign.statistics import sensitivity
from orchestration.cli.campaign_summary import summary
from orchestration.results.html import Page

from ...results.browser import Tab, box, pixels, values
from ...results.swing import Reader, data_of, unpacked
from .. import synthetic
from ..analytic import Analytic


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of 1000 runs with all analyses, and its page."""
    made = synthetic.write(tmp_path_factory.mktemp("campaign"))
    report.write(made)
    return made


@pytest.fixture(scope="module")
def text(folder: Path) -> str:
    return (folder / "campaign.html").read_text("utf-8")


def test_the_page_says_what_came_of_the_campaign(text):
    words = Reader(text).words
    for said in (
        "1 of 4 requirements met, 3 of 4 requirements not met",
        "9 runs failed",
        "random, seed 1",
        "988 of 1000 runs meet it; probability at least 0.9806 at 95% confidence, required 0.9",
        "They hold for a number of runs that was fixed before (Clopper and Pearson).",
        "time from which |judge.rate_error_B| < 0.001 rad/s for good",
        "dotted: 1158 s, as required; 1 run without a finite value",
        "256 base points (Saltelli\u2019s design)",
        "The largest settle that 200 runs of a search found is 1159 s; that of the campaign's 1,000 runs is never.",
        "orchestrate campaign detumble_spread.yaml --replay RUN",
        "plant: fmi2DoStep at 812.5 s: the state is not finite 145, 247, 519, 573, 728",
        "the wheel stays within its limits 991 of 1,000 0.991 0.9829 to 0.99588",
        "drawn for expressions only",
        "0.988 at least 0.9806, at most 0.99307",
    ):
        assert said in words, said


@pytest.mark.parametrize("lower_is_worse", [False, True])
def test_a_row_of_metrics_has_what_half_of_the_runs_reach_and_says_where_they_never_do(lower_is_worse):
    values = np.append(np.arange(1.0, 61.0), [np.inf] * 35 + [np.nan] * 5)
    bounds = {"low": 0.0, "probability": 0.5} if lower_is_worse else {}
    values = np.where(np.isinf(values), -np.inf, values) if lower_is_worse else values
    metric = plots.Metric("time", "", "s", values, met=values > 0.0, **bounds)
    assert metric.lower_is_worse is lower_is_worse
    half, most = (str(cell) for cell in report._metric(metric, 5, False)[1:3])
    assert f"{'≥ 11' if lower_is_worse else '≤ 50'} s" in half
    assert "never or failed" not in half
    assert "never or failed" in most


def test_a_required_bound_is_on_the_axis_or_told_to_lie_beyond_it():
    values = np.linspace(2.0, 3.0, 50)
    for bound, on_it in ((5.5, True), (500.0, False)):
        metric = plots.Metric("error", "", "deg", values, high=bound, probability=0.9, met=values < bound)
        made = Page()
        drawn = plots.distribution(metric, made.arrays, False)
        assert drawn is not None
        assert drawn["marks"] == ([bound] if on_it else [])
        assert drawn["range"][1] == (bound if on_it else 3.0)
        said = str(report._distribution(metric, made, False))
        assert (f"dotted: {bound:g} deg, as required" in said) is on_it
        assert (f"{bound:g} deg, as required, beyond the axis" in said) is not on_it


def test_worst_runs_have_the_units_of_the_varied_values(text):
    assert "plant.h_w0, mN.m.s" in Reader(text).words.partition("Worst runs")[2]
    assert "rate, rad/s" in Reader(text).words.partition("Worst runs")[2]


def test_the_worst_of_a_metric_that_some_run_never_reaches_is_never(text):
    assert re.search(r"settle time from which .*? never 1 9 rms", Reader(text).words)


def test_what_a_name_holds_is_text_and_the_page_asks_for_nothing(text):
    assert "never &lt;b&gt;saturates&lt;/b&gt;" in text
    assert "<b>saturates" not in text
    assert not re.search(r'(src|href)="?(https?:)?//', text)


def test_the_distribution_at_the_bound_is_what_the_verdict_says(folder, text):
    manifest = json.loads((folder / "campaign.json").read_text("utf-8"))
    data = data_of(text)
    verdict = manifest["verdicts"][0]
    drawn, _, _, _, above, _ = (p for p in data["plots"] if p.get("lines_are") == "required probability")
    assert drawn["marks"] == [1158.0]
    assert drawn["lines"] == [verdict["probability"]]
    x = unpacked(data["arrays"][drawn["x"]])
    low, high, share = (unpacked(data["arrays"][c["y"]]) for c in drawn["curves"])
    at = np.searchsorted(x, 1158.0) - 1
    assert (low[at], high[at], share[at]) == pytest.approx(
        (verdict["low"], verdict["high"], verdict["share"]), abs=1e-6
    )
    assert above["label"] == "share of runs from a value on"  # where large values are wanted
    y = unpacked(data["arrays"][above["curves"][2]["y"]])
    at = np.searchsorted(unpacked(data["arrays"][above["x"]]), 0.98)
    assert y[at] == pytest.approx(manifest["verdicts"][2]["share"], abs=2e-3)


def test_each_failed_run_has_its_reason_and_the_page_names_the_first_five_of_each(tmp_path):
    rows = Rows(synthetic.write(tmp_path, 30, analyses=False, all_fail=True))
    reasons = rows.reasons()
    assert list(reasons) == list(range(30)) == rows.index[rows.failed].tolist()
    found = failures(reasons)
    counts = [int(str(count)) for count, *_ in found]
    assert (sum(counts), counts) == (30, sorted(counts, reverse=True))
    for _, reason, first in found:
        indices = [index for index, why in reasons.items() if why == reason]
        assert first == ", ".join(map(str, indices[:5]))


def test_a_campaign_that_stopped_early_or_did_not_begin_has_a_page(tmp_path):
    early = Reader(report.page(synthetic.write(tmp_path / "early", 60, early=True, analyses=False))).words
    assert "stopped early" in early
    assert "They hold at all looks at once (a confidence sequence), so stopping early keeps the confidence." in early
    folder = synthetic.write(
        tmp_path / "none", 60, analyses=False, verdicts=[], requirements=[], metrics=[], state="interrupted", files={}
    )
    for part in (folder / "runs").iterdir():
        part.unlink()
    words = Reader(report.page(folder)).words
    assert "interrupted" in words
    assert "no requirements" in words


def test_morris_effects_have_their_table_and_a_grid_is_called_no_draw(tmp_path):
    runs = Analytic(lambda u: 3.0 * u[:, 0] + u[:, 1], [("turn", 0, 2), ("k", 2, 1)])
    found = sensitivity.run(Sensitivity(method="morris", points=10), runs, 1)
    folder = synthetic.write(tmp_path, 60, analyses=False, sensitivity=found, sampling="grid")
    words = Reader(report.page(folder)).words
    assert "30 runs of their own: 10 trajectories." in words
    assert re.search(r"mean effect spread turn [\d.]+ ± [\d.]+ – k 0 ± 0", words)  # a group has no spread
    assert "A full grid is no draw" in words


def test_a_campaign_whose_runs_all_failed_has_a_page(tmp_path):
    folder = synthetic.write(tmp_path, 30, analyses=False, all_fail=True)
    assert "30 runs failed" in Reader(report.page(folder)).words


def test_thinned_out_plots_say_so_and_keep_the_worst_runs(tmp_path):
    folder = synthetic.write(tmp_path, 30000, analyses=False)
    page = report.page(folder)
    assert len(page) < 2e6
    words = Reader(page).words
    found = re.search(r"([\d,]+) of 30,000 runs are drawn: some at random, and the worst of each metric", words)
    assert 2000 <= int(found[1].replace(",", "")) < 2200
    data = data_of(page)
    scatter = next(p for p in data["plots"] if "runs" in p)
    shown = {c["name"]: unpacked(data["arrays"][c["y"]]) for c in scatter["curves"]}
    assert np.nanmax(shown["requirement not met"]) == pytest.approx(
        max(v for v in Rows(folder).numbers("settle") if np.isfinite(v)), rel=1e-6
    )


@pytest.mark.isolate
def test_the_plots_are_drawn_and_a_dot_tells_its_run(chromium: Tab, folder):
    chromium.open(folder / "campaign.html")
    assert pixels(chromium, "#0072b2", 0) > 500
    plot = 6  # the first scatter plot, behind three distributions of two plots each
    assert pixels(chromium, "#0072b2", plot) > 500
    assert pixels(chromium, "#d55e00", plot) > 5
    x, y, w, h = box(chromium, f".plot >> nth={plot} >> .u-over")
    chromium.page.mouse.move(x + w / 2, y + h / 2)
    chromium.settle()
    told = values(chromium, plot)
    run = int(re.search(r"run (\d+)$", told[0])[1])
    rows = Rows(folder)
    assert float(told[0].split(",")[0].replace("\u2212", "-")) == pytest.approx(
        rows.numbers("plant.Q0.q0")[run], rel=1e-3
    )
    assert float(told[1]) == pytest.approx(rows.numbers("settle")[run], rel=1e-3)
    chromium.page.mouse.click(x + w / 2, y + h / 2)
    how = chromium.page.text_content(f".plot >> nth={plot} >> [role=status]") or ""
    assert how.startswith(f"Run {run} as a flight: orchestrate campaign ")
    assert how.endswith(f" --replay {run} --open")
    swatches = (
        "[...document.querySelectorAll('.plot')[0].querySelectorAll('.u-marker')].map(m => "
        "getComputedStyle(m).background)"
    )
    assert len(set(chromium.page.evaluate(swatches))) == 3  # lower bound, upper bound, share
    chromium.resize(390, 800)
    cut = "[...document.querySelectorAll('.scroll')].filter(s => s.scrollWidth > s.clientWidth).length"
    assert chromium.page.evaluate(cut) == 0  # each row is a card
    second = "getComputedStyle(document.querySelector('.named td:nth-child(2)'), '::before').content"
    assert "half of the runs" in chromium.page.evaluate(
        "[...document.querySelectorAll('.named td:nth-child(2)')].map(c => c.dataset.label)"
    )
    assert chromium.page.evaluate(second) != "none"
    chromium.settle()
    assert chromium.page.evaluate("document.documentElement.scrollWidth") <= 390
    assert chromium.complaints == []
    assert chromium.foreign == []


@pytest.mark.isolate
def test_a_click_on_a_run_that_was_flown_again_opens_its_flight(chromium: Tab, folder, tmp_path):
    place = shutil.copytree(folder, tmp_path / "campaign")
    for run in Rows(place).index.tolist():
        (place / f"replay-{run}").mkdir()
        (place / f"replay-{run}" / "report.html").write_text("<!doctype html><title>flight</title>", "utf-8")
    chromium.open(report.write(place))
    assert pixels(chromium, "#0072b2", 6) > 500
    x, y, w, h = box(chromium, ".plot >> nth=6 >> .u-over")
    chromium.page.mouse.move(x + w / 2, y + h / 2)
    chromium.settle()
    run = re.search(r"run (\d+)$", values(chromium, 6)[0])
    assert run
    chromium.page.mouse.click(x + w / 2, y + h / 2)
    chromium.page.wait_for_url(f"**/replay-{run[1]}/report.html")
    assert chromium.page.title() == "flight"


def test_the_console_shows_the_verdicts_in_80_columns(folder, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    manifest = json.loads((folder / "campaign.json").read_text("utf-8"))
    manifest["verdicts"][1] |= {"status": "undecided", "text": "too few"}
    manifest["requirements"][0]["expected"] = "< 1 \x1b[31ms"
    summary(manifest, "it \x1b[31mbroke")
    out = capsys.readouterr().out
    assert all(len(line) <= 80 for line in out.splitlines() if line.startswith(("met", "not met", "undecided", " ")))
    assert "1,000 runs, completed, in 60 s" in out
    assert "9 runs failed and meet no requirement; the first: it \\x1b[31mbroke" in out
    assert re.search(r"met +settles .* 0.9 at 95% +0.988 \(≥ 0.9806,", out)
    assert "points: undecided: too few" in out
    assert "settle: plant.Q0 0.83, rate 0.11" in out
    assert "largest settle of a search with 200 runs: 1159 s; --replay worst flies it" in out
    assert "\x1b[31m" not in out


def test_the_console_shows_what_half_and_nine_tenths_of_the_runs_reach_and_the_worst(folder, capsys):
    manifest = json.loads((folder / "campaign.json").read_text("utf-8"))
    rows = Rows(folder)
    summary(manifest, None, report.metrics_of(rows))
    out = capsys.readouterr().out
    column = manifest["metrics"][0]["column"]
    ordered = np.sort(np.where(np.isnan(rows.numbers(column)), np.inf, rows.numbers(column)))
    told = re.search(rf"^{column} +(\S+) \S+ +(\S+) \S+ +never or failed$", out, re.M)
    assert told
    assert float(told[1]) == pytest.approx(ordered[499], rel=1e-3)  # of 1000
    assert float(told[2]) == pytest.approx(ordered[899], rel=1e-3)
