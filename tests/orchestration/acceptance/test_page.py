"""The page of a comparison: its plots, and that it lets nothing in or out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orchestration.acceptance import page as pages
from orchestration.acceptance.accept import Acceptance
from orchestration.acceptance.compare import Comparison
from orchestration.acceptance.compare import _differences as differences
from orchestration.acceptance.difference import Difference
from orchestration.acceptance.playback import Played
from orchestration.acceptance.polarity.mend import Mended
from orchestration.acceptance.tolerances import Bound, both

from ..results.browser import Tab, pixels
from ..results.flown import flown
from ..results.swing import EVIL, Reader, data_of, swing, unpacked

pytestmark = pytest.mark.isolate


def compared(note: str = "swings", steps: int = 400) -> Comparison:
    """Our swing against one that has half its amplitude in the open loop, and ends after so many steps in the loop."""
    ours, theirs = swing(note=note), swing(steps, note=note)
    theirs.warnings.append(note)
    played = Played(ours.models["a"], np.arange(401), {"x": 0.5 * ours["a.x"], "y": ours["a.y"][:, None]}, [])
    differences = [
        Difference("x", "rad", False, "1e-06 of the largest", 0.5, "x[1]", 0.0, 0.5, 0.1),
        Difference("y", "", True, "1e-06 of the largest", 0.0, "", None, 0.0, 0.0),
        Difference("on", "", True, "no sample", note="theirs lacks it"),
    ]
    return Comparison("a", f"their {note}.fmu", ours, theirs, played, differences, 0.1)


def test_ours_and_theirs_stand_in_one_plot_and_their_difference_beside_it():
    comparison = compared()
    data = data_of(pages.page(comparison))
    both, apart = data["plots"][:2]
    assert [(c["name"], c["colour"], c["pale"]) for c in both["curves"]] == [
        ("x[1], ours", 0, True),
        ("x[2], ours", 1, True),
        ("x[1], theirs", 0, False),
        ("x[2], theirs", 1, False),
    ]
    assert apart["label"] == "theirs - ours, rad"
    shown = unpacked(data["arrays"][apart["curves"][1]["y"]])
    np.testing.assert_allclose(shown, -0.5 * comparison.ours["a.x"][:, 1], rtol=1e-6)


def test_a_run_of_theirs_that_ended_early_leaves_a_gap():
    data = data_of(pages.page(compared(steps=100)))
    panel = next(plot for plot in data["plots"] if plot["label"].endswith(", deg"))
    ours, theirs = (unpacked(data["arrays"][c["y"]]) for c in (panel["curves"][0], panel["curves"][2]))
    assert panel["curves"][2]["name"] == "one, theirs"
    assert len(ours) == len(theirs) == 401
    np.testing.assert_array_equal(theirs[:101], ours[:101])
    assert np.isnan(theirs[101:]).all()


def test_it_says_what_became_of_each_output_and_expectation():
    words = Reader(pages.page(compared())).words
    for text in (
        "differs x 0 0.5 rad (0.5) 0.1 rad",
        "ok y 0",
        "\N{EN DASH} on theirs lacks it",
        "failed norm",
        "met stays below 2",
    ):
        assert text in words, text


def test_a_wiring_that_is_named_or_as_likely_fails_the_requirement_whether_or_not_the_loop_shows_it():
    facts = {"platforms": [], "not_valid": [], "kind": "x"}
    cases = (
        ({"x": "sign"}, (), True, "failed"),
        ({}, ("x: sign",), True, "failed"),
        ({}, (), True, "met"),
        ({}, (), False, "failed"),
    )
    for behaves, equally, met, status in cases:
        comparison = compared()
        comparison.mended = Mended("a", behaves, {}, 1.0, 0.0, None, True, equally=equally)
        comparison.theirs.outcomes[:] = [replace(one, passed=met) for one in comparison.theirs.outcomes]
        made = Acceptance(facts, "a", "swing", [], None, comparison=comparison)
        assert {one.name: one.status for one in made.requirements}["no wrong wiring is found"] == status


def test_what_theirs_lacks_does_not_hide_what_is_compared_after_it():
    comparison = compared()
    del comparison.played.outputs["x"]
    ports = [v for v in comparison.ours.models["a"].of("output") if v.name in ("x", "y")]
    bound = both(Bound(absolute=1e-6))
    assert [v.name for v in ports] == ["x", "y"]
    found = differences(comparison, ports, {"x": bound, "y": bound}, 1)
    assert [(one.output, one.note, one.largest) for one in found] == [("x", "theirs lacks it", None), ("y", "", 0.0)]


def test_no_text_of_a_scenario_becomes_html_or_script():
    tags = [[tag for tag, _ in Reader(pages.page(compared(note))).elements] for note in (EVIL, "harmless")]
    assert tags[0] == tags[1]


def test_a_browser_draws_it_without_a_complaint_and_nothing_stands_out_at_the_side(chromium: Tab, tmp_path: Path):
    chromium.open(pages.write(compared(EVIL), tmp_path))
    for plot in range(6):
        assert pixels(chromium, "#0072b2", plot) > 200
    assert chromium.page.locator(".plot canvas").count() == 6
    assert chromium.page.evaluate("typeof window.hacked") == "undefined"
    for width in (1366, 390):
        chromium.resize(width)
        assert chromium.page.evaluate("document.documentElement.scrollWidth") == width
    assert chromium.complaints == []


def test_the_view_has_the_motion_with_theirs_and_ours_as_its_ghost_and_beside_it(chromium: Tab, tmp_path: Path):
    ours, theirs = flown(), flown(rate=1.0)
    played = Played(ours.models["a"], np.arange(201), {}, [])
    chromium.open(pages.write(Comparison("a", "their.fmu", ours, theirs, played), tmp_path))
    view = chromium.page.locator(".view")
    view.locator("details").evaluate_all("folds => folds.forEach(fold => { fold.open = true; })")
    assert view.get_by_role("checkbox", name="with ours (grey)").is_checked()
    chromium.until("document.querySelectorAll('[data-part=strip] canvas').length === 12")
    texts = view.locator("[data-part=strip]").inner_text().split("\n")
    assert [text for text in texts if text.startswith("with")] == ["with theirs", "with ours"]
    ends = [text for text in texts if text.startswith("100 s")]
    assert ends == ["100 s, 100 deg off", "100 s, 50 deg off"]
    chromium.page.locator("[data-part=slider]").fill("50")
    chromium.settle()
    assert chromium.page.inner_text("[data-part=words]").startswith("50 s; turning; 50 deg from the desired attitude")
    assert chromium.complaints == []
