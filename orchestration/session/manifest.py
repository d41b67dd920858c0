"""What a run was made of, so that it can be repeated: scenario as resolved, FMUs, versions, platform, time."""

from __future__ import annotations

import platform
import sys
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

import numpy as np

from fmus.versions import version_of

from ..fmu.archive import Fmu
from ..fmu.model import Element, Model
from ..fmu.names import RULE
from ..results.data import RunData
from ..scenario.source import copied
from ..system import acting, signals
from ..system.starts import Start
from ..system.values import nested
from .limits import limits
from .plan import Plan

_ENTRIES = (
    *("outcome", "failure", "scenario_file", "options", "scenario", "parameters", "flags", "units", "names", "order"),
    *(
        "notes",
        "faults",
        "timeline",
        "fmus",
        "steps",
        "samples",
        "simulated_time",
        "wall_time",
        "steps_per_second",
        "realtime",
        "finished",
    ),
    *("versions", "platform"),
)
_PACKAGES = ("attitude-cosim", "fmpy", "numpy", "pydantic")


def described(plan: Plan, fmus: Mapping[str, Fmu], handed_on: Mapping[str, Mapping[Element, Any]]) -> dict[str, Any]:
    """Returns what a manifest says of all runs of a plan.

    `handed_on` are the start values of adapted blocks, by their elements.
    """
    scenario, models = plan.scenario, plan.models
    names = signals.names(plan.columns, models)
    recorded = RunData(scenario, models, np.empty(0), np.empty((0, len(plan.columns))), plan.columns)
    return {
        "scenario_file": scenario.source.file,
        "options": sorted(set(scenario.source.options.values())),
        "scenario": _resolved(plan, names),
        "parameters": {name: _parameters(fmu, plan, name, handed_on) for name, fmu in fmus.items()},
        "units": {"time": "s", **recorded.units},
        "names": RULE,
        "order": plan.order.blocks,
        "faults": acting.fault_sentences(scenario, models),
        "timeline": acting.timeline_sentences(scenario),
        "fmus": {
            name: {
                "file": str(fmu.path),
                "sha256": fmu.sha256,
                "fmi": fmu.model.fmi,
                "guid": fmu.model.guid,
                "model": fmu.model.name,
                "generation_tool": fmu.model.tool,
                "isolation": "process" if limits(scenario, name) else "none",
            }
            for name, fmu in fmus.items()
        },
        "versions": {"python": platform.python_version(), **{name: version_of(name) for name in _PACKAGES}},
        "platform": {"system": sys.platform, "machine": platform.machine(), "release": platform.release()},
    }


def manifest(known: Mapping[str, Any], notes: Sequence[str], finished: datetime, result: RunData) -> dict[str, Any]:
    """The manifest of a run, ready for JSON.

    `known` is what `described` gives of its plan, `notes` are those of the plan.
    """
    ended = "interrupted" if result.interrupted else "failed" if result.failure else "completed"
    of_run = {
        "outcome": ended,
        "failure": None if result.failure is None else str(result.failure),
        "flags": {name: {"ever": since is not None, "first": since} for name, since in result.flags.items()},
        "notes": list(notes),
        "steps": result.steps,
        "samples": len(result.time),
        "simulated_time": result.reached,
        "wall_time": result.wall,
        "steps_per_second": result.steps / result.wall if result.wall > 0.0 else None,
        "finished": finished.isoformat(timespec="seconds"),
    }
    if result.pace is not None:
        of_run["realtime"] = result.pace.data()
    entries = {**copied(dict(known)), **of_run}
    return {name: entries[name] for name in _ENTRIES if name in entries}


def _resolved(plan: Plan, recorded: list[str]) -> dict[str, Any]:
    """The scenario with its defaults filled in and all values in the units of the ports; it can be run as it stands."""
    data = plan.scenario.model_dump(exclude_none=True)
    data["record"] = {"interval": plan.clock.time(plan.clock.interval), "signals": recorded}
    data["expect"] += [
        entry.model_dump(exclude_none=True) for entry, _ in plan.not_evaluated
    ]  # a restart names them, too
    for key in ("shared", "extends"):  # each value stands where it is taken
        data.pop(key)
    for block, values in plan.starts.items():
        data["blocks"][block]["start"] = start_values(plan.models[block], values)
    return data


def _parameters(fmu: Fmu, plan: Plan, block: str, handed_on: Mapping[str, Mapping[Element, Any]]) -> dict[str, Any]:
    """All parameters of an FMU with the values in force: its own, but where the scenario gives others."""
    own = fmu.model.starts
    declared = {element: value for element, value in own.items() if _is_parameter(fmu.model, element)}
    starts = handed_on[block] if block in handed_on else {s.element: s.value for s in plan.starts[block]}
    given = {element: value for element, value in starts.items() if _is_parameter(fmu.model, element)}
    model = fmu.model
    values = {**declared, **given}
    places = list(model.variables)
    order = sorted(values, key=lambda element: (places.index(element.variable), element.position))
    return start_values(model, [Start(element, values[element]) for element in order])


def _is_parameter(model: Model, element: Element) -> bool:
    return model.variables[element.variable].causality == "parameter"


def start_values(model: Model, values: Sequence[Start]) -> dict[str, Any]:
    """Start values as a scenario gives them: lists of their shapes, items of enumerations by name, in the units of the
    ports."""
    given: dict[str, dict[int, Any]] = {}
    for start in values:
        given.setdefault(start.element.variable, {})[start.element.position] = start.value
    starts: dict[str, Any] = {}
    for name, by_position in given.items():
        variable = model.variables[name]
        names = {number: item for item, number in variable.items}
        spelt = {position: names.get(value, value) for position, value in by_position.items()}
        if len(spelt) == variable.size:
            starts[name] = nested(variable, [spelt[position] for position in range(variable.size)])
        else:
            starts.update((variable.label(position), value) for position, value in spelt.items())
    return starts
