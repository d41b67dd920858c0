"""What a run was made of, so that it can be repeated: scenario as resolved, FMUs, versions, platform, time."""

from __future__ import annotations

import platform
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .fmu import Fmu
    from .result import Result
    from .runner import Plan

_PACKAGES = ("attitude-cosim", "fmpy", "numpy", "pydantic")


def manifest(plan: Plan, fmus: Mapping[str, Fmu], result: Result) -> dict[str, Any]:
    """The manifest of a run, ready for JSON."""
    ended = "interrupted" if result.interrupted else "failed" if result.failure else "completed"
    scenario = plan.scenario
    return {
        "outcome": ended,
        "failure": None if result.failure is None else str(result.failure),
        "scenario_file": scenario.source.file,
        "options": sorted(set(scenario.source.options.values())),
        "scenario": _resolved(plan),
        "order": plan.order.blocks,
        "notes": plan.notes,
        "fmus": {
            name: {
                "file": str(fmu.path),
                "sha256": fmu.sha256,
                "guid": fmu.model.guid,
                "model": fmu.model.name,
                "generation_tool": fmu.model.tool,
            }
            for name, fmu in fmus.items()
        },
        "steps": result.steps,
        "samples": len(result.time),
        "simulated_time": plan.clock.time(result.steps),
        "wall_time": result.wall,
        "steps_per_second": result.steps / result.wall if result.wall > 0.0 else None,
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "versions": {"python": platform.python_version(), **{name: _version(name) for name in _PACKAGES}},
        "platform": {"system": sys.platform, "machine": platform.machine(), "release": platform.release()},
    }


def _resolved(plan: Plan) -> dict[str, Any]:
    """The scenario with all defaults filled in, and its start values as the FMUs received them."""
    data = plan.scenario.model_dump(exclude_none=True)
    data["record"] = {"interval": plan.clock.time(plan.clock.interval), "signals": _recorded(plan)}
    for name, values in plan.starts.items():
        variables = plan.models[name].variables
        data["blocks"][name]["start"] = {variables[s.element.variable].label(s.element.position): s.value for s in values}
    return data


def _recorded(plan: Plan) -> list[str]:
    return list(dict.fromkeys(f"{node.block}.{node.element.variable}" for node in plan.columns))


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
