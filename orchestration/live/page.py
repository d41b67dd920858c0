"""The live page as HTML: controls, the figures of the native run, and all that flies it again."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

from markupsafe import Markup

from ..quantities import ONE
from ..results import phases
from ..results import view as seen
from ..results.curves import window
from ..results.data import RunData
from ..results.html import Page, asset, joined, piece, pieces, section
from ..results.report import figure
from ..scenario.faults import sentence
from ..scenario.figures import FigureEntry, Panel
from ..scenario.references import Reference
from ..system.faults import Faults
from ..system.panels import unit_of
from ..system.wiring import Node
from .motion import columns, motion
from .sliders import Control
from .system import Live
from .verdicts import OBSERVED, observed, verdicts

_POLICY = " 'wasm-unsafe-eval'; worker-src blob:"
_HERE = Path(__file__).parent
_BADGES = Markup('<span class="badge plain" id="verdict">flying</span> <span class="badge plain" id="speed"></span>')
_PLOTS = 6
"""Plots of a scenario that has no figures."""


def page(live: Live, native: RunData) -> str:
    """Returns the page; `native` is the run of the scenario as it stands."""
    parts, entries, scenario = pieces(_HERE / "page.html"), _entries(native), live.scenario
    made = Page(native, live=True, faults=bool(live.faults))
    figures = [figure(native, entry, made) for entry in entries]
    shown = seen.view(native, made.arrays)
    first = parts["first"].format(
        kind=" both" if shown else "",
        view=made.view(shown),
        first=figures[0],
        name=scenario.name,
        sliders=joined(_slider(parts["slider"], *entry) for entry in enumerate(live.controls)),
        faults=_buttons(live, parts["fault"]),
        expected=_expected(live, parts),
        hash=native.sha256,
        file=_file(live),
    )
    body = [
        piece("header", title=scenario.name, lead=scenario.description, badges=_BADGES, content=""),
        first,
        section("Figures", joined(figures[1:]), piece("hint")),
    ]
    flown = {
        "plots": [_plot(native, entry, panel) for entry in entries for panel in entry.panels],
        "phases": columns(native, phases.conditions(native)) if scenario.phases else None,
        "view": shown and motion(native, shown),
    }
    script, style = asset(_HERE / "page.js"), asset(_HERE / "page.css")
    data = {"live": {**_data(live, flown), "hash": native.sha256, "verdicts": _found(native)}}
    return made.html(f"{scenario.name}: live", body, script, _POLICY, style, data)


def _found(native: RunData) -> list[dict[str, Any]]:
    """Returns the outcomes of the native run as the worker gives those of a flight."""
    return [{"status": o.status, "value": o.found, "time": o.time} for o in native.outcomes]


def _slider(piece: Markup, number: int, control: Control) -> Markup:
    return piece.format(
        label=control.slider.label or control.slider.start,
        least=repr(control.least),
        most=repr(control.most),
        value=repr(control.value),
        number=number,
        unit="" if control.unit == "1" else control.unit,
    )


def _expected(live: Live, parts: dict[str, Markup]) -> Markup:
    """Returns a row for each expectation; nothing where there is none."""
    rows = [
        parts["row"].format(number=i, name=check.expectation.name, expected=check.expected)
        for i, check in enumerate(live.opened.plan.checks)
    ]
    return parts["expected"].format(rows=joined(rows)) if rows else Markup("")


def _buttons(live: Live, piece: Markup) -> Markup:
    """Returns a button for each fault; one that does nothing in a shortened run is disabled."""
    own = len(live.scenario.faults)
    added = live.scenario.live.faults if live.scenario.live else []
    owned = (sentence(fault).rpartition(", from ")[0] for fault in live.scenario.faults)
    names = [*owned, *(fault.name for fault in added)]
    return joined(
        piece.format(
            number=i,
            pressed=str(i < own).lower(),
            state="" if does else " disabled",
            text=sentence(fault),
            name=name,
            at=f"{fault.at:g}",
        )
        for i, (fault, does, name) in enumerate(zip(live.faults, live.each, names, strict=True))
    )


def _entries(native: RunData) -> list[FigureEntry]:
    """Returns the scenario's figures; where it has none, one for each of some signals."""
    if native.scenario.figures:
        return native.scenario.figures
    expected = [entry.signal for entry in native.scenario.expect if entry.signal in native]
    names = list(dict.fromkeys(expected or native))[:_PLOTS]
    return [FigureEntry(name="signal", title=n, panels=[Panel(signals=[Reference(n)])]) for n in names]


def _file(live: Live) -> str:
    return (live.scenario.source.file or "").replace("\\", "/").rpartition("/")[2]


def _data(live: Live, flown: dict[str, Any]) -> dict[str, Any]:
    clock, scenario = live.opened.plan.clock, live.scenario
    return {
        "name": scenario.name,
        "file": _file(live),
        "step": scenario.step,
        "duration": scenario.duration,
        "wasm": base64.b64encode(live.wasm).decode("ascii"),
        "worker": asset(_HERE / "worker.js"),
        "starts": live.tables.values,
        "controls": [_control(live, control) for control in live.controls],
        "faults": [
            {
                "own": i < len(scenario.faults),
                "data": fault.model_dump(mode="json", exclude_none=True),
                "most": _latest(live, does),
            }
            for i, (fault, does) in enumerate(zip(live.faults, live.each, strict=True))
        ],
        "given": {
            "steps": clock.steps,
            "interval": clock.interval,
            "stretch": OBSERVED,
            "observed": len(observed(live.opened.plan)),
            "expect": verdicts(live.opened.plan),
            "numerator": clock.numerator,
            "denominator": clock.denominator,
            "columns": len(live.opened.plan.columns),
            **flown,
        },
    }


def _latest(live: Live, does: Faults) -> int:
    """Returns the last count of base steps at which a fault may begin: a step of each block that it acts on sees it."""
    steps, blocks = live.opened.plan.clock.steps, live.scenario.blocks
    acted = [setting.block for setting in does.settings] + [each.target.block for each in does.disturbances]
    every = max((blocks[name].every for name in acted), default=1)
    return (steps // every - (2 if does.disturbances else 1)) * every


def _control(live: Live, control: Control) -> dict[str, Any]:
    places = live.tables.places
    names = []
    for nodes in control.nodes:
        block, element = nodes[0]
        variable = live.opened.plan.models[block].variables[element.variable]
        whole = [Node(block, each) for each in variable.elements]
        named = whole if all(node in places for node in whole) else nodes
        name = variable.name if named is whole else variable.label(element.position)
        shape = variable.shape if named is whole else ()
        names.append({"block": block, "name": name, "shape": shape, "places": [places[node] for node in named]})
        names += [each for each in _helped(live, block) if each["name"] != name]
    return {
        "start": control.slider.start,
        "measure": control.slider.measure,
        "axis": control.slider.axis,
        "unit": control.unit,
        "factor": control.factor,
        "offset": control.offset,
        "places": [[places[node] for node in nodes] for nodes in control.nodes],
        "names": names,
    }


def _helped(live: Live, block: str) -> list[dict[str, Any]]:
    """Returns what helper inputs of a block give: the page keeps it where a slider changes what it rests on."""
    model, places = live.opened.plan.models[block], live.tables.places
    stated = {name.variable for name in (*live.scenario.shared, *live.scenario.blocks[block].start)}
    given = [model.variables[helper.gives] for name, helper in model.helpers.items() if name in stated]
    nodes = [(variable, [Node(block, element) for element in variable.elements]) for variable in given]
    return [
        {"block": block, "name": variable.name, "shape": variable.shape, "places": [places[node] for node in each]}
        for variable, each in nodes
        if all(node in places for node in each)
    ]


def _plot(native: RunData, entry: FigureEntry, panel: Panel) -> dict[str, Any]:
    """Returns how the curves of a panel come from the recorded columns."""
    curves: list[dict[str, Any]] = []
    for name in panel.signals:
        variable, columns = native.variable(name), native.places(name)
        factor, offset = (variable.unit or ONE).conversion(unit_of(panel, variable))
        norm = panel.measure == "norm"
        groups = [columns] if norm else [[column] for column in columns]
        curves += [{"columns": group, "norm": norm, "factor": factor, "offset": offset} for group in groups]
    shade = native.places(entry.shade)[0] if entry.shade else None
    mark = native.places(entry.mark)[0] if entry.mark else None
    return {"curves": curves, "shade": shade, "mark": mark, "window": window(native, entry)}
