"""The page of a run: report.html."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from ..quantities import with_unit
from ..scenario.figures import FigureEntry
from ..system import acting
from . import lateness, plots
from . import view as seen
from .curves import crossings, crossings_text
from .data import RunData, json_text
from .html import Page, facts, fold, header, joined, key, listed, piece, section, table, verdict
from .inputs import inputs

_EXPECTATIONS = ("status", "expectation", "found", "expected", "margin", "signal")
_FMU = ("model", "file", "made by", "isolation", "SHA-256")


def write(result: RunData, path: Path) -> None:
    """Writes the page of a run, with links to the files beside it."""
    there = {name.name for name in path.parent.glob("signals.*")} | {"expectations.json", "manifest.json"}
    path.write_text(page(result, sorted(there, reverse=True)), "utf-8", errors="replace", newline="\n")


@np.errstate(over="ignore", invalid="ignore")
def page(result: RunData, files: Sequence[str] = ()) -> str:
    """Returns the page of a run; `files` are those beside it that it links to."""
    made = Page(result)
    figures = [figure(result, entry, made) for entry in result.scenario.figures] if len(result.time) else []
    view = made.view(seen.view(result, made.arrays))
    first = Markup('<h2 class="unseen">Flight</h2>\n<div class="first{}">{}</div>\n').format(
        " both" if view and figures else "", view + joined(figures[:1])
    )
    parts = [
        _header(result),
        section("Inputs", inputs(result.scenario)),
        first if view or figures else view,
        _facts(result, files),
        section("Expectations", table(_EXPECTATIONS, _expectations(result), "claims")),
        Markup('<div class="columns">\n{}</div>\n').format(_events(result)),
        section("Notes", listed(result.warnings, "notes")),
        _realtime(result, made),
        *(
            [section("Figures", joined(figures[1:]), piece("hint")), *_signals(result, made)]
            if len(result.time)
            else []
        ),
        fmu_table("Blocks", "block", result.manifest.get("fmus", {})),
        manifest_fold(
            "manifest.json", "the scenario as resolved, parameters, versions, platform", public(result.manifest)
        ),
    ]
    return made.html(f"{result.scenario.name}: {_outcome(result)[1]}", parts)


def _outcome(result: RunData) -> tuple[str, str]:
    """Returns a class for its colour, and the outcome in words."""
    reached = f"{result.reached:.10g} s"
    if result.failure is not None:
        return "bad", f"failed after {reached}"
    if result.interrupted:
        return "bad", f"interrupted after {reached}"
    left = f", {len(result.not_evaluated)} not evaluated" if result.not_evaluated else ""
    if not result.outcomes and not left:
        return "plain", "completed; it has no expectations"
    statuses = [outcome.status for outcome in result.outcomes]
    count = len(statuses)
    if result.passed and left:
        return "warn", f"{count} expectation{'s' * (count != 1)} met{left}"
    if result.passed:
        return "good", f"all {count} expectations met" if count > 1 else "the expectation is met"
    counts = {status: statuses.count(status) for status in ("failed", "not reached") if status in statuses}
    return "bad", ", ".join(f"{n} of {count} expectations {status}" for status, n in counts.items()) + left


def _header(result: RunData) -> Markup:
    badges = [_outcome(result)]
    badges += [("warn", f"{hold.name} latched") for hold in result.holds if hold.latched]
    if n := len(result.scenario.faults):
        badges.append(("warn", f"{n} fault{'s' * (n > 1)} injected"))
    failure = Markup('<pre class="failure">{}</pre>\n').format(result.failure) if result.failure else ""
    return header(result.scenario.name, result.scenario.description, badges, failure)


def _facts(result: RunData, files: Sequence[str]) -> Markup:
    scenario, manifest = result.scenario, result.manifest
    speed = f", {result.steps / result.wall:,.0f} steps/s" if result.wall else ""
    return facts(
        {
            "simulated": f"{result.reached:.10g} s" if len(result.time) else "nothing",
            "steps": f"{result.steps} of {scenario.step:.6g} s, {scenario.exchange}",
            "wall time": f"{result.wall:.2f} s{speed}",
            "recorded": f"{len(result.columns)} signals, {len(result.time)} samples",
            "scenario": public(manifest.get("scenario_file") or ""),
            "options": ", ".join(str(public(option)) for option in manifest.get("options", ())),
            "files": Markup(", ").join(Markup('<a href="{0}">{0}</a>').format(name) for name in files),
            "finished": str(manifest.get("finished", "")).replace("T", " ").replace("+00:00", " UTC"),
        }
    )


def _expectations(result: RunData) -> list[list[object]]:
    return [
        [
            verdict(o.status),
            o.name,
            o.text,
            o.expected,
            "" if o.margin is None else with_unit(o.margin, o.unit),
            f"{o.signal}, {o.samples} samples",
        ]
        for o in (*result.outcomes, *result.not_evaluated)
    ]


def _events(result: RunData) -> Markup:
    """Returns the holds, injected faults, timeline, key figures and flags."""
    hold = Markup('<strong class="{}">{}</strong>: {}')
    holds = [hold.format("warn" if h.latched else "name", h.name, h.text) for h in result.holds]
    settled = [[s.signal, s.expected.removeprefix("always "), *s.texts] for s in result.settled]
    figures = [[h.signal, with_unit(h.final, h.unit), h.text] for h in result.highlights]
    return joined(
        [
            section("Holds", listed(holds)),
            section("Injected faults", listed(acting.fault_sentences(result.scenario, result.models, result.reached))),
            section("Timeline", listed(acting.timeline_sentences(result.scenario, result.reached))),
            section("Key figures", table(("signal", "at the end", "largest"), figures)),
            section("Settling", table(("signal", "for good", "from", "rms after", "largest after"), settled)),
            section("Flags raised", listed(result.raised)),
        ]
    )


def _realtime(result: RunData, made: Page) -> Markup:
    """Returns how a paced run kept its deadlines."""
    pace = result.pace
    if pace is None or not len(pace.lateness):
        return Markup("")
    panels = [lateness.histogram(pace, made.arrays), lateness.over_time(pace, made.arrays)]
    late = listed((late.text for late in pace.listed), "notes")
    content = [
        table(("quantity", "p50", "p99", "p99.9", "largest"), lateness.figures(pace)),
        listed(lateness.facts(pace)),
        Markup("<h3>Late steps</h3>\n") + late if late else late,
        made.figure("Lateness of the base steps", panels, kind="n2"),
    ]
    return section("Real time", joined(content))


def figure(result: RunData, entry: FigureEntry, made: Page, over: RunData | None = None) -> Markup:
    """Returns a figure of the scenario; `over` is a run whose curves are drawn over those of `result`."""
    panels = [plots.of_panel(result, entry, panel, made.arrays, over) for panel in entry.panels]
    notes = []
    if entry.shade and (made.live or any(panel["shade"] for panel in panels)):
        notes.append(key("shade", f"shaded: {entry.shade} is true"))
    if entry.mark and made.live:  # whose flights have other times
        notes.append(key("mark", f"dotted: {entry.mark} = 0"))
    elif times := crossings(result, entry):
        notes.append(key("mark", f"dotted: {crossings_text(entry.mark or '', times)}"))
    return made.figure(entry.title or entry.name, panels, notes=notes, kind=f"n{min(len(panels), 3)}")


def _signals(result: RunData, made: Page) -> list[Markup]:
    """Returns what no figure shows: a fold for each block; in the open what is looked at, where the scenario has no
    figures.
    """
    entries = result.scenario.figures
    drawn = {name for e in entries for panel in e.panels if panel.measure == "element" for name in panel.signals}
    groups, left = plots.others(result, made.arrays, drawn)
    expected = [] if entries else [group for group in groups if group.plot is not None and group.expected]
    blocks: dict[str, list[plots.Group]] = {}
    for group in groups:
        if group not in expected:
            blocks.setdefault(group.name.split(".")[0], []).append(group)
    alone = not entries and not expected
    folds = [_block(name, members, made, " paper" if alone else "") for name, members in blocks.items()]
    if left:
        folds.append(Markup("<p>{} more signals are in the signals' file beside this page.</p>\n").format(left))
    in_the_open = joined(_group(group, made, "n1") for group in expected)
    return [
        section("Signals of the expectations", in_the_open, piece("hint")),
        section("Signals" if alone else "Other signals", joined(folds), piece("hint") if alone else ""),
    ]


def _block(name: str, groups: list[plots.Group], made: Page, paper: str) -> Markup:
    moving = [group for group in groups if group.plot is not None]
    still = [[group.name, group.constant, group.description] for group in groups if group.plot is None]
    plotted = f"{len(moving)} plot{'s' * (len(moving) != 1)}" if moving else ""
    constants = Markup("<h3>Constant signals</h3>\n"), table(("signal", "value", "description"), still)
    return fold(
        name,
        ", ".join(filter(None, (plotted, f"{len(still)} constant" if still else ""))),
        (_group(group, made) for group in moving),
        *(constants if still else ()),
        kind=paper,
    )


def _group(group: plots.Group, made: Page, kind: str = "") -> Markup:
    assert group.plot is not None
    notes = [key("shade", "shaded: the values are held")] if group.plot["shade"] else []
    return made.figure(group.name, [group.plot], group.description, [*notes, *filter(None, [group.note])], kind)


def fmu_table(heading: str, first: str, fmus: Mapping[str, Mapping[str, Any]]) -> Markup:
    """Returns the FMUs of a manifest; `first` is the name of the column with their keys."""
    path, code = Markup('<span class="path">{}</span>'), Markup("<code>{}</code>")
    cells = [
        [
            name,
            fmu.get("model") or "",
            path.format(public(fmu.get("file") or "")),
            fmu.get("generation_tool") or "",
            fmu.get("isolation") or "",
            code.format(str(fmu.get("sha256", ""))[:12]),
        ]
        for name, fmu in fmus.items()
    ]
    return section(heading, table((first, *_FMU), cells, "named"))


def manifest_fold(file: str, about: str, data: object) -> Markup:
    """Returns a manifest, folded; nothing where there is none."""
    content = piece("manifest", file=file, about=about, content=json_text(data)) if data else ""
    return section("Manifest", content)


def public(data: Any) -> Any:
    """Returns data without the folders of this machine, for a page that is passed on: a path from the current folder
    on, or its name.
    """
    if isinstance(data, dict):
        return {key: public(value) for key, value in data.items()}
    if isinstance(data, list):
        return [public(value) for value in data]
    if not isinstance(data, str) or not Path(data).is_absolute():
        return data
    here, path = Path.cwd(), Path(data)
    return str(path.relative_to(here)) if path.is_relative_to(here) else path.name
