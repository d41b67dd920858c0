"""The page that `orchestrate live` makes: it flies in a browser what the native run flies, to the last bit."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from orchestration import run
from orchestration.cli.main import main
from orchestration.results import whole
from orchestration.session.read import load
from tests.orchestration.results.browser import Tab, box
from tests.orchestration.results.test_place import full

from .drawn import flown, move, native, paused, saved, trials, verdicts
from .test_system import minimal

pytestmark = pytest.mark.compile

ROOT = Path(__file__).parents[3]
SETS = {
    "as the scenario has it": ({}, ()),
    "turned and tumbling": ({0: 140.0, 1: 8.0}, ()),
    "another gain and orbit": ({2: 0.008, 3: 51.6}, ()),
    "a dead rod and a frozen field": ({4: 0.5}, (0, 1)),
    "a lost command while it turns": ({0: 30.0}, (2,)),
}
"""Five sets of parameters of V.B: positions of the sliders by number, and the faults that are injected."""
SHOWN = "document.querySelector('[data-part=canvas]').toDataURL()"
COLOURS = """(() => {
  const canvas = document.querySelector("[data-part=canvas]"), { width, height } = canvas;
  const copy = new OffscreenCanvas(width, height).getContext("2d");
  copy.drawImage(canvas, 0, 0);
  return new Set(new Uint32Array(copy.getImageData(0, 0, width, height).data.buffer)).size;
})()"""
"""How many colours the view has; an empty one has one."""
STATES = """window.states = [];
new MutationObserver((changes) => states.push(...changes.map((change) => change.oldValue))).observe(
  document.documentElement, {attributeFilter: ["data-state"], attributeOldValue: true}); 0"""
"""From now on, `states` has each state that the page was in before another."""


def made(folder: Path, name: str) -> Path:
    """The live page of a scenario, beside its folder."""
    target = folder / f"{name}.html"
    given = ["live", str(folder / "scenarios" / f"{name}.yaml"), "--out", str(target)]
    done = CliRunner().invoke(main, given, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return target


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The scenarios, and the live page of V.B beside them."""
    folder = tmp_path_factory.mktemp("live")
    shutil.copytree(ROOT / "scenarios", folder / "scenarios")
    made(folder, "paper_no_singularity").rename(folder / "vb.html")
    return folder


@pytest.fixture(scope="module")
def opened(chromium: Tab, folder: Path) -> Tab:
    chromium.open(folder / "vb.html", 1400)
    return chromium


@pytest.fixture
def page(opened: Tab) -> Iterator[Tab]:
    """The page at the scenario's own values, at the start."""
    opened.page.click("#reset")
    opened.page.locator("[data-part=slider]").fill("0")
    flown(opened)
    yield opened
    paused(opened)


@pytest.fixture
def unbounded(page: Tab) -> Iterator[Tab]:
    """The page with a slider for hold_fraction that takes -1, as the scenario's one does not."""
    least = page.page.evaluate("document.querySelector('[data-control=\"4\"]').min")
    page.page.evaluate("document.querySelector('[data-control=\"4\"]').min = -1")
    yield page
    page.page.evaluate("least => { document.querySelector('[data-control=\"4\"]').min = least }", least)


@pytest.fixture
def elsewhere(opened: Tab, folder: Path) -> Iterator[Tab]:
    """The tab for another page; it has V.B again afterwards."""
    yield opened
    opened.open(folder / "vb.html", 1400)
    paused(opened)


def test_five_sets_of_parameters_have_the_hash_of_the_native_run(page, folder):
    seen = set()
    for name, (sliders, faults) in SETS.items():
        page.page.click("#reset")
        for number in faults:
            page.page.click(f"[data-fault='{number}']")
        if sliders:
            move(page, sliders)
        own = flown(page)["hash"]
        assert own == run(saved(page, folder / "scenarios")).sha256, name
        seen.add(own)
    assert len(seen) == len(SETS)
    assert page.complaints == []


@pytest.mark.thorough
def test_twenty_random_settings_have_the_hash_and_verdicts_of_the_native_run(page, folder):
    assert len(trials(page, folder / "scenarios", 20, np.random.default_rng(1))) == 20


EACH = sorted(file.stem for file in (ROOT / "scenarios").glob("*.yaml"))


@pytest.mark.thorough
@pytest.mark.parametrize("name", EACH)
def test_each_scenario_flies_in_its_page_to_the_native_bits_and_verdicts(elsewhere, folder, name):
    target = made(folder, name)
    assert target.stat().st_size <= 2_500_000
    elsewhere.open(target, 1400)
    elsewhere.until("document.documentElement.dataset.state === 'shown'", 500)
    said = elsewhere.page.evaluate("({...document.documentElement.dataset})")
    result = run(folder / "scenarios" / f"{name}.yaml")
    assert said["hash"] == result.sha256
    assert verdicts(said) == native(result.outcomes)
    assert elsewhere.complaints == []


@pytest.mark.thorough
def test_faults_that_overlap_on_one_element_and_a_timeline_below_them_have_the_hash_of_the_native_run(
    elsewhere, tmp_path
):
    own = [
        {"set": "plant.rod_gain[1] = 0", "at": 2, "until": 6},
        {"set": "plant.rod_gain[1] = 0.5", "at": 4, "until": 8},
    ]
    added = [
        {"name": "all rods weak", "set": "plant.rod_gain = [0.7, 0.8, 0.9]", "at": 3, "until": 7},
        {"name": "the same again", "set": "plant.rod_gain[1] = 0", "at": 2, "until": 6},
        {"name": "the second for good", "set": "plant.rod_gain[2] = 0.3", "at": 5},
        {"name": "the second for a time", "set": "plant.rod_gain[2] = 0.2", "at": 6, "until": 9},
    ]
    start = {"dipole_cmd": [5, 6, 7], "wheel_torque_cmd": 0}
    plant = {"fmu": "plant", "every": 2, "start": start}
    timeline = [{"at": at, "set": {"plant.rod_gain[1]": value}} for at, value in ((1, 0.9), (5, 0.8), (10, 0.6))]
    data = minimal(
        step=0.5, duration=12, blocks={"plant": plant}, faults=own, live={"faults": added}, timeline=timeline
    )
    scenario, page = tmp_path / "overlap.yaml", tmp_path / "overlap.html"
    scenario.write_text(json.dumps(data), "utf-8")
    done = CliRunner().invoke(main, ["live", str(scenario), "--out", str(page)], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    elsewhere.open(page, 1400)
    seen = {flown(elsewhere)["hash"]}
    assert seen == {run(scenario).sha256}
    for pressed in range(len(own), len(own) + len(added)):
        elsewhere.page.click(f"[data-fault='{pressed}']")
        hash_ = flown(elsewhere)["hash"]
        assert hash_ == run(saved(elsewhere, tmp_path)).sha256, pressed
        seen.add(hash_)
    assert len(seen) == len(added)  # the same fault a second time changes nothing


def test_the_verdict_of_each_expectation_is_that_of_the_native_run_whatever_the_sliders_say(page, folder):
    for sliders, faults in (({}, ()), ({0: 140.0, 1: 8.0}, (0,)), ({4: 0.5}, (0, 1))):
        page.page.click("#reset")
        for number in faults:
            page.page.click(f"[data-fault='{number}']")
        move(page, sliders)
        said, outcomes = flown(page), run(saved(page, folder / "scenarios")).outcomes
        assert verdicts(said) == native(outcomes)
        unmet = sum(o.status != "met" for o in outcomes)
        shown = page.page.text_content("#verdict") or ""
        assert shown == (
            f"{unmet} of {len(outcomes)} expectations not met" if unmet else f"all {len(outcomes)} expectations met"
        )


def test_a_fault_is_injected_at_the_instant_that_is_shown(page, folder):
    page.page.locator("[data-part=slider]").fill("200.05")
    page.page.click("[data-now='0']")
    hash_ = flown(page)["hash"]
    scenario = saved(page, folder / "scenarios")
    (fault,) = load(scenario).faults
    assert (fault.at, str(fault.set)) == (200.1, "plant.rod_gain[1] = 0")  # the next step
    assert run(scenario).sha256 == hash_
    page.page.fill("[data-at='1']", "300")
    page.page.press("[data-at='1']", "Enter")
    hash_ = flown(page)["hash"]
    scenario = saved(page, folder / "scenarios")
    assert [(fault.at, fault.until) for fault in load(scenario).faults] == [(200.1, None), (300.0, 360.0)]
    assert run(scenario).sha256 == hash_


def test_a_link_carries_what_was_changed_and_undo_takes_it_back(page, folder):
    first = flown(page)["hash"]
    page.page.fill("[data-typed='0']", "140")
    page.page.press("[data-typed='0']", "Enter")
    turned = flown(page)["hash"]
    page.page.click("[data-fault='2']")
    both = flown(page)["hash"]
    address = "#plant.Q0=140&fault3=100"
    page.until(f"location.hash === {address!r}")
    page.page.click("#undo")
    assert flown(page)["hash"] == turned
    page.page.keyboard.press("Control+z")
    assert flown(page)["hash"] == first
    page.page.evaluate(f"location.hash = {address!r}")
    page.until("document.documentElement.dataset.hash === " + repr(both))


@pytest.mark.parametrize(
    ("given", "said", "taken"),
    [
        ("plant.Q0=1e308", "plant.Q0=1e308 (175 is taken)", "#plant.Q0=175"),
        ("plant.Q0=NaN&fault1=&fault2=soon&x=1", "plant.Q0=NaN, fault1=, fault2=soon, x=1", ""),
        ("fault1=1e300&fault2=-1", "fault1=1e300 (386 is taken), fault2=-1 (0 is taken)", "#fault1=386&fault2=0"),
    ],
)
def test_what_an_address_has_that_the_page_cannot_take_is_said_and_does_nothing(page, given, said, taken):
    page.page.evaluate(f"location.hash = {given!r}")
    page.until(f"document.querySelector('#address').textContent.endsWith(': ' + {said!r})")
    page.until(f"location.hash === {taken!r}")
    assert flown(page)["state"] == "shown"
    assert page.complaints == []


def test_the_flight_before_stays_as_a_ghost_until_the_next_change(page):
    before = page.page.evaluate(SHOWN)
    move(page, {0: 30.0})
    flown(page)
    assert not page.page.evaluate("document.querySelector('[data-part=before]').closest('label').hidden")
    with_ghost = page.page.evaluate(SHOWN)
    page.page.evaluate("document.querySelector('[data-part=before]').click()")
    page.settle()
    assert len({before, with_ghost, page.page.evaluate(SHOWN)}) == 3
    page.page.evaluate("document.querySelector('[data-part=before]').click()")


def test_it_moves_within_a_second_of_opening_but_for_those_who_want_less_motion(elsewhere, folder):
    elsewhere.open(folder / "vb.html", 1400)
    elsewhere.until("Number(document.querySelector('[data-part=slider]').value) > 1")
    assert elsewhere.page.get_attribute("[data-part=play]", "aria-pressed") == "true"
    elsewhere.page.emulate_media(reduced_motion="reduce")
    elsewhere.page.reload()
    flown(elsewhere)
    assert elsewhere.page.input_value("[data-part=slider]") == "0"
    assert elsewhere.page.get_attribute("[data-part=play]", "aria-pressed") == "false"


def test_a_click_on_a_plot_or_on_the_phases_goes_there(page):
    left, top, width, height = box(page, ".plot .u-over")
    page.page.mouse.click(left + width / 2, top + height / 2)
    page.settle()
    assert float(page.page.input_value("[data-part=slider]")) == pytest.approx(386.1 / 2, abs=2)


@pytest.mark.thorough
def test_a_click_on_the_bar_of_the_phases_goes_there(elsewhere, folder):
    made(folder, "flight_tumble")
    elsewhere.open(folder / "flight_tumble.html", 1400)
    flown(elsewhere)  # before, it has not begun to play
    paused(elsewhere)
    span = float(elsewhere.page.get_attribute("[data-part=slider]", "max") or 0)
    for share in (0.25, 0.75):
        left, top, width, height = box(elsewhere, "[data-part=marks]")
        elsewhere.page.mouse.click(left + share * width, top + height / 2)
        elsewhere.settle()
        assert float(elsewhere.page.input_value("[data-part=slider]")) == pytest.approx(share * span, rel=0.01)


def test_both_flights_stand_side_by_side_after_a_change(page):
    move(page, {0: 30.0})
    flown(page)
    page.page.evaluate("document.querySelector('[data-part=both]').open = true")
    page.until("document.querySelectorAll('[data-part=strip] canvas').length === 12")
    texts = page.page.locator("[data-part=strip] div").all_inner_texts()
    assert [text.partition(",")[0] for text in texts[:6]] == [text.partition(",")[0] for text in texts[6:]]
    assert texts[0].endswith("30 deg off")
    assert texts[6].endswith("90 deg off")
    page.page.evaluate("document.querySelector('[data-part=both]').open = false")


@pytest.mark.thorough
def test_each_of_twenty_loads_shows_the_view_and_not_its_labels_alone(elsewhere, folder):
    for _ in range(20):
        elsewhere.open(folder / "vb.html", 1400)
        assert elsewhere.page.locator(".tag:not([hidden])").count() > 3
        assert elsewhere.page.evaluate(COLOURS) > 50


def test_a_flight_is_shown_in_the_view_and_what_is_of_the_one_before_is_marked_meanwhile(page, folder):
    before = page.page.evaluate(SHOWN)
    page.page.evaluate(STATES)  # a quick machine has flown before one could look
    move(page, {0: 140.0})
    flown(page)
    assert "flying" in page.page.evaluate("window.states")
    # Of the page's own motion; the slider says the same of the start.
    assert page.page.inner_text("[data-part=words]") == "0 s, 0 orbits; 140 deg from the desired attitude"
    assert page.page.evaluate(SHOWN) != before
    page.page.locator("[data-part=slider]").fill("386.1")
    page.settle()
    error = float(np.degrees(run(saved(page, folder / "scenarios"))["judge.attitude_error"][-1]))
    assert page.page.inner_text("[data-part=words]").endswith(f"; {error:.3g} deg from the desired attitude")
    page.page.locator("[data-part=slider]").fill("0")


def test_the_page_fits_every_width_and_asks_no_network(page):
    page.page.evaluate("document.querySelectorAll('details').forEach(one => { one.open = true })")
    for width in (390, 800, 1400):
        page.resize(width)
        assert page.page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.page.text_content("#same") == "the same as of the native run"
    assert page.complaints == []
    assert [url for url in page.foreign if not url.startswith("blob:")] == []


def test_a_run_that_fails_says_which_block_refused_what(unbounded):
    move(unbounded, {4: -1})
    assert flown(unbounded)["state"] == "failed"
    assert "allocator: " in (unbounded.page.text_content("#failure") or "")
    assert "hold_fraction" in (unbounded.page.text_content("#failure") or "")
    assert "the curves are of the flight before" in (unbounded.page.text_content("#verdict") or "")


def test_the_page_is_small(folder):
    assert (folder / "vb.html").stat().st_size < 2_000_000


def test_the_manifest_has_the_hash(tmp_path):
    result = run(ROOT / "scenarios" / "minimal.yaml", out=tmp_path / "run")
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text("utf-8"))
    assert manifest["samples_sha256"] == result.sha256


def test_the_button_of_a_fault_that_a_shortened_run_does_not_reach_is_disabled(tmp_path):
    faults = [{"set": "plant.rod_gain[1] = 0", "at": at} for at in (4, 5, 6)]
    scenario, page = tmp_path / "tumble.yaml", tmp_path / "tumble.html"
    scenario.write_text(json.dumps(minimal(faults=faults)), "utf-8")
    done = CliRunner().invoke(
        main, ["live", str(scenario), "--out", str(page), "--duration", "5"], catch_exceptions=False
    )
    assert done.exit_code == 0, done.output
    buttons = re.findall(r"<button[^>]*data-fault[^>]*>", page.read_text("utf-8"))
    assert ["disabled" in button for button in buttons[:3]] == [
        False,
        True,
        True,
    ]  # behind them those of the interfaces


def test_a_page_that_cannot_be_written_leaves_the_earlier_one(tmp_path, monkeypatch):
    scenario, page = tmp_path / "tumble.yaml", tmp_path / "tumble.html"
    scenario.write_text(json.dumps(minimal()), "utf-8")
    page.write_text("the earlier page")
    monkeypatch.setattr(whole, "sync", full)
    done = CliRunner().invoke(main, ["live", str(scenario), "--out", str(page)])
    assert (done.exit_code, done.stderr.splitlines()[-1]) == (4, f"{page} cannot be written: the disk is full")
    assert page.read_text() == "the earlier page"
    assert set(tmp_path.iterdir()) == {scenario, page}
