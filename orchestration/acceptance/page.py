"""The page of a comparison: comparison.html, which holds all that it shows."""

from __future__ import annotations

import base64
import io
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..quantities import ONE, with_unit
from ..results import figures
from ..results.result import Result
from .compare import DIFFERENCES, Comparison, rows_of_differences, verdict

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1a1a1a; max-width: 74rem; margin: 2rem auto; padding: 0 1.5rem; }
h1 { font-size: 1.5rem; margin-bottom: 0; } h2 { font-size: 1.15rem; margin: 2.2rem 0 .4rem; } p { margin: .4rem 0; max-width: 60rem; }
.lead { color: #555; } .verdict { display: inline-block; margin: 1rem 0 0; padding: .5rem .9rem; border-radius: .4rem; font-weight: 600; }
.yes { background: #e3f4ea; color: #0a5c33; } .no { background: #fbe6e3; color: #93210f; }
table { border-collapse: collapse; margin: .6rem 0; font-variant-numeric: tabular-nums; } th { text-align: left; font-weight: 600; }
th, td { padding: .28rem 1.1rem .28rem 0; border-bottom: 1px solid #e4e4e4; vertical-align: top; } td.mark { font-weight: 600; white-space: nowrap; }
td.ok { color: #0a7d45; } td.bad { color: #b3261e; } td.none { color: #777; } img { max-width: 100%; margin: .4rem 0; } li { margin: .15rem 0; }
@media (prefers-color-scheme: dark) { body { background: #fff; } }
"""


def write(comparison: Comparison, folder: Path) -> Path:
    """Writes the page and returns its path. Raises InputError without Matplotlib, or where it cannot be written."""
    scenario, theirs = comparison.ours.scenario, Path(comparison.fmu).name
    parts = [
        f"<h1>{escape(comparison.block)} against {escape(theirs)}</h1>",
        f'<p class="lead">{escape(scenario.name)}: {escape(scenario.description)}</p>',
        f'<p class="verdict {"yes" if comparison.passed else "no"}">{escape(verdict(comparison))}</p>',
    ]
    if comparison.failure is not None:
        parts.append(f"<h2>Failure</h2><pre>{escape(str(comparison.failure))}</pre>")
    parts += [
        _open_loop(comparison),
        _closed_loop(comparison),
        _figures(comparison),
        _notes(comparison),
        _made_of(comparison),
    ]
    title = f"{comparison.block} against {theirs}"
    text = (
        f'<!doctype html>\n<html lang="en">\n<meta charset="utf-8">\n<meta name="viewport" content="width=device-width">\n'
        f"<title>{escape(title)}</title>\n<style>{_STYLE}</style>\n<body>\n" + "\n".join(parts) + "\n</body>\n</html>\n"
    )
    path = folder / "comparison.html"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    return path


def _table(header: tuple[str, ...], rows: list[tuple[str, tuple[str, ...]]]) -> str:
    """Rows with a mark before them: ok, or what is wrong; none for a dash."""
    classes = {"ok": "ok", "": "none"}
    head = "".join(f"<th>{escape(cell)}</th>" for cell in ("", *header))
    body = "".join(
        f'<tr><td class="mark {classes.get(mark, "bad")}">{mark or "&ndash;"}</td>'
        + "".join(f"<td>{escape(cell)}</td>" for cell in cells)
        + "</tr>"
        for mark, cells in rows
    )
    return f"<table><tr>{head}</tr>{body}</table>"


def _open_loop(comparison: Comparison) -> str:
    rows = [
        ("" if not cells[5] else "ok" if passed else "differs", cells)
        for passed, cells in rows_of_differences(comparison)
    ]
    text = (
        f"<h2>Open loop</h2><p>What our block was given in the run, every {comparison.interval:.10g} s, was given to theirs. "
        "The difference of an output is the largest of all its elements and instants; relative means over our output's largest value.</p>"
    )
    return text + _table(DIFFERENCES, rows) + _picture(_outputs(comparison), "open loop")


def _closed_loop(comparison: Comparison) -> str:
    claims: list[tuple[str, tuple[str, ...]]] = [
        (
            "" if b is None else "ok" if b.passed else "failed",
            (a.name, a.text, "not judged, since theirs lacks an output" if b is None else b.text, a.expected),
        )
        for a, b in comparison.claims
    ]
    theirs = {h.signal: h for h in comparison.theirs.highlights}
    peaks = [
        (h.signal, with_unit(h.final, h.unit), with_unit(t.final, t.unit), _peak(h), _peak(t))
        for h in comparison.ours.highlights
        if (t := theirs.get(h.signal)) is not None
    ]
    text = "<h2>Closed loop</h2><p>The whole run twice: with our block, and with theirs in its place. The mark is that of theirs.</p>"
    text += _table(("claim", "ours", "theirs", "expected"), claims)
    head = "".join(
        f"<th>{cell}</th>"
        for cell in ("signal", "ours at the end", "theirs at the end", "ours, largest", "theirs, largest")
    )
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in peaks)
    return text + (f"<table><tr>{head}</tr>{body}</table>" if peaks else "")


def _peak(highlight: Any) -> str:
    return f"{with_unit(highlight.peak, highlight.unit)} at {highlight.time:.5g} s"


def _notes(comparison: Comparison) -> str:
    items = "".join(f"<li>{escape(note)}</li>" for note in comparison.theirs.warnings)
    return f"<h2>What to know</h2><ul>{items}</ul>" if items else ""


def _made_of(comparison: Comparison) -> str:
    rows = []
    for whose, result in (("ours", comparison.ours), ("theirs", comparison.theirs)):
        fmu = result.manifest.get("fmus", {}).get(comparison.block, {})
        rows.append(
            (
                "ok" if fmu else "",
                (whose, str(fmu.get("model", "")), str(fmu.get("file", "")), str(fmu.get("sha256", ""))[:16]),
            )
        )
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>" for _, cells in rows)
    return f"<h2>Compared</h2><table><tr><th></th><th>model</th><th>file</th><th>SHA-256</th></tr>{body}</table>"


# ---------------------------------------------------------------- pictures


def _picture(figure: Any, name: str) -> str:
    if figure is None:
        return ""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    data = base64.b64encode(buffer.getvalue()).decode()
    return f'<p><img alt="{escape(name)}" src="data:image/png;base64,{data}"></p>'


def _figure(width: float, height: float) -> Any:
    try:
        from matplotlib.figure import Figure
    except ModuleNotFoundError:
        raise InputError("the page needs Matplotlib: pip install matplotlib") from None
    return Figure(figsize=(width, height), dpi=110, layout="constrained")


def _outputs(comparison: Comparison) -> Any:
    """Each compared output of ours and theirs over the other, and below it their difference."""
    played, ours = comparison.played, comparison.ours
    names = [d.output for d in comparison.differences if d.largest is not None]
    if not names:
        return None
    columns = min(3, len(names))
    lines = -(-len(names) // columns)
    figure = _figure(4.3 * columns, 3.4 * lines)
    outer = figure.subfigures(lines, columns, squeeze=False)
    time = ours.time[played.rows]
    for place, name in zip(outer.flat, names, strict=False):
        variable = ours.models[comparison.block].variables[name]
        unit = variable.display_unit if variable.display_unit is not None else variable.unit or ONE
        factor, offset = (variable.unit or ONE).conversion(unit)
        a = ours[f"{comparison.block}.{name}"].reshape(len(ours.time), -1)[played.rows].astype(float)
        b = played.outputs[name]
        above, below = place.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        for i in range(a.shape[1]):
            colour = figures.COLOURS[i % len(figures.COLOURS)]
            above.plot(time, factor * a[:, i] + offset, color=colour, linewidth=2.2, alpha=0.4)
            above.plot(time, factor * b[:, i] + offset, color=colour, linewidth=0.9)
            below.plot(time, factor * (b[:, i] - a[:, i]), color=colour, linewidth=0.8)
        shown = f", {unit}" if str(unit) != "1" else ""
        above.set_title(f"{name}{shown}", fontsize=9)
        below.set_ylabel("difference", fontsize=8)
        below.set_xlabel("time, s", fontsize=8)
        for axes in (above, below):
            _plain(axes, time)
    figure.suptitle("Open loop: ours wide and pale, theirs thin", fontsize=9)
    return figure


def _plain(axes: Any, time: Any) -> None:
    axes.set_xlim(time[0], time[-1])
    axes.tick_params(labelsize=7)
    axes.grid(True, color="0.92", linewidth=0.6)
    axes.set_axisbelow(True)


def _figures(comparison: Comparison) -> str:
    """The scenario's figures, with theirs drawn over ours where it has the signals."""
    parts = []
    for entry in comparison.ours.scenario.figures:
        figure = _figure(4.9 * len(entry.panels), 3.3)
        all_axes = np.ravel(figure.subplots(1, len(entry.panels)))
        for panel, axes in zip(entry.panels, all_axes, strict=True):
            figures.draw_panel(axes, panel, entry.model_copy(update={"shade": None, "mark": None}), comparison.ours)
            for line in axes.lines:
                line.set_alpha(0.4)
                line.set_linewidth(2.2 if line.get_linestyle() == "-" else 0.8)
            _over(axes, panel, comparison.theirs, comparison.ours)
        figure.suptitle(f"{entry.title or entry.name} (ours wide and pale, theirs thin)", fontsize=10)
        parts.append(_picture(figure, entry.name))
    return "<h2>Figures</h2>" + "".join(parts) if parts else ""


def _over(axes: Any, panel: Any, theirs: Result, ours: Result) -> None:
    """Theirs over ours in the same colours."""
    count = 0
    time = theirs.time
    for reference in panel.signals:
        variable = ours.variable(reference)
        curves = figures.curves(ours, reference, variable, panel)
        if reference in theirs or reference.partition("[")[0] in theirs:
            own = theirs.variable(reference)
            factor, offset = (own.unit or ONE).conversion(figures.unit_of(panel, own))
            for i, (_, values) in enumerate(figures.curves(theirs, reference, own, panel)):
                axes.plot(
                    time,
                    factor * values + offset,
                    color=figures.COLOURS[(count + i) % len(figures.COLOURS)],
                    linewidth=0.9,
                )
        count += len(curves)
