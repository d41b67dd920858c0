"""The page of a run in a browser."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

from .browser import Tab, box, pixels, values
from .flown import flown
from .swing import EVIL, swing

pytestmark = pytest.mark.isolate


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a run with a scenario that means harm."""
    result = swing(note=EVIL)
    result.manifest = {"evil": EVIL}
    return result.save(tmp_path_factory.mktemp("swing")) / "report.html"


@pytest.fixture
def tab(chromium: Tab, place: Path) -> Tab:
    """The page, opened."""
    chromium.open(place)
    return chromium


@pytest.fixture(scope="module")
def motion(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a body that turns on its orbit."""
    return flown().save(tmp_path_factory.mktemp("flown")) / "report.html"


def test_the_plots_are_drawn_without_a_complaint_or_a_request_and_no_text_of_the_scenario_runs(tab):
    assert tab.page.locator(".plot canvas").count() == 2  # others are in a fold
    assert pixels(tab, "#0072b2", 0) > 500
    assert pixels(tab, "#d55e00", 0) > 500
    assert pixels(tab, "#0072b2", 1) > 500
    tab.page.evaluate("document.querySelector('details.signals').open = true")
    assert pixels(tab, "#0072b2", 2) > 200
    assert (tab.complaints, tab.foreign) == ([], [])
    assert tab.page.evaluate("typeof window.hacked") == "undefined"
    assert EVIL in tab.page.inner_text("body")


def test_a_click_on_a_name_hides_its_curve_and_another_brings_it_back(tab):
    before = pixels(tab, "#d55e00")
    name = tab.page.locator(".plot").first.locator(".u-series th").nth(1)
    for gone in (True, False):
        name.click()
        tab.settle()
        assert (pixels(tab, "#d55e00") < before / 20) == gone
        assert name.get_attribute("aria-pressed") == ("false" if gone else "true")


def test_the_values_under_the_mouse_are_told_with_units_and_the_time_in_cycles(tab):
    assert values(tab) == []  # quiet until used
    x, y, w, h = box(tab, ".u-over")
    tab.page.mouse.move(x + w / 2, y + h / 2)
    tab.settle()
    time, first, second = values(tab)
    assert re.fullmatch(r"(19\.9|20|20\.1) s, 3\.\d+ swings", time)
    t = float(time.split()[0])
    for told, curve in ((first, np.cos), (second, np.sin)):
        number, unit = told.replace("\u2212", "-").split()
        assert float(number) == pytest.approx(np.degrees(np.exp(-t / 20) * curve(t)), rel=1e-3)
        assert unit == "deg"
    assert values(tab, 1)[0] == time  # the plots move together


@pytest.mark.parametrize("width", [1400, 390])
def test_the_values_under_the_mouse_stand_above_the_curves(tab, width):
    tab.resize(width)
    x, y, w, h = box(tab, ".plot .u-over")
    tab.page.mouse.move(x + w / 2, y + h / 2)
    tab.settle()
    ends = "it => it.getBoundingClientRect()"
    told = tab.page.locator(".plot .readout").first.evaluate(ends)
    curves = tab.page.locator(".plot .u-over").first.evaluate(ends)
    assert told["height"] > 0
    assert told["bottom"] <= curves["top"]
    assert 0 <= told["left"] < told["right"] <= width


def test_dragging_and_keys_zoom_and_move_all_plots_until_a_double_click(tab):
    def reach(plot: int = 0) -> float:
        x, y, w, h = box(tab, ".u-over", plot)
        tab.page.mouse.move(x + w - 1, y + h / 2)
        tab.settle()
        return float(values(tab, plot)[0].split()[0])

    assert reach() == pytest.approx(40, abs=0.2)
    x, y, w, h = box(tab, ".u-over")
    tab.page.mouse.move(x + 0.25 * w, y + h / 2)
    tab.page.mouse.down()
    tab.page.mouse.move(x + 0.5 * w, y + h / 2, steps=3)
    tab.page.mouse.up()
    tab.settle()
    assert reach() == pytest.approx(20, abs=0.3)
    assert reach(1) == pytest.approx(20, abs=0.3)
    tab.page.locator(".u-over").first.press("Shift+ArrowRight")  # a tenth of what is shown
    tab.settle()
    assert reach(1) == pytest.approx(21, abs=0.3)
    tab.page.locator(".u-over").first.dblclick()
    tab.settle()
    assert reach(1) == pytest.approx(40, abs=0.2)


def test_it_is_light_on_paper_and_dark_where_that_is_wanted(tab):
    tab.page.emulate_media(color_scheme="dark")
    tab.settle()
    assert tab.page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 23, 27)"
    assert pixels(tab, "#0072b2") < 50 < 500 < pixels(tab, "#4aa3df")
    assert tab.page.pdf().startswith(b"%PDF")
    for event, colour in (("beforeprint", "#0072b2"), ("afterprint", "#4aa3df")):
        tab.page.evaluate(f"window.dispatchEvent(new Event('{event}'))")
        tab.settle()
        assert pixels(tab, colour) > 500
    assert tab.complaints == []


# ---------------------------------------------------------------- in three dimensions

SHOWN = "document.querySelector('[data-part=canvas]').toDataURL()"


def test_the_view_draws_moves_and_turns_and_fits_every_width(chromium, motion):
    chromium.open(motion, 1400)
    page = chromium.page
    page.evaluate("document.querySelectorAll('details:not(.both)').forEach(fold => fold.open = true)")
    slider, field = page.locator("[data-part=slider]"), page.get_by_role("checkbox", name="field")
    for width in (1400, 800, 390):
        chromium.resize(width)
        assert page.evaluate("document.documentElement.scrollWidth") == width
        assert (
            page.evaluate("Math.max(...[...document.querySelectorAll('.plot canvas')].map(c => c.clientWidth))") < width
        )
        assert page.evaluate("document.querySelector('.plot').getBoundingClientRect().top + scrollY") < 900
        slider.fill("0")
        field.check()
        chromium.settle()
        pictures = [page.evaluate(SHOWN)]
        assert len(pictures[0]) > 4000  # a picture of one colour has less
        slider.fill("50")
        chromium.settle()
        pictures.append(page.evaluate(SHOWN))
        assert page.inner_text("[data-part=words]").startswith("50 s; turning; 25 deg from the desired attitude")
        page.locator("[data-part=canvas]").press("ArrowLeft")
        chromium.settle()
        pictures.append(page.evaluate(SHOWN))
        field.uncheck()
        chromium.settle()
        pictures.append(page.evaluate(SHOWN))
        assert len(set(pictures)) == 4
        slider.fill("40")
        page.locator(".plot").first.evaluate("it => it.scrollIntoView({ block: 'center' })")  # others are drawn now
        chromium.settle()
        assert values(chromium)[0].startswith("40 s")  # the plots' cursor is there, too
    assert (chromium.complaints, chromium.foreign) == ([], [])


def test_no_frame_shows_labels_without_the_view_when_the_size_changes(chromium, motion):
    chromium.open(motion, 1400)
    page = chromium.page
    page.evaluate(
        """window.blank = []; new ResizeObserver(() => {  // called after the page's own, before the frame is shown
          const { width, height } = document.querySelector('[data-part=canvas]');
          const copy = new OffscreenCanvas(width, height).getContext('2d');
          copy.drawImage(document.querySelector('[data-part=canvas]'), 0, 0);
          blank.push(copy.getImageData(0, 0, width, height).data.every(value => value === 0));
        }).observe(document.querySelector('[data-part=stage]')); 0"""
    )
    chromium.settle()
    chromium.resize(800)
    assert page.evaluate("window.blank") == [False, False]


def test_labels_of_the_view_stand_on_no_other_and_not_beyond_its_edge(chromium, motion):
    """All its vectors are shown at once, at an instant at which some of them point the same way."""
    chromium.open(motion, 390)
    page = chromium.page
    page.evaluate("document.querySelectorAll('[data-part=vectors] input').forEach(box => box.checked || box.click())")
    page.locator("[data-part=slider]").fill("0")
    chromium.settle()
    stage, *boxes = page.evaluate(
        """[document.querySelector('[data-part=stage]'), ...document.querySelectorAll('.tag:not([hidden])')].map(it => {
          const { left, right, top, bottom } = it.getBoundingClientRect();
          return [left, right, top, bottom];
        })"""
    )
    assert len(boxes) > 5
    for i, (left, right, top, bottom) in enumerate(boxes):
        assert stage[0] - 2 <= left <= right <= stage[1] + 2
        assert stage[2] <= top <= bottom <= stage[3]
        for other in boxes[:i]:
            assert right <= other[0] or other[1] <= left or bottom <= other[2] + 1 or other[3] <= top + 1


def test_plots_are_drawn_when_they_come_near_the_screen_and_all_of_them_on_paper(tab):
    drawn = "document.querySelectorAll('.plot canvas').length"
    tab.page.evaluate("document.querySelectorAll('details').forEach(fold => fold.open = true)")
    tab.resize(1366, 200)
    tab.page.reload()
    tab.page.locator(".plot").first.scroll_into_view_if_needed()  # inputs stand before them
    tab.settle()
    few, every = tab.page.evaluate(drawn), tab.page.locator(".plot").count()
    assert 0 < few < every
    tab.page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert tab.page.evaluate("[...document.querySelectorAll('main > section > details.paper')].length") == 0
    assert tab.page.evaluate(drawn) == every - tab.page.locator("details:not([open]) .plot").count()
    tab.page.evaluate("window.dispatchEvent(new Event('afterprint'))")


def test_the_view_plays_and_follows_the_cursor_of_a_plot(chromium, motion):
    chromium.open(motion)
    page = chromium.page
    page.click("[data-part=play]")
    chromium.until("Number(document.querySelector('[data-part=slider]').value) > 1")
    page.click("[data-part=play]")
    x, y, w, h = box(chromium, ".u-over")
    page.mouse.move(x + w / 4, y + h / 2)
    chromium.settle()
    assert float(page.input_value("[data-part=slider]")) == pytest.approx(25, abs=0.5)
    assert page.locator("[data-part=marks] .phase").all_inner_texts() == ["turning", "resting"]
    assert page.locator("[data-part=marks] .fault").count() == 1
    told = page.get_attribute("[data-part=canvas]", "aria-label") or ""
    at, angle = (float(number) for number in re.findall(r"([\d.]+) (?:s|deg)", told))
    assert angle == pytest.approx(0.5 * at, abs=0.06)  # half a degree a second


def test_the_flight_stands_at_six_instants_below_the_view(chromium, motion):
    chromium.open(motion)
    fold = chromium.page.locator("[data-part=both]")
    assert fold.locator("summary").inner_text() == "The flight at 6 instants"
    fold.evaluate("it => { it.open = true; }")
    chromium.until("document.querySelectorAll('[data-part=strip] canvas').length === 6")
    told = fold.locator("[data-part=strip] div").all_inner_texts()
    assert told == [f"{t} s, {t // 2} deg off" for t in (0, 20, 40, 60, 80, 100)]  # half a degree a second
    assert len(set(fold.locator("canvas").evaluate_all("all => all.map(it => it.toDataURL())"))) == 6


def test_on_paper_the_view_is_a_still_picture_with_its_labels_on_it(chromium, motion):
    chromium.open(motion, 390)
    page = chromium.page
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    still = page.locator(".still")
    assert still.evaluate("it => [it.width, it.height]") == [960, 570]  # 640 x 380 px of the page
    assert len(still.evaluate("it => it.toDataURL()")) > 4000  # a picture of one colour has less
    places = page.evaluate("[...document.querySelectorAll('.tag:not([hidden])')].map(tag => tag.style.transform)")
    across = [float(re.search(r"translate\(([\d.]+)px", place)[1]) for place in places]
    assert 320.0 in across  # the axis that stands upright is in the middle of the paper's width
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert still.count() == 0
    assert chromium.complaints == []


def test_a_view_whose_context_the_browser_takes_away_is_drawn_again(chromium, motion):
    report = chromium
    report.open(motion)
    lit = """(() => {
      const { width, height } = document.querySelector("[data-part=canvas]");
      const copy = new OffscreenCanvas(width, height).getContext("2d");
      copy.drawImage(document.querySelector("[data-part=canvas]"), 0, 0);
      return copy.getImageData(0, 0, width, height).data.filter((v, i) => i % 4 === 3 && v).length;
    })()"""
    before = report.page.evaluate(lit)
    assert before > 10_000
    report.page.evaluate("""(() => {
      const gl = document.querySelector("[data-part=canvas]").getContext("webgl2");
      window.lost = document.querySelector("[data-part=canvas]");
      gl.getExtension("WEBGL_lose_context").loseContext();
    })()""")
    report.until("window.lost !== document.querySelector('[data-part=canvas]')")
    report.settle()
    assert abs(report.page.evaluate(lit) - before) < 0.1 * before


def test_headings_go_down_by_one_and_what_scrolls_can_be_reached_by_keys(tab):
    tab.page.evaluate("document.querySelectorAll('details').forEach((it) => { it.open = true; })")
    levels = tab.page.evaluate("[...document.querySelectorAll('h1, h2, h3, h4')].map((it) => Number(it.tagName[1]))")
    assert levels[0] == 1
    assert all(after <= before + 1 for before, after in itertools.pairwise(levels))
    assert (
        tab.page.evaluate(
            "[...document.querySelectorAll('pre, .scroll')].filter((it) => it.tabIndex < 0"
            " && it.scrollWidth > it.clientWidth).length"
        )
        == 0
    )
    assert tab.page.evaluate("[...document.querySelectorAll('th')].filter((it) => !it.textContent.trim()).length") == 0
