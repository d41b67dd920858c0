"""The page of a run: what it says, that it lets nothing in or out, and that a browser draws it."""

from __future__ import annotations

import base64
import json
import os
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestration.quantities import parse_unit
from orchestration.results import arrays, html, report
from orchestration.results.result import Result

from ..mocks import Mock, model, real
from ..mocks import run as run_mocks
from . import browser

EVIL = "</script><script>window.hacked=1</script><img src=x onerror=window.hacked=1>\"'&"
VOID = {"meta", "link"}


def swing(steps: int = 400, note: str = "swings & settles", **more: Any) -> Result:
    """A run of one block: a decaying swing in two axes, a flag while it is large, and a signal that changes its sign."""

    def evaluate(block: Mock) -> None:
        t = block.state
        x = [np.exp(-t / 20) * np.cos(t), np.exp(-t / 20) * np.sin(t)]
        for element, value in zip(block.model.variables["x"].elements, x, strict=True):
            block.values[element] = value
        block["y"], block["on"], block["still"], block["t"] = x[0], 3 < t < 6, 7.25, t

    def advance(block: Mock, time: float, step: float) -> None:
        block.state = time + step

    signals = (
        real("x", "output", shape=(2,), unit=parse_unit("rad"), description=note),
        real("y", "output"),
        real("on", "output", type="boolean"),
        real("still", "output"),
        real("t", "output"),
        real("u", "input", variability="tunable"),
    )
    scenario = {
        "description": note,
        "step": 0.1,
        "duration": 0.1 * steps,
        "cycle": {"name": "swings", "period": 6.283},
        "expect": [
            {"name": f"stays below 2 {note}", "signal": "a.x", "always": {"below": "2 rad"}},
            {"name": "norm", "signal": "a.x", "measure": "norm", "always": {"within": 0.5}},
        ],
        "holds": [{"name": f"hold {note}", "signal": "a.on", "keeps": ["a.still"]}],
        "faults": [{"at": 8, "until": 9, "set": "a.u = 1"}],
        "figures": [
            {
                "name": "swing",
                "title": f"Swing {note}",
                "shade": "a.on",
                "mark": "a.y",
                "panels": [
                    {
                        "signals": ["a.x"],
                        "unit": "deg",
                        "label": f"x {note}",
                        "names": ["one", note],
                        "lines": ["90 deg"],
                    },
                    {"signals": ["a.y"]},
                ],
            },
        ],
        **more,
    }
    return run_mocks([Mock("a", model("a", *signals), evaluate, advance, 0.0)], scenario, start={"a": {"u": 0}})


class Reader(HTMLParser):
    """The elements of a page; what is not closed as it was opened is an error."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self._open: list[str] = []
        self.feed(text)
        self.close()
        assert not self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] not in ("script", "style"):
            self.text.append(data)

    @property
    def words(self) -> str:
        return " ".join(" ".join(self.text).split())


def data_of(page: str) -> dict[str, Any]:
    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert found
    return json.loads(found[1], parse_constant=refuse)


def unpacked(array: dict[str, str]) -> np.ndarray:
    kind = {"u1": "<u1", "f4": "<f4", "f8": "<f8"}[array["type"]]
    return np.frombuffer(base64.b64decode(array["data"]), kind).astype(float)


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
        "a.on first at 3.1 s",
        "shaded: a.on",
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


# ---------------------------------------------------------------- thinning out, packing


def test_of_a_long_run_few_rows_stay_and_every_spike():
    generator = np.random.default_rng(1)
    values = generator.normal(size=(200_003, 3))
    spikes = [(3, 0, 50.0), (77_777, 1, -60.0), (200_001, 2, 70.0)]
    for row, column, value in spikes:
        values[row, column] = value
    rows = arrays.kept(values, 5000)
    assert 3000 < len(rows) <= 5200
    assert {0, 200_002, 3, 77_777, 200_001} <= set(rows.tolist())
    assert (np.diff(rows) > 0).all()


def test_a_short_run_is_shown_whole():
    assert len(arrays.kept(np.zeros((5000, 4)), 5000)) == 5000


def test_gaps_survive_thinning_out():
    values = np.zeros((100_000, 1))
    values[54_321] = np.nan
    assert 54_321 in arrays.kept(values, 1000)


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        (np.array([0.0, 1.0, -3.5]), "f4"),
        (np.array([1000.0, 1000.0001]), "f8"),
        (np.array([True, False]), "u1"),
        (np.array([np.nan, np.inf, 1e300, 2.0]), "f4"),
        (np.array([5e-324, 0.0]), "f4"),
        (np.array([np.nan]), "f4"),
    ],
)
def test_numbers_take_as_few_bytes_as_a_plot_allows(values, kind):
    packed = arrays.Arrays()
    assert packed.add(values) == packed.add(values.copy()) == 0
    assert packed.items[0]["type"] == kind
    back, drawn = unpacked(packed.items[0]), np.abs(values.astype(float)) <= 1e30
    assert np.isnan(back[~drawn]).all()
    np.testing.assert_allclose(back[drawn], values[drawn].astype(float), rtol=1e-7, atol=1e-30)


def test_spans_too_many_to_see_are_joined():
    spans = [(float(i), i + 0.5) for i in range(100_000)]
    few = arrays.few(spans)
    assert len(few) <= arrays.MARKS + 1
    assert (few[0][0], few[-1][1]) == (0.0, 99_999.5)


# ---------------------------------------------------------------- it never costs the results


def test_where_the_page_cannot_be_made_the_results_stand(tmp_path, monkeypatch):
    swing().save(tmp_path)
    monkeypatch.setattr(report, "page", lambda result: 1 / 0)
    result = swing()
    result.save(tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {"signals.csv", "manifest.json", "expectations.json"}
    assert any("report.html cannot be written: ZeroDivisionError" in warning for warning in result.warnings)


# ---------------------------------------------------------------- in a browser


@pytest.fixture(scope="module")
def chromium() -> Iterator[browser.Browser]:
    path = browser.executable()
    if path is None:
        if os.environ.get("CI"):
            pytest.fail("no Chromium; .ci/run installs it")
        pytest.skip("no Chromium on this machine (Debian: apt-get install chromium)")
    with browser.Browser(path) as found:
        yield found


@pytest.fixture
def page(chromium: browser.Browser, tmp_path: Path) -> browser.Browser:
    """The page of a run with a scenario that means harm, opened."""
    chromium.call("Emulation.setEmulatedMedia", features=[])
    result = swing(note=EVIL)
    result.manifest = {"evil": EVIL}
    chromium.complaints.clear()
    chromium.requests.clear()
    chromium.open(result.save(tmp_path) / "report.html")
    chromium.settle()
    return chromium


def pixels(page: browser.Browser, colour: str, plot: int = 0) -> int:
    """How many points of a plot have about this colour."""
    rgb = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return page.evaluate(
        f"""(() => {{
          const canvas = document.querySelectorAll(".plot canvas")[{plot}], {{ width, height }} = canvas;
          const copy = new OffscreenCanvas(width, height).getContext("2d", {{ willReadFrequently: true }});
          copy.drawImage(canvas, 0, 0);
          const {{ data }} = copy.getImageData(0, 0, width, height);
          let found = 0;
          for (let i = 0; i < data.length; i += 4)
            found += data[i + 3] > 128 && {json.dumps(rgb)}.every((c, k) => Math.abs(c - data[i + k]) < 24);
          return found;
        }})()"""
    )


def box(page: browser.Browser, selector: str, place: int = 0) -> list[float]:
    """Left, top, width and height of an element that has been brought into view."""
    return page.evaluate(
        f"""(() => {{
          const it = document.querySelectorAll({json.dumps(selector)})[{place}];
          it.scrollIntoView({{ block: "center" }});
          const r = it.getBoundingClientRect();
          return [r.x, r.y, r.width, r.height];
        }})()"""
    )


def values(page: browser.Browser, plot: int = 0) -> list[str]:
    cells = f"[...document.querySelectorAll('.plot')[{plot}].querySelectorAll('.u-value')]"
    return page.evaluate(f"{cells}.map(cell => cell.textContent)")


def test_the_plots_are_drawn_without_a_complaint_or_a_request(page):
    assert page.evaluate("document.querySelectorAll('.plot canvas').length") == 2  # others are in a fold
    assert pixels(page, "#0072b2", 0) > 500
    assert pixels(page, "#d55e00", 0) > 500
    assert pixels(page, "#0072b2", 1) > 500
    page.evaluate("document.querySelector('details.signals').open = true")
    page.evaluate("new Promise(done => setTimeout(done, 100))")
    page.settle()
    assert pixels(page, "#0072b2", 2) > 200
    assert page.complaints == []
    assert [r for r in page.requests if not r.startswith("data:") and not r.endswith("/report.html")] == []


def test_no_text_of_the_scenario_runs(page):
    assert page.evaluate("typeof window.hacked") == "undefined"
    assert EVIL in page.evaluate("document.body.innerText")


def test_a_click_on_a_name_hides_its_curve_and_another_brings_it_back(page):
    before = pixels(page, "#d55e00")
    x, y, w, h = box(page, ".plot .u-series th", 2)
    for gone in (True, False):
        page.mouse("mousePressed", x + w / 2, y + h / 2, 1)
        page.mouse("mouseReleased", x + w / 2, y + h / 2)
        page.settle()
        assert (pixels(page, "#d55e00") < before / 20) == gone
        pressed = page.evaluate("document.querySelectorAll('.plot .u-series th')[2].getAttribute('aria-pressed')")
        assert pressed == ("false" if gone else "true")


def test_the_values_under_the_mouse_are_told_with_the_time_in_cycles(page):
    x, y, w, h = box(page, ".u-over")
    page.mouse("mouseMoved", x + w / 2, y + h / 2)
    page.settle()
    time, first, second = values(page)
    assert re.fullmatch(r"(19\.9|20|20\.1) s, 3\.\d+ swings", time)
    t = float(time.split()[0])
    for told, curve in ((first, np.cos), (second, np.sin)):
        assert float(told.replace("\u2212", "-")) == pytest.approx(np.degrees(np.exp(-t / 20) * curve(t)), rel=1e-3)
    assert values(page, 1)[0] == time  # the plots move together


def test_dragging_zooms_and_a_double_click_shows_all_again(page):
    def reach() -> float:
        x, y, w, h = box(page, ".u-over")
        page.mouse("mouseMoved", x + w - 1, y + h / 2)
        page.settle()
        return float(values(page)[0].split()[0])

    assert reach() == pytest.approx(40, abs=0.2)
    x, y, w, h = box(page, ".u-over")
    page.drag(x + 0.25 * w, x + 0.5 * w, y + h / 2)
    page.settle()
    assert reach() == pytest.approx(20, abs=0.3)
    for clicks in (1, 2):
        page.mouse("mousePressed", x + w / 2, y + h / 2, 1, clicks)
        page.mouse("mouseReleased", x + w / 2, y + h / 2, 0, clicks)
    page.settle()
    assert reach() == pytest.approx(40, abs=0.2)


def test_it_is_light_on_paper_and_dark_where_that_is_wanted(page, tmp_path):
    page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    page.settle()
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 23, 27)"
    assert pixels(page, "#0072b2") < 50 < 500 < pixels(page, "#4aa3df")
    page.print(tmp_path / "page.pdf")
    assert (tmp_path / "page.pdf").read_bytes().startswith(b"%PDF")
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    page.settle()
    assert pixels(page, "#0072b2") > 500
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    page.settle()
    assert pixels(page, "#4aa3df") > 500
    assert page.complaints == []
