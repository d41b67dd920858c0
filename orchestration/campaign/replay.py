"""A single run of a campaign again: as a scenario that `orchestrate` takes, and flown with all its signals."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError, writing
from ..fmu.interfaces import is_path
from ..quantities import QuantityError
from ..results.place import put
from ..results.result import Result
from ..scenario.text import written
from ..session.flight import with_values
from ..session.manifest import start_values
from ..session.read import load
from ..session.run import whole
from ..system.starts import resolve
from .case import Case
from .flying.job import Pilot
from .record import earlier_start


@dataclass(frozen=True)
class Replayed:
    """A run that was flown again."""

    values: dict[str, Any]
    """Start values by name, as `--set` takes them."""
    metrics: dict[str, float | None]
    met: dict[str, bool]
    result: Result
    file: Path
    """The scenario that was written."""


def replay(case: Case, index: int, folder: Path, results: Path | None = None) -> Replayed:
    """Writes the scenario of a run to `folder/scenario.yaml`, and flies it. Raises InputError, MetricError, ResultsError.

    Its metrics are those of the campaign's row, bit for bit: with `results` it is refused where they are another campaign's.
    A signal that ends it raises Stopped.
    """
    earlier = earlier_start(case, results) if results else {}
    runs = max(case.runs, earlier.get("runs", {}).get("wanted", 0))
    if not 0 <= index < runs:
        raise InputError(f"--replay {index}: the campaign has the runs 0 to {runs - 1}; remedy: --runs")
    return at(case, case.job.design.points([index])[0].tolist(), folder, f"Run {index}", f"-{index}")


def worst(case: Case, results: Path, folder: Path) -> Replayed:
    """The worst case that a search has found, whose campaign is in `results`, as `replay` does a run. Raises InputError, MetricError."""
    searched = earlier_start(case, results).get("search")
    if not isinstance(searched, dict) or not searched.get("unit_point"):
        raise InputError(f"--replay worst: no search has found a worst case in {results}")
    return at(case, searched["unit_point"], folder, "The worst case", "-worst")


def at(case: Case, point: Sequence[float], folder: Path, title: str, ending: str) -> Replayed:
    """The run at a point of the unit cube; see `replay`."""
    draws = case.job.draws
    try:
        values = draws.given(draws.at(point))
    except QuantityError as error:
        raise InputError(f"{title} of the campaign: {error}") from None
    file = folder / "scenario.yaml"
    text = scenario_text(case, values, f"{title} of the campaign {case.campaign.name}", f"{case.scenario.name}{ending}")
    with writing(file):
        folder.mkdir(parents=True, exist_ok=True)
        put(file, text)
    pilot = Pilot(case.job)
    observers = pilot.observers()
    result = whole(load(file), seers=([node for measure in case.job.measures for node in measure.needed], observers))
    metrics: dict[str, float | None] = {one.measure.metric.name: None for one in observers}
    expectations = {outcome.name: outcome.passed for outcome in result.outcomes}
    if result.failure is None:
        metrics = {one.measure.metric.name: None if math.isnan(value := one.value()) else value for one in observers}
    met = {
        one.name: result.failure is None and one.met(list(metrics.values()), expectations)
        for one in case.job.requirements
    }
    return Replayed(values, metrics, met, result, file)


def scenario_text(case: Case, values: Mapping[str, Any], title: str, name: str = "") -> str:
    """The scenario with these start values as YAML, every value in force written out. Raises InputError."""
    plan = case.job.opened.plan
    starts = resolve(with_values(plan.scenario, values), plan.models)
    data = json.loads(json.dumps(case.scenario.model_dump(exclude_none=True)))
    for key in ("shared", "extends"):  # each value stands where it is taken
        data.pop(key)
    data["name"] = name or data["name"]
    folder = case.scenario.source.folder
    for block, entry in data["blocks"].items():
        entry["start"] = start_values(plan.models[block], starts[block])
        for key in ("fmu", "interface"):
            if key in entry and is_path(entry[key]):
                entry[key] = str((folder / Path(entry[key]).expanduser()).resolve())
        if entry.get("map", {}).get("file"):
            entry["map"] = str((folder / Path(entry["map"]["file"]).expanduser()).resolve())
    return f"# {title}, written by orchestrate campaign.\n{written(data)}"
