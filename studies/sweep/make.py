"""Flies tumbles with each constant at half and at twice its value, and writes docs/sweep.csv and docs/sweep.md."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import files, markdown
from ..flight.cases import SEEDS, tumbles
from ..paper import ROOT, Array
from .constants import CONSTANTS
from .loop import UNTIL, built, settled, tumbles_of, value_of

FILE = "sweep.csv"
FACTORS = (0.5, 2.0)


@dataclass(frozen=True)
class Line:
    """Tumbles with one value of one constant; without a name as they are."""

    file: str
    name: str
    value: float
    runs: int
    settled: int
    median_s: float
    worst_s: float
    ratio: float
    """Geometric mean of the times over those with the chosen value; one that does not settle counts as UNTIL."""


def make(runs: int, file: Path) -> Iterator[str]:
    """Tells of each value, saved as it is flown. A sweep of another number of tumbles, or before a change of a value, begins anew."""
    group = tumbles_of(tumbles("nominal", SEEDS["nominal"], runs))
    with tempfile.TemporaryDirectory() as folder:

        def fly(constant: tuple[str, str] | None, value: str) -> Array:
            library = built(constant, value, Path(folder, "-".join((*(constant or ()), value))))
            return np.array([settled(library, tumble) for tumble in group])

        chosen = fly(None, "chosen")
        lines = [_line("", "", math.nan, chosen, chosen)]
        known = load(file) if file.is_file() else []
        kept = {(k.file, k.name, k.value): k for k in known} if known[:1] and _same(known[0], lines[0]) else {}
        for source, name, _ in CONSTANTS:
            for factor in FACTORS:
                text = _scaled(value_of(source, name), factor)
                key = (source, name, float(text))
                line = kept.get(key) or _line(*key, fly((source, name), text), chosen)
                lines.append(line)
                files.save(Line, file, lines)
                yield f"{name} {text}: {line.settled} of {line.runs}, {line.ratio:.3f} of the time"


def _same(a: Line, b: Line) -> bool:
    times = ((a.median_s, b.median_s), (a.worst_s, b.worst_s))
    return (a.runs, a.settled) == (b.runs, b.settled) and all(math.isclose(*pair, rel_tol=1e-3) for pair in times)


def _scaled(value: str, factor: float) -> str:
    """A whole number stays one."""
    return f"{float(value) * factor:g}" if "." in value else f"{max(1, round(int(value) * factor))}"


def _line(file: str, name: str, value: float, times: Array, chosen: Array) -> Line:
    ratio = np.exp(np.mean(np.log(np.minimum(times, UNTIL) / np.minimum(chosen, UNTIL))))
    found = int(np.isfinite(times).sum())
    return Line(file, name, value, len(times), found, float(np.median(times)), float(times.max()), float(ratio))


def load(file: Path) -> list[Line]:
    """The lines of docs/sweep.csv. Raises InputError for a file of another form."""
    return files.load(Line, file, "python -m studies sweep")


def publish(folder: Path = ROOT / "docs") -> Path:
    """Writes the page from the file in the folder; returns it."""
    target = folder / "sweep.md"
    target.write_text(text(load(folder / FILE)), "utf-8")
    return target


def text(lines: list[Line]) -> str:
    """The page."""
    chosen, swept = lines[0], lines[1:]
    meaning = {(file, name): what for file, name, what in CONSTANTS}
    names = list(dict.fromkeys((line.file, line.name) for line in swept))
    rows = []
    for file, name in names:
        pair = [line for line in swept if (line.file, line.name) == (file, name)]
        rows.append([f"`{name}` ({file})", meaning[file, name], value_of(file, name), *map(_cell, pair)])
    return markdown.render(
        Path(__file__).parent,
        runs=chosen.runs,
        settled=chosen.settled,
        median=f"{chosen.median_s:.0f}",
        worst=f"{chosen.worst_s:.0f}",
        until=f"{UNTIL:.0f}",
        rows=rows,
        count=len(names),
    )


def _cell(line: Line) -> str:
    lost = "" if line.settled == line.runs else f", {line.settled} of {line.runs} settle"
    worst = f"{line.worst_s:.0f} s" if math.isfinite(line.worst_s) else "not settled"
    return f"{line.value:g}: {line.ratio:.2f} ×, worst {worst}{lost}"
