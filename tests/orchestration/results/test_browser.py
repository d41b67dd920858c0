"""The page of a run in a browser."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from .browser import Browser, box, pixels, values
from .swing import EVIL, swing


@pytest.fixture
def page(chromium: Browser, tmp_path: Path) -> Browser:
    """The page of a run with a scenario that means harm, opened."""
    chromium.call("Emulation.setEmulatedMedia", features=[])
    chromium.call("Emulation.clearDeviceMetricsOverride")
    result = swing(note=EVIL)
    result.manifest = {"evil": EVIL}
    chromium.complaints.clear()
    chromium.requests.clear()
    chromium.open(result.save(tmp_path) / "report.html")
    chromium.settle()
    return chromium


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


def test_on_a_phone_nothing_stands_out_at_the_side(page):
    page.call("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=1, mobile=True)
    page.evaluate("document.querySelectorAll('details').forEach(fold => fold.open = true)")
    page.settle()
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    assert page.evaluate("Math.max(...[...document.querySelectorAll('.plot canvas')].map(c => c.clientWidth))") < 390
