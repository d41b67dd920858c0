"""The page that `orchestrate live` makes: it flies in a browser what the native run flies, to the last bit."""

from __future__ import annotations

import json
import shutil
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

from orchestration import run
from orchestration.cli.main import main
from orchestration.errors import InputError
from orchestration.live.sliders import controls
from orchestration.live.system import prepare
from orchestration.runner.open import open_scenario
from orchestration.runner.read import load
from tests.orchestration.results.browser import Tab

ROOT = Path(__file__).parents[3]
SETS = {
    "as the scenario has it": ({}, ()),
    "turned and tumbling": ({0: 140.0, 1: 8.0}, ()),
    "another gain and orbit": ({2: 0.008, 3: 51.6}, ()),
    "a dead rod and a frozen field": ({4: 0.5}, (0, 1)),
    "a lost command while it turns": ({0: 30.0}, (2,)),
}
"""Five sets of parameters of V.B: positions of the sliders by number, and the faults that are injected."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The scenarios, and the live page of V.B beside them."""
    folder = tmp_path_factory.mktemp("live")
    shutil.copytree(ROOT / "scenarios", folder / "scenarios")
    given = ["live", str(folder / "scenarios" / "paper_no_singularity.yaml"), "--out", str(folder / "vb.html")]
    done = CliRunner().invoke(main, given, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return folder


@pytest.fixture
def page(chromium: Tab, folder: Path) -> Tab:
    chromium.open(folder / "vb.html")
    flown(chromium, 1)
    return chromium


def flown(page: Tab, least: int = 0) -> SimpleNamespace:
    """What the page says of its last flight, once nothing flies and so many have been flown."""
    for _ in range(200):
        data = page.page.evaluate("({...document.documentElement.dataset})")
        if int(data.get("flown", 0)) >= least:
            return SimpleNamespace(**{**data, "flown": int(data["flown"])})
        time.sleep(0.05)
    raise TimeoutError(f"no flight: {page.complaints}")


def test_five_sets_of_parameters_have_the_hash_of_the_native_run(page, folder):
    seen = set()
    for name, (sliders, faults) in SETS.items():
        before = flown(page).flown
        script = "document.getElementById('reset').click();"
        page.page.evaluate(f"{script} new Promise(done => setTimeout(done, 50))")
        flown(page, before + 1)
        before = flown(page).flown
        for number, value in sliders.items():
            place = f"document.querySelector('[data-control=\"{number}\"]')"
            page.page.evaluate(f"{place}.value = {value}; {place}.dispatchEvent(new Event('input'))")
        for number in faults:
            page.page.evaluate(f"document.querySelector('[data-fault=\"{number}\"]').click()")
        if sliders:
            page.page.evaluate("new Promise(done => setTimeout(done, 400))")
            flown(page, before + 1)
        scenario = folder / "scenarios" / "of_the_page.yaml"
        scenario.write_text(page.page.evaluate("document.getElementById('scenario').textContent"), "utf-8")
        assert flown(page).hash == run(scenario).sha256, name
        seen.add(flown(page).hash)
    assert len(seen) == len(SETS)
    assert page.complaints == []


@pytest.mark.parametrize("width", [1400, 800, 390])
def test_the_page_fits_and_asks_no_network(page, width):
    page.page.set_viewport_size({"width": width, "height": 900})
    page.settle()
    assert page.page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.page.evaluate("document.getElementById('same').textContent") == "the same as of the native run"
    assert page.complaints == []
    assert [url for url in page.foreign if not url.startswith("blob:")] == []


def test_a_run_that_fails_says_which_block_refused_what(page):
    place = "document.querySelector('[data-control=\"4\"]')"
    before = flown(page).flown
    page.page.evaluate(f"{place}.min = -1; {place}.value = -1; {place}.dispatchEvent(new Event('input'))")
    flown(page, before + 1)
    assert "allocator: " in page.page.evaluate("document.getElementById('failure').textContent")
    assert "hold_fraction" in page.page.evaluate("document.getElementById('failure').textContent")


def test_the_page_is_small(folder):
    assert (folder / "vb.html").stat().st_size < 2_000_000


def test_the_manifest_has_the_hash(tmp_path):
    result = run(ROOT / "scenarios" / "minimal.yaml", out=tmp_path / "run")
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text("utf-8"))
    assert manifest["samples_sha256"] == result.sha256


def minimal(**changes):
    data = {
        "name": "tumble",
        "step": 1.0,
        "duration": 10.0,
        "blocks": {"plant": {"fmu": "plant", "start": {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0}}},
    }
    return {**data, **changes}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"blocks": {"plant": {"fmu": "other.fmu"}}}, "blocks.plant.fmu: other.fmu is an FMU in binaries"),
        ({"flavour": "python"}, "flavour: plant is of the Python flavour"),
        ({"isolation": "process"}, "isolation: plant runs in a process of its own"),
    ],
)
def test_what_no_page_can_have_is_refused_by_name(changes, message):
    with pytest.raises(InputError, match=message):
        prepare(load(minimal(**changes)))


@pytest.mark.parametrize(
    ("slider", "message"),
    [
        ({"start": "plan.omega_B0[1]"}, "there is no block 'plan'; did you mean 'plant'"),
        ({"start": "plant.omega_B0"}, "has 3 elements; remedy: one of them, or 'measure: norm'"),
        ({"start": "plant.epoch"}, "expected a number"),
        ({"start": "plant.disturbance_torque_B", "measure": "norm"}, "is zero in the scenario"),
        (
            {"start": "plant.Q0", "measure": "rotation", "axis": [1, 0, 0], "least": 1, "most": 2},
            "expected the scenario's own",
        ),
        ({"start": "plant.omega_B0[1]", "least": "1 m"}, "omega_B0"),
        ({"start": "plant.omega_B0[1]", "least": 2, "most": 1}, "expected 'least' below 'most'"),
        ({"start": "plant.altitude"}, "is worked out in Python"),
        ({"start": "friction"}, "no block takes such a shared value"),
    ],
)
def test_a_slider_that_can_move_nothing_is_refused_where_it_stands(slider, message):
    entry = {"least": -1, "most": 1, **slider}
    scenario = load(minimal(live={"sliders": [entry]}))
    with pytest.raises(InputError, match=message) as raised:
        controls(scenario, open_scenario(scenario).plan)
    assert "live.sliders[1]" in str(raised.value)
