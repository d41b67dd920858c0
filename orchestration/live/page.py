"""The live page as HTML: controls, the figures of the native run, and all that flies it again."""

from __future__ import annotations

import base64
from typing import Any

from markupsafe import Markup

from ..quantities import ONE
from ..results import phases
from ..results import view as seen
from ..results.data import RunData
from ..results.html import Page, asset, joined, pieces
from ..results.report import figure
from ..scenario.faults import sentence
from ..scenario.figures import FigureEntry, Panel
from ..scenario.live import LiveFault
from ..scenario.references import Reference
from ..system.panels import unit_of
from ..system.wiring import Node
from .motion import columns, motion
from .sliders import Control
from .system import Live

_POLICY = " 'wasm-unsafe-eval'; worker-src blob:"
_PLOTS = 6
"""Plots of a scenario that has no figures."""


def page(live: Live, native: RunData) -> str:
    """The page; `native` is the run of the scenario as it stands."""
    parts, entries = pieces("live.html"), _entries(native)
    made = Page(native, live=True, faults=bool(live.faults))
    figures = [figure(native, entry, made) for entry in entries]
    scenario = live.scenario
    shown = seen.view(native, made.arrays)
    sliders = [
        parts["slider"].format(
            label=control.slider.label or control.slider.start,
            least=repr(control.least),
            most=repr(control.most),
            value=repr(control.value),
            number=number,
        )
        for number, control in enumerate(live.controls)
    ]
    names = [*(sentence(fault) for fault in scenario.faults), *(f.name for f in _added(live))]
    buttons = [
        parts["fault"].format(
            number=i,
            pressed=str(i < len(scenario.faults)).lower(),
            state="" if does else " disabled",
            text=sentence(fault),
            name=name,
        )
        for i, (fault, does, name) in enumerate(zip(live.faults, live.each, names, strict=True))
    ]
    body = [
        Markup("<style>{}</style>").format(Markup(str(parts["style"]).replace("{{", "{").replace("}}", "}"))),
        parts["header"].format(name=scenario.name, description=scenario.description),
        parts["first"].format(
            kind=" both" if shown else "",
            view=made.view(shown),
            first=figures[0],
            name=scenario.name,
            sliders=joined(sliders),
            faults=joined(buttons),
            hash=native.sha256,
            file=_file(live),
        ),
        parts["figures"].format(hint=pieces("pieces.html")["hint"], content=joined(figures[1:]))
        if figures[1:]
        else Markup(""),
    ]
    flown = {
        "plots": [_plot(native, entry, panel) for entry in entries for panel in entry.panels],
        "phases": columns(native, phases.conditions(native)) if scenario.phases else None,
        "view": shown and motion(native, shown),
    }
    data = {"live": {**_data(live, flown), "hash": native.sha256}}
    return made.html(f"{scenario.name}: live", body, asset("live.js"), _POLICY, data)


def _entries(native: RunData) -> list[FigureEntry]:
    """The scenario's figures; where it has none, one for each of some signals."""
    if native.scenario.figures:
        return native.scenario.figures
    expected = [entry.signal for entry in native.scenario.expect if entry.signal in native]
    names = list(dict.fromkeys(expected or native))[:_PLOTS]
    return [FigureEntry(name="signal", title=n, panels=[Panel(signals=[Reference(n)])]) for n in names]


def _added(live: Live) -> list[LiveFault]:
    return live.scenario.live.faults if live.scenario.live else []


def _file(live: Live) -> str:
    return (live.scenario.source.file or "").replace("\\", "/").rpartition("/")[2]


def _data(live: Live, flown: dict[str, Any]) -> dict[str, Any]:
    clock, scenario = live.opened.plan.clock, live.scenario
    end = clock.time(clock.steps)
    return {
        "name": scenario.name,
        "file": _file(live),
        "step": scenario.step,
        "duration": scenario.duration,
        "wasm": base64.b64encode(live.wasm).decode("ascii"),
        "worker": asset("live_worker.js"),
        "starts": live.tables.values,
        "controls": [_control(live, control) for control in live.controls],
        "faults": [
            {
                "own": i < len(scenario.faults),
                "data": fault.model_dump(mode="json", exclude_none=True),
                "span": [fault.at, end if fault.until is None else min(fault.until, end)],
            }
            for i, fault in enumerate(live.faults)
        ],
        "given": {
            "steps": clock.steps,
            "interval": clock.interval,
            "numerator": clock.numerator,
            "denominator": clock.denominator,
            "columns": len(live.opened.plan.columns),
            **flown,
        },
    }


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
    return {
        "measure": control.slider.measure,
        "axis": control.slider.axis,
        "unit": control.unit,
        "factor": control.factor,
        "offset": control.offset,
        "places": [[places[node] for node in nodes] for nodes in control.nodes],
        "names": names,
    }


def _plot(native: RunData, entry: FigureEntry, panel: Panel) -> dict[str, Any]:
    """How the curves of a panel come from the recorded columns."""
    curves: list[dict[str, Any]] = []
    for name in panel.signals:
        variable, columns = native.variable(name), native.places(name)
        factor, offset = (variable.unit or ONE).conversion(unit_of(panel, variable))
        groups = [columns] if panel.measure == "norm" else [[column] for column in columns]
        norm = panel.measure == "norm"
        curves += [{"columns": group, "norm": norm, "factor": factor, "offset": offset} for group in groups]
    window = entry.window or [float(native.time[0]), float(native.time[-1])]
    shade = native.places(entry.shade)[0] if entry.shade else None
    mark = native.places(entry.mark)[0] if entry.mark else None
    return {"curves": curves, "shade": shade, "mark": mark, "window": window}
