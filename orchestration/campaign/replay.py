"""A single run of a campaign again: as a scenario that `orchestrate` takes, and flown with all its signals."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import InputError, writing
from ..fmu.interfaces import is_path
from ..quantities import QuantityError
from ..results.result import Result
from ..results.whole import put
from ..scenario.source import StartName
from ..scenario.text import written
from ..session.flight import with_values
from ..session.manifest import start_values
from ..session.read import load
from ..session.run import whole
from ..system.starts import resolve
from .case import Case
from .flying.job import FAILED, OK, Cell, Pilot, differing
from .record import earlier_start


@dataclass(frozen=True)
class Replayed:
    """A run that was flown again."""

    values: dict[str, Any]
    """Its start values by name, as `--set` takes them."""
    metrics: dict[str, float | None]
    met: dict[str, bool]
    result: Result
    file: Path
    """The scenario that was written."""
    differs: tuple[str, ...] = ()
    """Where it is not as the campaign's row or search has it: columns with both values, in words."""


def replay(case: Case, index: int, folder: Path, results: Path | None = None) -> Replayed:
    """Writes the scenario of a run to `folder/scenario.yaml`, and flies it. Raises InputError, MetricError,
    ResultsError.

    With `results` its columns are held against the campaign's row there, and it is refused where they are another
    campaign's. A signal that ends it raises Stopped.
    """
    earlier = earlier_start(case, results) if results else {}
    runs = max(case.runs, earlier.get("runs", {}).get("wanted", 0))
    if not 0 <= index < runs:
        raise InputError(f"--replay {index}: the campaign has the runs 0 to {runs - 1}; remedy: --runs")
    row = _row(case, results, earlier, runs, index) if results and earlier else None
    again, flown = at(case, case.job.design.points([index])[0].tolist(), folder, f"Run {index}", f"-{index}")
    if row is None:
        return again
    names = [name for name, _ in case.job.columns]
    was = dict(zip(names, zip(row, [index, *flown], strict=True), strict=True))
    return replace(again, differs=tuple(_differs(name, *was[name]) for name in differing(names, row, [index, *flown])))


def worst(case: Case, results: Path, folder: Path) -> Replayed:
    """Flies the worst case that a search has found, whose campaign is in `results`, as `replay` does a run.

    Raises InputError, MetricError.
    """
    searched = earlier_start(case, results).get("search")
    if not isinstance(searched, dict) or not searched.get("unit_point"):
        raise InputError(f"--replay worst: no search has found a worst case in {results}")
    again, _ = at(case, searched["unit_point"], folder, "The worst case", "-worst")
    value, metric = again.metrics[searched["metric"]], searched["metric"]
    same = (
        value == (math.inf if searched["worst"] == "largest" else -math.inf)
        if searched["endless"]
        else value == searched["value"]
    )
    return again if same else replace(again, differs=(_differs(metric, searched["value"], value),))


def _row(case: Case, results: Path, earlier: Mapping[str, Any], runs: int, index: int) -> Sequence[Cell] | None:
    """Returns the campaign's row of a run; None where it has not been flown.

    Raises InputError where a part is damaged.
    """
    from .flying.dataset import Dataset  # it needs PyArrow, which other commands do without  # noqa: PLC0415

    rows = Dataset(results, case.job, runs, earlier)
    return rows.row(index) if rows.done[index] else None


def _differs(name: str, was: Cell, now: Cell) -> str:
    return f"{name} is {now!r} and was {was!r}"


def at(case: Case, point: Sequence[float], folder: Path, title: str, ending: str) -> tuple[Replayed, list[Cell]]:
    """Flies the point of the unit cube; see `replay`. Returns also its row in the dataset from the second cell on."""
    draws = case.job.draws
    try:
        drawn = draws.at(point)
    except QuantityError as error:
        raise InputError(f"{title} of the campaign: {error}") from None
    file = folder / "scenario.yaml"
    named = f"{title} of the campaign {case.campaign.name}", f"{case.scenario.name}{ending}"
    text = scenario_text(case, draws.given(drawn), *named)
    with writing(file):
        folder.mkdir(parents=True, exist_ok=True)
        put(file, text)
    pilot = Pilot(case.job)
    observers = pilot.observers()
    result = whole(
        load(file), observers=([node for measure in case.job.measures for node in measure.needed], observers)
    )
    expected = {outcome.name: outcome.passed for outcome in result.outcomes}
    whole_run = result.failure is None
    metrics: dict[str, float | None] = {
        one.measure.metric.name: value if whole_run and not math.isnan(value := one.value()) else None
        for one in observers
    }
    met = {one.name: whole_run and one.met(list(metrics.values()), expected) for one in case.job.requirements}
    flags = [*met.values(), *(expected[name] for name in case.job.expectations)]
    row: list[Cell] = [OK if whole_run else FAILED, None, None, *draws.cells(drawn), *metrics.values()]
    row += flags if whole_run else [None] * len(flags)
    return Replayed(draws.texts(drawn), metrics, met, result, file), row


def scenario_text(case: Case, values: Mapping[StartName, Any], title: str, name: str = "") -> str:
    """Returns the scenario with these start values as YAML, every value in force written out. Raises InputError."""
    plan = case.job.opened.plan
    starts = resolve(with_values(plan.scenario, values), plan.models)
    data = json.loads(json.dumps(case.scenario.model_dump(exclude_none=True)))
    for key in ("shared", "extends"):  # each value stands where it is taken
        data.pop(key)
    data["name"] = name or data["name"]
    folder = case.scenario.source.folder
    for block, entry in data["blocks"].items():
        entry["start"] = start_values(plan.models[block], starts[block])
        if not entry.get("fmu"):  # a law or a record
            entry.pop("fmu", None)
        files = [(entry, key) for key in ("fmu", "interface") if is_path(entry.get(key, ""))]
        for holder, key in (*files, (entry, "python"), (entry.get("telemetry", {}), "file")):
            if holder.get(key):
                holder[key] = str((folder / Path(holder[key]).expanduser()).resolve())
        if entry.get("map", {}).get("file"):
            entry["map"] = str((folder / Path(entry["map"]["file"]).expanduser()).resolve())
    return f"# {title}, written by orchestrate campaign.\n{written(data)}"
