"""The page of a run: what it says, and that it lets nothing in or out."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from orchestration import load, run
from orchestration.quantities import parse_unit
from orchestration.results import html, report
from orchestration.results.inputs import inputs

from ..mocks import Mock, model
from .swing import EVIL, Reader, data_of, swing, unpacked

# ---------------------------------------------------------------- what it says


def test_every_run_leaves_a_page_that_says_what_came_of_it(tmp_path):
    result = swing()
    result.warnings.append("mind the gap")
    page = Reader((result.save(tmp_path) / "report.html").read_text("utf-8"))
    for said in (
        "1 of 2 expectations failed",
        "stays below 2 swings & settles",
        "always < 2 rad",
        "always within 0.5 rad",
        "running values held from 3.1 s to 6 s, then released",
        "a.u = 1, from 8 s to 9 s",
        "mind the gap",
        "a.on from 3.1 s to 6 s",
        "shaded: a.on is true",
        "red: a fault acts",
        "a.y = 0 at 1.57 s, 4.71 s",
        "dashed: limits",
        "a.still 7.25",
    ):
        assert said in page.words, said
    assert len([e for e in page.elements if "data-plot" in e[1]]) == 4  # two panels, a.on and a.t


def test_the_verdict_is_that_of_the_run():
    assert "the expectation is met" in report.page(
        swing(expect=[{"name": "n", "signal": "a.x", "always": {"below": 2}}])
    )
    assert "completed; it has no expectations" in report.page(swing(expect=[]))
    stopped = swing(expect=[])
    stopped.interrupted = 2
    assert "interrupted after 40 s" in report.page(stopped)


def test_a_run_that_failed_at_once_has_a_page_without_plots(tmp_path):
    result = swing()
    result.failure = Mock("a", model("a"), lambda block: None).fail("fmi2DoStep")
    result.time, result.samples, result.holds, result.highlights = result.time[:0], result.samples[:0], [], []
    result.reached = 0.0
    page = Reader((result.save(tmp_path) / "report.html").read_text("utf-8"))
    assert "failed after 0 s" in page.words
    assert "this is why" in page.words
    assert not [e for e in page.elements if "data-plot" in e[1]]


def test_without_figures_what_expectations_look_at_is_drawn_with_its_bounds():
    data = data_of(report.page(swing(figures=[])))
    x = next(plot for plot in data["plots"] if plot["label"].startswith("x"))
    assert [curve["name"] for curve in x["curves"]] == ["x[1]", "x[2]", "|x|"]
    assert x["lines"] == [2.0, -0.5, 0.5]
    assert x["shade"] == [[pytest.approx(3.1), pytest.approx(6.0)]]


@pytest.mark.parametrize("figures", [{"figures": []}, {}])
def test_a_signal_that_no_figure_shows_is_drawn_with_its_bounds_in_its_display_unit(figures):
    result = swing(expect=[{"name": "n", "signal": "a.t", "always": {"below": 90}}], **figures)
    block = result.models["a"]
    unit = {"unit": parse_unit("rad"), "display_unit": parse_unit("deg")}
    block.variables.update({name: replace(block.variables[name], **unit) for name in ("t", "still")})
    text = report.page(result)
    data = data_of(text)
    shown = next(plot for plot in data["plots"] if plot["label"] == "t, deg")
    last = unpacked(data["arrays"][shown["curves"][0]["y"]])[-1]
    assert last == pytest.approx(np.degrees(result["a.t"][-1]), rel=1e-6)
    assert shown["lines"] == [pytest.approx(np.degrees(90.0))]
    assert "a.still 415.394 deg" in Reader(text).words, "7.25 rad"


def test_the_numbers_of_a_panel_are_in_its_unit():
    result = swing()
    data = data_of(report.page(result))
    panel = data["plots"][0]
    assert panel["label"].endswith(", deg")
    assert panel["lines"] == [90.0]
    np.testing.assert_allclose(unpacked(data["arrays"][panel["x"]]), result.time, rtol=1e-7)
    shown = unpacked(data["arrays"][panel["curves"][1]["y"]])
    np.testing.assert_allclose(shown, np.degrees(result["a.x"][:, 1]), rtol=1e-7, atol=1e-12)
    assert data["cycle"] == {"name": "swings", "period": 6.283}
    assert data["faults"] == [[8.0, 9.0]]


def test_the_legend_says_what_the_lines_of_a_panel_are():
    panels = [{"signals": ["a.x"], "lines": [1], "lines_are": "true values"}]
    words = Reader(report.page(swing(figures=[{"name": "f", "panels": panels}]))).words
    assert "dashed: true values" in words
    assert "dashed: limits" not in words


# ---------------------------------------------------------------- nothing gets in or out


def test_the_page_is_well_formed_and_asks_for_nothing():
    text = report.page(swing())
    page = Reader(text)
    for tag, attributes in page.elements:
        for name in ("src", "href", "srcset", "data", "action", "poster"):
            assert (attributes.get(name) or "data:").startswith("data:"), (tag, attributes)
        assert not [name for name in attributes if name.startswith("on")], (tag, attributes)
    style = "".join(re.findall(r"<style>(.*?)</style>", text, re.DOTALL))
    assert "@import" not in style
    assert "url(" not in style
    policy = next(a["content"] for _, a in page.elements if a.get("http-equiv") == "Content-Security-Policy")
    assert (policy or "").startswith("default-src 'none'")


def test_no_text_of_a_scenario_becomes_html_or_script():
    text = report.page(swing(note=EVIL))
    harmless = report.page(swing(note="harmless"))
    count = lambda page: [tag for tag, _ in Reader(page).elements]  # noqa: E731
    assert count(text) == count(harmless)
    assert "<img" not in text
    assert EVIL in Reader(text).words
    assert data_of(text)["plots"][0]["curves"][1]["name"] == EVIL


@pytest.mark.parametrize("value", ["</script>", "<!--", "<script>", "\u2028", "]]>", "\ud800"])
def test_json_in_the_page_reads_back_and_ends_no_element(value):
    text = html.embedded({"x": value})
    assert "<" not in text
    assert text.isascii()
    assert json.loads(text) == {"x": value}


def test_what_is_no_number_is_a_gap():
    result = swing()
    column = result.labels.index("a.t")
    result.samples[100:103, column] = np.nan, np.inf, -np.inf
    data = data_of(report.page(result))
    plot = next(plot for plot in data["plots"] if plot["label"] == "t")
    values = unpacked(data["arrays"][plot["curves"][0]["y"]])
    assert np.flatnonzero(np.isnan(values)).tolist() == [100, 101, 102]


# ---------------------------------------------------------------- it never costs the results


def test_where_the_page_cannot_be_made_the_results_stand(tmp_path, monkeypatch):
    swing().save(tmp_path)
    monkeypatch.setattr(report, "page", lambda result, files: 1 / 0)
    result = swing()
    result.save(tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {"signals.csv", "manifest.json", "expectations.json"}
    assert any("report.html cannot be written: ZeroDivisionError" in warning for warning in result.warnings)


def test_the_report_begins_with_what_the_scenario_states():
    stated = Reader(str(inputs(load("scenarios/minimal.yaml")))).words
    assert "plant.omega_B0 [2 deg/s, -3 deg/s, 1 deg/s]" in stated
    assert "J_B" not in stated  # the FMU's own
    page = report.page(run("scenarios/minimal.yaml", duration="5 s"))
    assert page.index("<h2>Inputs</h2>") < page.index("data-plot") < page.index("<h2>Expectations</h2>")
