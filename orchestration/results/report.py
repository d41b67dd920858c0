"""The page of a run: report.html."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from ..quantities import with_unit
from ..scenario.figures import FigureEntry
from ..system import acting
from . import lateness, plots
from . import view as seen
from .data import RunData, json_text
from .html import Page, cards, items, joined, key, part, pieces, rows, verdict

_CROSSINGS = 6
"""Crossings that a caption lists one by one."""
_CLAIMS = ("status", "expectation", "found", "expected", "margin", "signal")
_part = partial(part, "report.html")
_pieces = partial(pieces, "report.html")


def write(result: RunData, path: Path) -> None:
    """Writes the page of a run, with links to the files beside it."""
    there = {name.name for name in path.parent.glob("signals.*")} | {"expectations.json", "manifest.json"}
    path.write_text(page(result, sorted(there, reverse=True)), "utf-8", errors="replace", newline="\n")


@np.errstate(over="ignore", invalid="ignore")
def page(result: RunData, files: Sequence[str] = ()) -> str:
    """The page of a run; `files` are those beside it that it links to."""
    made = Page(result)
    figures = [figure(result, entry, made) for entry in result.scenario.figures] if len(result.time) else []
    view = made.view(seen.view(result, made.arrays))
    parts = [
        _header(result),
        _part("first", joined([view, *figures[:1]]), kind=" both" if view and figures else ""),
        _facts(result, files),
        _part("expectations", rows(_expectations(result), _CLAIMS)),
        _part("columns", _events(result)),
        _part("notes", items(result.warnings)),
        _realtime(result, made),
        *([_part("figures", joined(figures[1:]), hint=_hint()), *_signals(result, made)] if len(result.time) else []),
        fmu_table("Blocks", "block", result.manifest.get("fmus", {})),
        manifest_fold(
            "manifest.json", "the scenario as resolved, parameters, versions, platform", public(result.manifest)
        ),
    ]
    return made.html(f"{result.scenario.name}: {_outcome(result)[1]}", parts)


def _hint() -> Markup:
    return pieces("pieces.html")["hint"]


def _outcome(result: RunData) -> tuple[str, str]:
    """A class for its colour, and the outcome in words."""
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
    scenario = result.scenario
    badges = [_outcome(result)]
    badges += [("warn", f"{hold.name} latched") for hold in result.holds if hold.latched]
    if n := len(scenario.faults):
        badges.append(("warn", f"{n} fault{'s' * (n > 1)} injected"))
    return _pieces()["header"].format(
        name=scenario.name,
        description=scenario.description,
        badges=joined(_pieces()["badge"].format(kind=kind, text=text) for kind, text in badges),
        failure=result.failure or "",
    )


def _facts(result: RunData, files: Sequence[str]) -> Markup:
    scenario, manifest = result.scenario, result.manifest
    speed = f", {result.steps / result.wall:,.0f} steps/s" if result.wall else ""
    links = (Markup('<a href="{}">{}</a>').format(name, name) for name in files)
    return _pieces()["facts"].format(
        simulated=f"{result.reached:.10g} s" if len(result.time) else "nothing",
        steps=f"{result.steps} of {scenario.step:.6g} s, {scenario.exchange}",
        wall=f"{result.wall:.2f} s{speed}",
        recorded=f"{len(result.columns)} signals, {len(result.time)} samples",
        scenario=public(manifest.get("scenario_file") or ""),
        options=", ".join(str(public(option)) for option in manifest.get("options", ())),
        files=Markup(", ").join(links),
        finished=str(manifest.get("finished", "")).replace("T", " ").replace("+00:00", " UTC"),
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
    """Holds, injected faults, key figures, flags."""
    holds = [
        _pieces()["hold"].format(kind="warn" if hold.latched else "name", name=hold.name, text=hold.text)
        for hold in result.holds
    ]
    figures = [[h.signal, with_unit(h.final, h.unit), h.text] for h in result.highlights]
    return joined(
        [
            _part("holds", items(holds)),
            _part("faults", items(acting.fault_sentences(result.scenario, result.models, result.reached))),
            _part("timeline", items(acting.timeline_sentences(result.scenario, result.reached))),
            _part("key_figures", rows(figures)),
            _part("flags", items(result.raised)),
        ]
    )


def _realtime(result: RunData, made: Page) -> Markup:
    """How a paced run kept its deadlines."""
    pace = result.pace
    if pace is None or not len(pace.lateness):
        return Markup("")
    panels = [lateness.histogram(pace, made.arrays), lateness.over_time(pace, made.arrays)]
    return _part(
        "realtime",
        rows(lateness.figures(pace)),
        facts=items(lateness.facts(pace)),
        late=_part("late", items(late.text for late in pace.listed)),
        figure=made.figure("Lateness of the base steps", panels, kind="n2"),
    )


def figure(result: RunData, entry: FigureEntry, made: Page, over: RunData | None = None) -> Markup:
    """A figure of the scenario; `over` is a run whose curves are drawn over those of `result`."""
    panels = [plots.of_panel(result, entry, panel, made.arrays, over) for panel in entry.panels]
    notes = []
    if entry.shade and (made.live or any(panel["shade"] for panel in panels)):
        notes.append(key("shade", f"shaded: {entry.shade} is true"))
    if entry.mark and made.live:  # whose flights have other times
        notes.append(key("mark", f"dotted: {entry.mark} = 0"))
    elif times := plots.crossings(result, entry):
        listed = ", ".join(f"{time:.2f} s" for time in times[:_CROSSINGS])
        more = f" and {len(times) - _CROSSINGS} more" if len(times) > _CROSSINGS else ""
        notes.append(key("mark", f"dotted: {entry.mark} = 0 at {listed}{more}"))
    return made.figure(entry.title or entry.name, panels, notes=notes, kind=f"n{min(len(panels), 3)}")


def _signals(result: RunData, made: Page) -> list[Markup]:
    """What no figure shows: a fold for each block; in the open what is looked at, where the scenario has no figures."""
    entries = result.scenario.figures
    drawn = {name for e in entries for panel in e.panels if panel.measure == "element" for name in panel.signals}
    groups, left = plots.others(result, made.arrays, drawn)
    expected = [] if entries else [group for group in groups if group.plot is not None and group.expected]
    blocks: dict[str, list[plots.Group]] = {}
    for group in groups:
        if group not in expected:
            blocks.setdefault(group.name.split(".")[0], []).append(group)
    in_the_open = joined(_group(group, made, "n1") for group in expected)
    alone = not entries and not expected
    folds = [_block(name, members, made, " paper" if alone else "") for name, members in blocks.items()]
    if left:
        folds.append(_pieces()["left_out"].format(count=left))
    return [
        _part("expected_signals", in_the_open, hint=_hint()),
        _part("signals", joined(folds), hint=_hint()) if alone else _part("other_signals", joined(folds)),
    ]


def _block(name: str, groups: list[plots.Group], made: Page, paper: str) -> Markup:
    moving = [group for group in groups if group.plot is not None]
    still = [[group.name, group.constant, group.description] for group in groups if group.plot is None]
    plotted = f"{len(moving)} plot{'s' * (len(moving) != 1)}" if moving else ""
    return _pieces()["block"].format(
        block=name,
        count=", ".join(filter(None, (plotted, f"{len(still)} constant" if still else ""))),
        plots=joined(_group(group, made) for group in moving),
        constants=_part("constants", rows(still)),
        paper=paper,
    )


def _group(group: plots.Group, made: Page, kind: str = "") -> Markup:
    assert group.plot is not None
    notes = [key("shade", "shaded: the values are held")] if group.plot["shade"] else []
    return made.figure(group.name, [group.plot], group.description, [*notes, *filter(None, [group.note])], kind)


def fmu_table(heading: str, first: str, fmus: Mapping[str, Mapping[str, Any]]) -> Markup:
    """The FMUs of a manifest; `first` is the name of the column with their keys."""
    path, code = Markup('<span class="path">{}</span>'), Markup("<code>{}</code>")
    piece = pieces("pieces.html")["fmus"]
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
    return piece.format(heading=heading, first=first, content=cards(piece, cells)) if cells else Markup("")


def manifest_fold(file: str, about: str, data: object) -> Markup:
    """A manifest, folded; nothing where there is none."""
    text = json_text(data) if data else ""
    return part("pieces.html", "manifest", text, file=file, about=about)


def public(data: Any) -> Any:
    """Data without the folders of this machine, for a page that is passed on: a path from the current folder on, or its name."""
    if isinstance(data, dict):
        return {key: public(value) for key, value in data.items()}
    if isinstance(data, list):
        return [public(value) for value in data]
    if not isinstance(data, str) or not Path(data).is_absolute():
        return data
    here, path = Path.cwd(), Path(data)
    return str(path.relative_to(here)) if path.is_relative_to(here) else path.name
