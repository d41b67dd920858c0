"""Live pages in Chromium with software drawing, for `make bench`: until it moves, a flight anew, frames and memory."""

from __future__ import annotations

import math
import os
import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from orchestration.live.page import page
from orchestration.live.system import prepare
from orchestration.session.read import load
from orchestration.session.run import whole

from .orchestration.results.browser import Tab, executable, launched

ROOT = Path(__file__).parents[1]
SCENARIOS = "paper_no_singularity", "flight_tumble", "mission_day"
_MOVES = "Number(document.querySelector('[data-part=slider]').value) > 0"
_FRAMES = "Number(document.querySelector('.view').dataset.frames)"
_STATE = "document.documentElement.dataset"
_SECONDS = 5
_PATIENCE = 60
"""s after which no more flights are asked for."""
GOALS: dict[str, Any] = {
    "first motion": 1000,
    "flight anew": {"paper_no_singularity": 100, "flight_tumble": 2000},
    "frames": 25,
    "heap": 60,
}
"""ms, ms, pictures a second, MB: for a machine with nothing else to do."""


def _processor() -> float:
    """Returns the processor's time (ms) of this process's children: Chromium's main, drawing and composing threads.

    It does not depend on what else runs. NaN where the system has no /proc.
    """
    parents: dict[int, list[int]] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            number, _, rest = stat.read_text().partition(" ")
            parents.setdefault(int(rest.rpartition(")")[2].split()[1]), []).append(int(number))
    todo, spent = parents.get(os.getpid(), []), 0.0
    for number in todo:
        todo += parents.get(number, [])
        if "chrom" in Path(f"/proc/{number}/comm").read_text():
            for task in Path(f"/proc/{number}/task").glob("*/schedstat"):
                with suppress(OSError):
                    spent += int(task.read_text().split()[0]) / 1e6
    return spent if parents else math.nan


def pages(runs: int, row: Callable[[str, str, str], None]) -> None:
    """Prints a row for each figure of the live pages."""
    path = executable()
    if path is None:
        row("live pages", "", "no Chromium here")
        return
    with tempfile.TemporaryDirectory() as folder, launched(path) as tab:
        for name in SCENARIOS:
            live = prepare(load(ROOT / "scenarios" / f"{name}.yaml"))
            file = Path(folder, f"{name}.html")
            file.write_text(page(live, whole(live.scenario)), "utf-8")
            _page(name, file, tab, runs, row)


def _page(name: str, file: Path, tab: Tab, runs: int, row: Callable[[str, str, str], None]) -> None:
    tab.page.set_viewport_size({"width": 1400, "height": 900})
    opened, took = [], []
    for _ in range(runs):
        tab.page.goto("about:blank")
        begun, spent = time.perf_counter(), _processor()
        tab.page.goto(file.as_uri(), wait_until="commit")
        tab.page.wait_for_selector("[data-part=slider]", state="attached")
        tab.until(_MOVES)
        opened.append(1e3 * (time.perf_counter() - begun))
        took.append(_processor() - spent)
    row(
        f"page of {name}: first motion",
        f"{min(opened):.0f} ms",
        f"median {statistics.median(opened):.0f} ms; goal {GOALS['first motion']} ms; "
        f"{statistics.median(took):.0f} ms of the processor; {file.stat().st_size / 1e6:.2f} MB",
    )
    tab.until(f"{_STATE}.state === 'shown'", 300)
    time.sleep(2)  # what has just been compiled is compiled for speed
    before, spent, begun = tab.page.evaluate(_FRAMES), _processor(), time.perf_counter()
    time.sleep(_SECONDS)
    frames, drawing = tab.page.evaluate(_FRAMES) - before, _processor() - spent
    rate = frames / (time.perf_counter() - begun)
    tab.page.click("[data-part=play]")
    flights, begun, spent = [], time.perf_counter(), _processor()
    for i in range(runs + 2):  # the first ones are not compiled for speed yet
        if flights and time.perf_counter() - begun > _PATIENCE:
            break
        tab.page.evaluate(
            "((share) => { const it = document.querySelector('[data-control=\"0\"]'); it.value = share * it.max;"
            f" it.dispatchEvent(new Event('input')); }})({0.3 + 0.4 * i / (runs + 2)})"
        )
        tab.until(f"{_STATE}.state === 'shown'", 300)
        flights.append(float(tab.page.evaluate(f"{_STATE}.ms")))
    spent = (_processor() - spent) / len(flights)
    heap = tab.page.evaluate("performance.memory.usedJSHeapSize") / 1e6
    tab.page.context.new_cdp_session(tab.page).send("HeapProfiler.collectGarbage")
    kept = tab.page.evaluate("performance.memory.usedJSHeapSize") / 1e6
    memory = float(tab.page.evaluate(f"{_STATE}.memory")) / 1e6
    goal = GOALS["flight anew"].get(name)
    row(
        f"page of {name}: flight anew",
        f"{min(flights):.0f} ms",
        f"median {statistics.median(flights):.0f} ms{f'; goal {goal} ms' if goal else ''}; "
        f"{spent:.0f} ms of the processor with its plots",
    )
    row(
        f"page of {name}: frames at 1400 x 900",
        f"{rate:.0f} /s",
        f"goal {GOALS['frames']} /s; {drawing / frames:.0f} ms of the processor each",
    )
    row(
        f"page of {name}: heap, and the module's memory",
        f"{heap:.0f} MB",
        f"goal {GOALS['heap']} MB; {kept:.0f} MB without garbage; {memory:.0f} MB",
    )
