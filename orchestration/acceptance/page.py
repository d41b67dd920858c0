"""Writes the page of a comparison, comparison.html, in the style of a run's report and with its plots."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from markupsafe import Markup

from fmus.interface import SOURCE, cites

from ..errors import writing
from ..quantities import ONE, shown, with_unit
from ..results import view as seen
from ..results.curves import axis
from ..results.html import Page, each, header, joined, listed, piece, section, table, verdict
from ..results.inputs import inputs
from ..results.plots import CURVES, ROWS, Curve, plot
from ..results.report import figure, fmu_table
from ..results.whole import put
from . import verdict as words
from .compare import Comparison
from .difference import Difference
from .verdict import DIFFERENCES, colour, explanation, meaning, rows_of_differences

_CLOSED = (
    "The whole run twice: with our block, and with theirs in its place. The status is that of the run with theirs."
)
_EXPECTATIONS = ("status", "expectation", "ours", "theirs", "expected")
_KEY_FIGURES = ("signal", "ours at the end", "theirs at the end", "ours, largest", "theirs, largest")


def write(comparison: Comparison, folder: Path) -> Path:
    """Writes the page and returns its path. Raises ResultsError where it cannot be written."""
    path = folder / "comparison.html"
    with writing(path):
        folder.mkdir(parents=True, exist_ok=True)
        put(path, page(comparison))
    return path


def page(comparison: Comparison) -> str:
    """Returns the page of a comparison."""
    ours = comparison.ours
    made = Page(ours)
    title = f"{comparison.block} against {Path(comparison.fmu).name}"
    kind = {"green": "good", "yellow": "warn", "red": "bad"}[colour(comparison)]
    failure = Markup('<pre class="failure">{}</pre>\n').format(comparison.failure) if comparison.failure else ""
    parts = [
        header(
            title,
            f"{ours.scenario.name}: {ours.scenario.description}",
            [(kind, words.verdict(comparison))],
            failure,
        ),
        section("Inputs", inputs(ours.scenario)),
        *sections(comparison, made),
    ]
    return made.html(title, parts)


def sections(comparison: Comparison, made: Page) -> list[Markup]:
    """Returns the parts of the page below its head, for another page, too."""
    ours, theirs = comparison.ours, comparison.theirs
    open_loop = _open_loop(comparison, made)  # whose plots come first on the page
    motion = _motion(comparison, made)
    figures = joined(figure(ours, entry, made, theirs) for entry in ours.scenario.figures)
    return [
        open_loop,
        section("Closed loop", _CLOSED + table(_EXPECTATIONS, _claims(comparison))),
        section("Motion", motion),
        section("Key figures", table(_KEY_FIGURES, _key_figures(comparison))),
        section(
            "Figures of the closed loop", figures, Markup('<p class="hint">Ours is wide and pale, theirs thin.</p>\n')
        ),
        section("Notes", listed(theirs.warnings, "notes")),
        fmu_table("FMUs compared", "whose", _fmus(comparison)),
    ]


def _motion(comparison: Comparison, made: Page) -> Markup:
    """Returns the view of the run with theirs, ours as its ghost; nothing where one of them has no attitude to show."""
    ours, theirs = (seen.view(result, made.arrays) for result in (comparison.ours, comparison.theirs))
    return made.view(seen.beside(theirs, ours, ("with theirs", "with ours")))


def _open_loop(comparison: Comparison, made: Page) -> Markup:
    cells = [[verdict(status), *cells] for status, cells in rows_of_differences(comparison)]
    compared = [difference for difference in comparison.differences if difference.largest is not None]
    variables = comparison.ours.models[comparison.block].variables
    cited = [SOURCE] if any(cites(variables[difference.output].description) for difference in compared) else []
    content = [
        each("<p>{}</p>\n", [*explanation(comparison), *meaning(comparison), *cited]),
        table(("status", *DIFFERENCES), cells),
        piece("hint") if compared else "",
        *(_output(comparison, difference, made) for difference in compared),
    ]
    return section("Open loop", joined(content))


def _output(comparison: Comparison, difference: Difference, made: Page) -> Markup:
    """Returns the figure of an output of both blocks on the same inputs, and of their difference."""
    ours, name = comparison.ours, difference.output
    variable = ours.models[comparison.block].variables[name]
    unit = variable.display_unit if variable.display_unit is not None else variable.unit or ONE
    factor, offset = (variable.unit or ONE).conversion(unit)
    theirs = comparison.played.outputs[name]
    at = comparison.played.rows[: len(theirs)]
    mine = ours.rows(f"{comparison.block}.{name}")[at]
    labels = list(enumerate(variable.label(i) for i in range(min(mine.shape[1], CURVES))))
    stepped = variable.type != "real"
    both = [Curve(f"{label}, ours", factor * mine[:, i] + offset, i, True, stepped) for i, label in labels]
    both += [Curve(f"{label}, theirs", factor * theirs[:, i] + offset, i, False, stepped) for i, label in labels]
    apart = [Curve(label, factor * (theirs[:, i] - mine[:, i]), i, False, stepped) for i, label in labels]
    plots = [plot(ours.time[at], axis(name, unit), both, made.arrays, ROWS)]
    # A difference by rounding alone is a line along zero.
    least = 1e-9 * float(abs(factor * mine).max(initial=0.0))
    plots += [{**plot(ours.time[at], axis("theirs - ours", unit), apart, made.arrays, ROWS), "least": least}]
    for made_plot in plots:
        made_plot["unit"] = shown(unit)
    left = mine.shape[1] - CURVES
    notes = ["ours wide and pale, theirs thin", *([f"{left} more elements are not drawn"] if left > 0 else [])]
    return made.figure(name, plots, variable.description, notes, "n2")


def _claims(comparison: Comparison) -> list[list[object]]:
    missing = "not evaluated, since theirs lacks an output"
    return [
        [verdict("" if b is None else b.status), a.name, a.text, missing if b is None else b.text, a.expected]
        for a, b in comparison.claims
    ]


def _key_figures(comparison: Comparison) -> list[list[object]]:
    theirs = {h.signal: h for h in comparison.theirs.highlights}
    return [
        [h.signal, with_unit(h.final, h.unit), with_unit(t.final, t.unit), h.text, t.text]
        for h in comparison.ours.highlights
        if (t := theirs.get(h.signal)) is not None
    ]


def _fmus(comparison: Comparison) -> dict[str, dict[str, Any]]:
    both = {"ours": comparison.ours, "theirs": comparison.theirs}
    return {whose: result.manifest.get("fmus", {}).get(comparison.block, {}) for whose, result in both.items()}
