"""The page of a review, and that of two side by side. Tests: tests/design/review/test_review.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from orchestration.errors import writing
from orchestration.results import html, plots
from orchestration.results.whole import put
from plant.so3 import Array

from .content import APART, Curves, Review, Section, Table

STYLE = """
.review td:first-child { font-weight: 600; }
.off { background: var(--warn-soft); padding: 0 .25rem; border-radius: .2rem; }
.drawing { max-width: 420px; margin: 0 0 1rem; }
.csv { font-size: .82rem; }
.wide td:first-child { white-space: nowrap; }
.about { color: var(--quiet); font-size: .86rem; max-width: 70rem; }
.about + h3 { margin-top: 1rem; }
nav ol { columns: 18rem; padding-left: 1.4rem; }
@media print { section { break-inside: auto; } .drawing { max-width: 300px; } nav { display: none; }
  .about { font-size: .72rem; } .wide { font-size: .72rem; } .wide th, .wide td { padding-right: .4rem; }
  .wide td:nth-last-child(-n+2) { min-width: 6rem; } }
"""
NAME = "review.html"
WIDE = 8
"""Columns of a table whose letters are smaller on paper."""
DEPTH = 1e-4
"""Of the largest value: the least that a logarithmic axis has."""
_STATUS = ("met", "not met", "undecided", "not verifiable")


def write(review: Review, folder: Path) -> Path:
    """Writes the page of a review beside its data and returns its path. Raises ResultsError."""
    path = folder / NAME
    with writing(folder):
        put(path, page(review))
    return path


def page(review: Review) -> str:
    """Returns the page of a review."""
    made = html.Page()
    parts = [_header(review), _contents(review)]
    parts += [_section(section, made, number) for number, section in enumerate(review.sections, start=1)]
    return made.html(f"Review of {review.name}", parts, style=STYLE)


def _header(review: Review) -> Markup:
    badges = []
    for status, kind in zip(_STATUS, ("good", "bad", "warn", "warn"), strict=True):
        if count := review.verdicts.count(status):
            badges.append((kind, f"{count} requirement{'s' * (count > 1)} {status}"))
    return html.header(f"Review of {review.name}", review.description, badges, html.facts(review.facts))


def _contents(review: Review) -> Markup:
    items = html.each(
        '<li><a href="#{0.anchor}">{0.heading}</a></li>', [_Anchor(section.heading) for section in review.sections]
    )
    return Markup('<nav aria-label="Contents"><ol>{}</ol></nav>\n').format(items)


class _Anchor:
    def __init__(self, heading: str) -> None:
        self.heading, self.anchor = heading, heading.lower().replace(" ", "-")


def _section(section: Section, made: html.Page, number: int) -> Markup:
    content: list[Markup] = []
    if section.drawing:  # made by drawing.py from numbers alone
        content.append(Markup('<div class="drawing">{}</div>\n').format(Markup(section.drawing)))
    content.append(html.listed(section.notes, "notes"))
    if section.motion:
        content += [Markup("<h3>The file's own tumble</h3>\n"), made.view(section.motion)]
    content += [table(one) for one in section.tables]
    content += [figure(one, made) for one in section.figures]
    anchor = Markup('<div id="{}">').format(_Anchor(section.heading).anchor)
    return anchor + html.section(f"{number}. {section.heading}", html.joined(content)) + Markup("</div>\n")


def table(one: Table) -> Markup:
    """Returns a table with its name, and a link to its CSV file."""
    if not one.rows:
        return Markup("<h3>{}</h3>\n<p>none</p>\n").format(one.name)
    cells = [[_cell(text) for text in row] for row in one.rows]
    head = Markup('<h3>{} <a class="csv" href="{}">CSV</a></h3>\n').format(one.name, one.file)
    note = Markup('<p class="about">{}</p>\n').format(one.note) if one.note else Markup("")
    wide = " wide" if len(one.columns) >= WIDE else ""
    return head + html.table(one.columns, cells, f"review named{wide}" if len(one.columns) > 2 else "review") + note


def _cell(text: str) -> str | Markup:
    """Returns a cell: a verdict in its colour, and marked where two designs differ."""
    if APART in text:
        return Markup('<span class="off">{}</span>').format(text)
    return html.verdict(text) if text in _STATUS else text


def figure(one: Curves, made: html.Page) -> Markup:
    """Returns a figure of curves."""
    x = np.array(one.x)
    curves = [plots.Curve(name, _shown(values, one.log), i) for i, (name, values) in enumerate(one.y.items())]
    shown: dict[str, Any] = {
        **plots.plot(x, one.y_label, curves, made.arrays, plots.FEWER),
        "unit": "",
        "scale": "log" if one.log else "linear",
        "lines": one.lines,
        "xlabel": one.x_label,
        "xname": one.x_label.partition(",")[0],
    }
    return made.figure(one.name, [shown], kind="n1")


def _shown(values: list[float], log: bool) -> Array:
    """Returns the values that are drawn: on a logarithmic axis none that is zero or far below all others."""
    found = np.array(values)
    return np.where(found > DEPTH * found.max(initial=0.0), found, np.nan) if log else found
