"""Settings of a live page's controls, by hand or drawn, and the native run of what the page says that it flew."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from orchestration import BlockError, InputError, run
from orchestration.expectations.outcomes import Outcome
from tests.orchestration.results.browser import Tab


def flown(page: Tab) -> dict[str, str]:
    """What the page says of its last flight, once nothing flies."""
    page.until("document.documentElement.dataset.state !== 'flying'")
    page.settle()
    return page.page.evaluate("({...document.documentElement.dataset})")


def paused(page: Tab) -> None:
    """Stops the motion, which takes a processor for itself as long as the page is open."""
    page.page.evaluate("document.querySelector('[data-part=play][aria-pressed=true]')?.click()")


def move(page: Tab, positions: Mapping[int, float]) -> None:
    """Moves sliders by their numbers, all before the worker answers."""
    moves = "; ".join(
        f"it = document.querySelector('[data-control=\"{number}\"]'); it.value = {value}; it.dispatchEvent(new "
        "Event('input'))"
        for number, value in positions.items()
    )
    page.page.evaluate(f"(() => {{ let it; {moves} }})()")


Verdicts = list[tuple[str, float | str | None, float | None]]


def verdicts(said: Mapping[str, str]) -> Verdicts:
    """Status, value and time of each expectation, as the page says them."""
    return [(each["status"], each["value"], each["time"]) for each in json.loads(said["verdicts"])]


def native(outcomes: Sequence[Outcome]) -> Verdicts:
    """What a page says of the same outcomes."""
    return [(o.status, o.found, o.time) for o in outcomes]


def saved(page: Tab, folder: Path) -> Path:
    """The scenario of what the page has flown, beside the one that it extends."""
    scenario = folder / "of_the_page.yaml"
    scenario.write_text(page.page.text_content("#scenario") or "", "utf-8")
    return scenario


def trials(page: Tab, folder: Path, count: int, drawn: np.random.Generator) -> set[str]:
    """Moves one to three sliders and injects some faults at drawn times, `count` times.

    Returns the hashes of the flights that did not fail. Raises AssertionError where hash or verdicts are not those of
    the native run, or where one of both fails.
    """
    sliders = page.page.locator("[data-control]").all()
    ends = [[float(it.get_attribute(name) or 0) for name in ("min", "max")] for it in sliders]
    faults = page.page.locator("[data-at]:not([disabled])").count()
    last = float(page.page.get_attribute("[data-part=slider]", "max") or 0)
    seen = set()
    for _ in range(count):
        page.page.click("#reset")
        most = min(4, len(ends) + 1)
        chosen = drawn.permutation(len(ends))[: drawn.integers(min(1, len(ends)), most)]
        move(page, {int(i): float(drawn.uniform(*ends[i])) for i in chosen})
        for fault in np.flatnonzero(drawn.random(faults) < 0.3):
            field = page.page.locator("[data-at]:not([disabled])").nth(int(fault))
            field.fill(f"{drawn.uniform(0.0, 0.98 * last):.1f}")
            field.press("Enter")
        said, refused = flown(page), ""
        try:
            result = run(saved(page, folder))
        except (BlockError, InputError) as error:
            refused = str(error)
        if refused or said["state"] == "failed":
            block, _, why = (page.page.text_content("#failure") or "").partition(": ")
            assert (block in refused, why.strip() in refused) == (True, True), refused
            continue
        assert said["hash"] == result.sha256
        assert verdicts(said) == native(result.outcomes)
        seen.add(said["hash"])
    return seen
