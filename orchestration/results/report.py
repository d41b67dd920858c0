"""The page of a run: report.html, which holds all that it shows and asks no network for anything.

Text goes into it through `tag`, which escapes whatever is not `Html`; data as JSON in a script element that no
browser executes. Its security policy lets no other script run than the two that are written here, by their hashes.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ..expectations.checks import Outcome
from ..quantities import with_unit
from ..scenario.faults import sentence
from . import report_plots as plots
from .data import RunData
from .figures import COLOURS

NAME = "report.html"
_ASSETS = Path(__file__).parent / "assets"
_CROSSINGS = 6
"""Crossings that a caption tells one by one."""


class Html(str):
    """Text that is HTML already."""

    __slots__ = ()


def tag(name: str, *children: object, **attributes: object) -> Html:
    """An element. Children and attributes are escaped, but for children that are `Html`; lists of them are taken apart."""
    flat = [c for child in children for c in (child if isinstance(child, (list, tuple)) else (child,))]
    inside = "".join(c if isinstance(c, Html) else escape(str(c)) for c in flat)
    given = "".join(f' {key.rstrip("_").replace("_", "-")}="{escape(str(value))}"' for key, value in attributes.items())
    return Html(f"<{name}{given}>{inside}</{name}>")


def write(result: RunData, path: Path) -> None:
    """Writes the page of a run."""
    path.write_text(page(result), "utf-8", errors="replace", newline="\n")


def page(result: RunData) -> str:
    """The page of a run."""
    arrays = plots.Arrays()
    shown: list[dict[str, Any]] = []
    parts = [_head(result), _claims(result), _events(result), _warnings(result)]
    if len(result.time):
        parts += [_figures(result, arrays, shown), _signals(result, arrays, shown)]
    parts += [_made_of(result), _manifest(result)]
    scenario = result.scenario
    data = {
        "colours": COLOURS,
        "cycle": scenario.cycle and {"name": scenario.cycle.name, "period": scenario.cycle.period},
        "faults": plots.faulty(result) if len(result.time) else [],
        "arrays": arrays.items,
        "plots": shown,
    }
    # A function of its own gives the library a screen of two pixels to the point at least, for the sake of paper.
    library = f"const uPlot = ((devicePixelRatio) => {{\n{_asset('uPlot.iife.min.js')}\nreturn uPlot;\n}})(Math.max(2, window.devicePixelRatio || 1));"
    scripts = [library + "\n" + _asset("report.js")]
    hashes = " ".join(f"'sha256-{base64.b64encode(hashlib.sha256(s.encode()).digest()).decode()}'" for s in scripts)
    policy = f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'"
    return "\n".join(
        [
            "<!doctype html>",
            '<html lang="en">',
            "<head>",
            '<meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{escape(policy)}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            '<meta name="color-scheme" content="light dark">',
            '<link rel="icon" href="data:,">',
            tag("title", f"{scenario.name}: {_verdict(result)[1]}"),
            f"<style>{_asset('uPlot.min.css')}\n{_asset('report.css')}</style>",
            "</head>",
            "<body>",
            "<main>",
            *(part for part in parts if part),
            "</main>",
            f'<script type="application/json" id="data">{embedded(data)}</script>',
            *(f"<script>{script}</script>" for script in scripts),
            "</body>",
            "</html>",
            "",
        ]
    )


def embedded(data: object) -> str:
    """JSON that can end no script element. Raises ValueError for a number that JSON does not know."""
    text = json.dumps(data, allow_nan=False, ensure_ascii=True, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _asset(name: str) -> str:
    return (_ASSETS / name).read_text("utf-8").replace("\r\n", "\n")


def _verdict(result: RunData) -> tuple[str, str]:
    """A class for its colour, and the outcome in words."""
    reached = f"{result.time[-1]:.10g} s" if len(result.time) else "0 s"
    if result.failure is not None:
        return "bad", f"failed after {reached}"
    if result.interrupted:
        return "bad", f"interrupted after {reached}"
    count, failed = len(result.outcomes), sum(not outcome.passed for outcome in result.outcomes)
    if failed:
        return "bad", f"{failed} of {count} expectations failed" if count > 1 else "the expectation failed"
    if not count:
        return "plain", "ran to its end; nothing was expected of it"
    return "good", f"all {count} expectations met" if count > 1 else "the expectation is met"


def _head(result: RunData) -> Html:
    scenario, manifest = result.scenario, result.manifest
    kind, said = _verdict(result)
    badges = [tag("span", said, class_=f"badge {kind}")]
    badges += [tag("span", f"{hold.name} latched", class_="badge warn") for hold in result.holds if hold.latched]
    if scenario.faults:
        n = len(scenario.faults)
        badges.append(tag("span", f"{n} fault{'s' * (n > 1)} injected", class_="badge warn"))
    facts = [
        ("simulated", f"{result.time[-1]:.10g} s" if len(result.time) else "nothing"),
        ("steps", f"{result.steps} of {scenario.step:.6g} s, {scenario.exchange}"),
        ("took", f"{result.wall:.2f} s" + (f", {result.steps / result.wall:,.0f} steps/s" if result.wall else "")),
        ("recorded", f"{len(result.columns)} signals, {len(result.time)} samples"),
        ("scenario", manifest.get("scenario_file") or ""),
        ("options", ", ".join(map(str, manifest.get("options", ())))),
        ("finished", str(manifest.get("finished", "")).replace("T", " ").replace("+00:00", " UTC")),
    ]
    return tag(
        "header",
        tag("h1", scenario.name),
        tag("p", scenario.description, class_="lead") if scenario.description else "",
        tag("p", badges, class_="badges"),
        tag("pre", str(result.failure), class_="failure") if result.failure is not None else "",
        tag("dl", [tag("div", tag("dt", key), tag("dd", value)) for key, value in facts if value], class_="facts"),
    )


def _claims(result: RunData) -> Html:
    if not result.outcomes:
        return Html()
    rows = [
        [
            tag("span", "ok" if o.passed else "failed", class_="good" if o.passed else "bad"),
            o.name,
            o.text,
            o.expected,
            "" if o.margin is None else with_unit(o.margin, o.unit),
            _looked_at(o),
        ]
        for o in result.outcomes
    ]
    return _section(
        "Expectations", _table(("", "expectation", "found", "expected", "margin", "looked at"), rows, "claims")
    )


def _looked_at(outcome: Outcome) -> str:
    return f"{outcome.signal}, {outcome.samples} samples"


def _events(result: RunData) -> Html:
    """Holds, faults, flags, and the signals that the expectations look at in two numbers."""
    items = [
        tag("li", tag("strong", hold.name, class_="warn" if hold.latched else "name"), f": {hold.text}")
        for hold in result.holds
    ]
    parts = [_section("Holds", tag("ul", items))] if items else []
    if result.scenario.faults:
        parts.append(_section("Faults", tag("ul", [tag("li", sentence(fault)) for fault in result.scenario.faults])))
    rows = [
        [h.signal, with_unit(h.final, h.unit), f"{with_unit(h.peak, h.unit)} at {h.time:.5g} s"]
        for h in result.highlights
    ]
    if rows:
        parts.append(_section("Signals in two numbers", _table(("signal", "at the end", "largest"), rows)))
    true = [f"{name} first at {since:.5g} s" for name, since in result.flags.items() if since is not None]
    if true:
        parts.append(_section("True at some time", tag("ul", [tag("li", text) for text in true])))
    return tag("div", parts, class_="columns") if parts else Html()


def _warnings(result: RunData) -> Html:
    items = [tag("li", warning) for warning in result.warnings]
    return _section("Notes", tag("ul", items, class_="notes")) if items else Html()


# ---------------------------------------------------------------- plots


def _figures(result: RunData, arrays: plots.Arrays, shown: list[dict[str, Any]]) -> Html:
    figures = []
    for entry in result.scenario.figures:
        panels = [plots.of_panel(result, entry, panel, arrays) for panel in entry.panels]
        legend = []
        if entry.shade and any(panel["shade"] for panel in panels):
            legend.append(f"shaded: {entry.shade}")
        if times := plots.crossings(result, entry):
            told = ", ".join(f"{time:.2f} s" for time in times[:_CROSSINGS])
            more = f" and {len(times) - _CROSSINGS} more" if len(times) > _CROSSINGS else ""
            legend.append(f"dotted: {entry.mark} = 0 at {told}{more}")
        caption = _caption(result, panels, legend)
        figures.append(
            tag(
                "figure",
                tag("h3", entry.title or entry.name),
                tag("div", [_place(panel, shown) for panel in panels], class_=f"panels n{min(len(panels), 3)}"),
                caption,
            )
        )
    if not figures:
        return Html()
    return _section("Figures", _hint(), figures)


def _caption(result: RunData, panels: Sequence[dict[str, Any]], legend: list[str]) -> Html:
    if any(panel["lines"] for panel in panels):
        legend.append("dashed: limits")
    if result.scenario.faults:
        legend.append("red: faults")
    if any(panel["thinned"] for panel in panels):
        legend.append("thinned out; lowest and highest values are kept")
    return tag("figcaption", "; ".join(legend)) if legend else Html()


def _hint() -> Html:
    return tag(
        "p",
        "Drag across a plot to zoom, double-click to see all; click a name to hide its curve.",
        tag("noscript", " The plots need JavaScript; the signals' file beside this page has their data."),
        class_="hint",
    )


def _place(plot: dict[str, Any], shown: list[dict[str, Any]], name: str = "") -> Html:
    shown.append(plot)
    return tag("div", "", class_="plot", data_plot=len(shown) - 1, role="group", aria_label=name or plot["label"])


def _signals(result: RunData, arrays: plots.Arrays, shown: list[dict[str, Any]]) -> Html:
    """What no figure shows: a fold for each block; in the open what is looked at, where the scenario has no figures."""
    entries = result.scenario.figures
    drawn = {name for e in entries for panel in e.panels if panel.measure == "element" for name in panel.signals}
    groups, left = plots.others(result, arrays, drawn)
    looked_at = [] if entries else [group for group in groups if group.plot is not None and group.expected]
    blocks: dict[str, list[plots.Group]] = {}
    for group in groups:
        if group not in looked_at:
            blocks.setdefault(group.name.split(".")[0], []).append(group)
    folds = []
    for block, members in blocks.items():
        moving = [group for group in members if group.plot is not None]
        still = [[group.name, group.constant, group.description] for group in members if group.plot is None]
        folds.append(
            tag(
                "details",
                tag("summary", tag("strong", block), f" {_count(len(moving), len(still))}"),
                tag("div", [_group(result, group, shown) for group in moving], class_="grid") if moving else "",
                [tag("h3", "Constant"), _table(("signal", "value", "description"), still)] if still else "",
                class_="signals" if entries or looked_at else "signals paper",
            )
        )
    if left:
        folds.append(tag("p", f"{left} more signals are in the signals' file beside this page."))
    parts = []
    if looked_at:
        parts.append(
            _section(
                "What the expectations look at", _hint(), [_group(result, group, shown, "n1") for group in looked_at]
            )
        )
    if folds:
        parts.append(
            _section(
                "Other signals" if entries or looked_at else "Signals", "" if entries or looked_at else _hint(), folds
            )
        )
    return Html("\n".join(parts))


def _group(result: RunData, group: plots.Group, shown: list[dict[str, Any]], kind: str = "") -> Html:
    assert group.plot is not None
    return tag(
        "figure",
        tag("h3", group.name, tag("small", group.description)),
        tag("div", _place(group.plot, shown, group.name), class_=f"panels {kind}".strip()),
        _caption(result, [group.plot], [group.note] if group.note else []),
    )


def _count(moving: int, still: int) -> str:
    plotted = f"{moving} plot{'s' * (moving != 1)}" if moving else ""
    return ", ".join(filter(None, (plotted, f"{still} constant" if still else "")))


# ---------------------------------------------------------------- what it was made of


def _made_of(result: RunData) -> Html:
    fmus = result.manifest.get("fmus", {})
    rows = [
        [
            name,
            str(fmu.get("model") or ""),
            tag("span", str(fmu.get("file") or ""), class_="path"),
            str(fmu.get("generation_tool") or ""),
            str(fmu.get("isolation") or ""),
            tag("code", str(fmu.get("sha256", ""))[:12]),
        ]
        for name, fmu in fmus.items()
    ]
    return (
        _section("Blocks", _table(("block", "model", "file", "made by", "isolation", "SHA-256"), rows))
        if rows
        else Html()
    )


def _manifest(result: RunData) -> Html:
    if not result.manifest:
        return Html()
    text = json.dumps(result.manifest, indent=2, ensure_ascii=False, default=_plain)
    summary = tag(
        "summary", tag("strong", "manifest.json"), " the scenario as resolved, parameters, versions, platform"
    )
    return _section("Manifest", tag("details", summary, tag("pre", text, class_="manifest")))


def _plain(value: object) -> object:
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else str(value)


def _section(title: str, *children: object) -> Html:
    return tag("section", tag("h2", title), *children)


def _table(header: Sequence[str], rows: Sequence[Sequence[object]], kind: str = "plain") -> Html:
    head = tag("thead", tag("tr", [tag("th", cell, scope="col") for cell in header]))
    body = tag("tbody", [tag("tr", [tag("td", cell) for cell in row]) for row in rows])
    return tag("div", tag("table", head, body, class_=kind), class_="scroll")
