"""Writes the card of another team's FMU as one page that prints, as data, and as a script for a bench.

Tests: tests/orchestration/acceptance/test_vendor_card.py.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from ...errors import writing
from ...fmu.model import Floats
from ...results.html import Page, asset, facts, header, joined, section, table
from ...results.whole import put
from .vendor_card import Line, Reading, as_data, axis_and_angle

_HERE = Path(__file__)
FILES = "card.html", "card.json", "card.py"
_COLUMNS = "set", "before", "to", "read", "before ", "expected", "tolerance", "measured", "verdict"
_STYLE = """
.card .before-all { display: flex; flex-wrap: wrap; gap: 0 3rem; }
.card h3 { margin-top: 1.6rem; } .card td { white-space: nowrap; }
.blank { display: inline-block; min-width: 5.5rem; height: 1.3em; border-bottom: 1px solid currentColor; }
.card .stimulus { display: flex; flex-wrap: wrap; gap: .5rem 2rem; align-items: center; }
.card svg { width: 9rem; height: 9rem; flex: none; } .card .before { opacity: .35; }
.card svg text { font: 12px sans-serif; fill: currentColor; }
@media print {
  .card article { break-inside: avoid; }
  .card .blank { min-width: 3.2rem; }
  .card .scroll > table { font-size: 7.5pt; }
  .card .scroll > table th, .card .scroll > table td { padding-right: .45rem; }
}
"""
_COLOURS = "#c0392b", "#1e8449", "#2471a3"


def write(
    card: list[Line], about: Mapping[str, str], folder: Path, parameters: list[tuple[str, Any, str]]
) -> list[Path]:
    """Writes the files. Raises ResultsError."""
    texts = {
        "card.html": page(card, about, parameters),
        "card.json": json.dumps(as_data(card, about, parameters), indent=1, ensure_ascii=False) + "\n",
        "card.py": asset(_HERE.with_name("card_script.py.template")),
    }
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            put(folder / name, text)
    return [folder / name for name in texts]


def page(card: list[Line], about: Mapping[str, str], parameters: list[tuple[str, Any, str]]) -> str:
    """Returns the page."""
    title = f"Ground test card of {about['fmu']}"
    lead = (
        f"In the place of {about['as']}, in the names, units and axes of {about['fmu']}. Set the parameters and "
        "all inputs before a step, start the block, set what the step says, wait, and read. "
        "(+) rises, (-) falls, (0) stays."
    )
    blanks = [*("unit under test", "serial number", "place and date", "tested by"), "verdict"]
    head = header(title, lead, [], facts(dict(about)), facts({name: blank() for name in blanks}))
    rows = [(name, number(value) if isinstance(value, float) else value, unit) for name, value, unit in parameters]
    set_ = section("Parameters", table(("parameter", "value", "unit"), rows))
    first = Markup('<div class="before-all">{}{}</div>').format(set_, base(card))
    body = joined([first, *steps(card)])
    return Page().html(title, [head, Markup('<div class="card">{}</div>').format(body)], style=_STYLE)


def blank() -> Markup:
    """Returns a place to write into."""
    return Markup('<span class="blank"></span>')


def base(card: list[Line]) -> Markup:
    """Returns the inputs before each step."""
    rows = [(reading.name, number(reading.before), reading.unit) for reading in card[0].all]
    return section("Inputs before each step", table(("input", "value", "unit"), rows))


def steps(card: list[Line]) -> Iterator[Markup]:
    """Returns a part of the page for each step."""
    for count, line in enumerate(card, 1):
        picture = Markup("")
        if line.attitudes is not None:
            words = Markup("<p>before: {}<br>after: {}</p>").format(*map(axis_and_angle, line.attitudes))
            picture = Markup('<div class="stimulus">{}{}</div>').format(triads(*line.attitudes), words)
        heading = Markup("<h3>{}. {}; wait {}</h3>").format(count, line.text, f"{line.hold:.3g} s")
        rows = list(_rows(line.inputs, line.outputs))
        yield Markup("<article>{}{}{}</article>").format(heading, picture, table(_COLUMNS, rows))


def _rows(inputs: list[Reading], outputs: list[Reading]) -> Iterator[list[object]]:
    for i in range(max(len(inputs), len(outputs))):
        given, read = inputs[i] if i < len(inputs) else None, outputs[i] if i < len(outputs) else None
        left = [given.name, number(given.before), with_unit(given.after, given.unit)] if given else ["", "", ""]
        right: list[object] = [""] * 6
        if read is not None:
            expected = f"{with_unit(read.after, read.unit)} ({read.sign})"
            right = [read.name, number(read.before), expected, f"{float(f'{read.tolerance:.2g}'):g}", blank(), blank()]
        yield [*left, *right]


def number(value: float) -> str:
    """Returns a number with five digits."""
    return f"{value:.5g}"


def with_unit(value: float, unit: str) -> str:
    """Returns a number with its unit."""
    return f"{number(value)} {unit}".rstrip()


def triads(before: Floats, after: Floats) -> Markup:
    """Returns a picture of the body's axes (columns) before, pale, and after."""
    look = np.array([[-0.7071, 0.7071, 0.0], [-0.4082, -0.4082, 0.8165]])  # isometric: to the right, and up

    def lines(axes: Floats, kind: str) -> Markup:
        ends = [(60 + 48 * x, 60 - 48 * y) for x, y in (look @ axes).T]
        drawn = [(*end, colour, end[0], end[1], name) for end, colour, name in zip(ends, _COLOURS, "xyz", strict=True)]
        arrow = '<line x1="60" y1="60" x2="{:.1f}" y2="{:.1f}" stroke="{}" stroke-width="3"/>'
        label = '<text x="{:.1f}" y="{:.1f}">{}</text>' if kind == "after" else ""
        marks = joined(Markup(arrow + label).format(*one[: 6 if label else 3]) for one in drawn)
        return Markup('<g class="{}">{}</g>').format(kind, marks)

    name = "the body's axes before, pale, and after"
    return Markup('<svg viewBox="0 0 120 120" role="img" aria-label="{}">{}{}</svg>').format(
        name, lines(before, "before"), lines(after, "after")
    )
