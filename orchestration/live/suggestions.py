"""The sliders and faults of a page whose scenario names none: those that the interfaces of its blocks suggest."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

from ..errors import InputError
from ..fmu.interfaces import pages
from ..fmu.model import Element
from ..results.parts import NEVER
from ..rotation import quaternion
from ..scenario.faults import Fault
from ..scenario.scenario import Scenario
from ..session.plan import Plan
from ..session.read import load
from ..system.disturbances import KINDS, acting
from ..system.faults import resolve
from ..system.wiring import Node
from .sliders import controls, start_value

_BEGIN, _LASTS = 0.3, 0.1
"""When a suggested fault begins and how long one that ends lasts, as parts of the run; the page moves it."""


def with_suggestions(scenario: Scenario, plan: Plan) -> Scenario:
    """Returns the scenario with what fits of the suggestions as its `live`; as it is where it has one."""
    if scenario.live is not None:
        return scenario
    suggested = [
        (name, pages().get(entry.interface or plan.models[name].name, {})) for name, entry in scenario.blocks.items()
    ]
    sliders = [slider for name, own in suggested for slider in _sliders(name, own.get("sliders", ()), plan)]
    faults = [fault for name, own in suggested for fault in _faults(name, own.get("faults", ()), scenario, plan)]
    known: dict[str, dict[str, Any]] = {fault["name"]: fault for fault in faults if _acts(fault, scenario, plan)}
    fitting = [slider for slider in sliders if _fits(slider, scenario, plan)]
    return load(scenario.source.with_entry(("live",), {"sliders": fitting, "faults": list(known.values())}))


def _sliders(block: str, entries: Iterable[dict[str, Any]], plan: Plan) -> Iterator[dict[str, Any]]:
    for entry in entries:
        slider = {**entry, "start": f"{block}.{entry['start']}"}
        if entry.get("measure") == "rotation":  # about the axis that it has
            nodes = [Node(block, Element(entry["start"], i)) for i in range(9)]
            _, *axis = quaternion([float(start_value(plan, node)) for node in nodes])
            if not any(axis):
                continue
            slider["axis"] = [component / math.hypot(*axis) for component in axis]
        yield slider


def _faults(block: str, entries: Iterable[dict[str, Any]], scenario: Scenario, plan: Plan) -> Iterator[dict[str, Any]]:
    begin = round(_BEGIN * scenario.duration / scenario.step) * scenario.step
    for entry in entries:
        if "rate" in entry and 0.0 < start_value(plan, Node(block, Element(entry["rate"], 0))) <= NEVER:
            continue
        kind = next(key for key in ("set", *KINDS) if key in entry)
        end = round((_BEGIN + _LASTS) * scenario.duration / scenario.step) * scenario.step
        yield {
            "name": entry["name"],
            kind: f"{block}.{entry[kind]}",
            "at": begin,
            **({"until": end} if entry.get("ends") else {}),
        }


def _fits(slider: dict[str, Any], scenario: Scenario, plan: Plan) -> bool:
    try:
        return bool(controls(load(scenario.source.with_entry(("live",), {"sliders": [slider]})), plan))
    except InputError:
        return False  # what it would change is zero, lies outside or is not there


def _acts(fault: dict[str, Any], scenario: Scenario, plan: Plan) -> bool:
    entry = Fault.model_validate({key: value for key, value in fault.items() if key != "name"})
    alone = scenario.model_copy(update={"faults": [entry]})
    try:
        found = resolve(alone, plan.models, plan.wiring)
        return bool(found.settings or acting(alone, plan.order.blocks, found.disturbances, []))
    except InputError:
        return False
