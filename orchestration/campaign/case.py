"""From a campaign file to what can be flown: everything is checked before anything runs."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..errors import InputError, Problems, hint
from ..expectations import metrics
from ..expectations.span import numeric
from ..paths import located
from ..quantities import QuantityError, shown
from ..scenario import complaints, extends
from ..scenario.load import load
from ..scenario.scenario import Scenario
from ..scenario.source import Key, Source, StartName
from ..session.flight import with_values
from ..session.open import open_scenario
from ..session.read import read
from ..swap.option import Swap, swapped
from ..system import cycles
from ..system.starts import resolve
from .drawing import draws as drawing
from .drawing.design import design, notes, samples
from .drawing.expression import NoValue
from .file.campaign import Campaign
from .flying.functions import Code, NotLoaded, find
from .flying.job import CheckedRequirement, Job
from .statistics.verdicts import hints

_DECIDES_NO_ROW = set("name description figures record view live realtime holds consistency".split())
"""Entries of a scenario that decide no row of a campaign."""


@dataclass
class Case:
    """A campaign that has been checked against its scenario and FMUs."""

    campaign: Campaign
    source: Source
    scenario: Scenario
    job: Job
    notes: list[str] = field(default_factory=list)

    @property
    def runs(self) -> int:
        """Returns how many runs it has."""
        return self.job.design.runs

    @property
    def parts(self) -> dict[str, str]:
        """Returns the parts that decide the rows, each by the hash of its content.

        With `sampling: random` the number of runs does not count.
        """
        opened, campaign = self.job.opened, self.campaign.model_dump(mode="json", exclude_none=True)
        scenario = opened.plan.scenario.model_dump(mode="json", exclude=_DECIDES_NO_ROW)
        starts = {name: block.pop("start", {}) for name, block in scenario["blocks"].items()}
        counted = {} if campaign["sampling"] == "random" else {"runs": self.runs}
        content: dict[str, Any] = {
            "scenario": scenario,
            "start values": {"shared": scenario.pop("shared", {}), **starts},
            "what varies": {"draw": campaign["draw"], "vary": campaign["vary"]},
            "sampling": {"sampling": campaign["sampling"], **counted},
            "seed": campaign["seed"],
            "metrics": {
                "metrics": campaign["metrics"],
                "code": {name: code.sha256 for name, code in self.job.codes.items()},
            },
            "requirements": [
                {key: value for key, value in entry.items() if key not in ("probability", "confidence")}
                for entry in campaign["requirements"]
            ],
            "FMUs": {name: fmu.sha256 for name, fmu in opened.fmus.items()},
        }
        return {name: _hash(part) for name, part in content.items()}

    @property
    def fingerprint(self) -> str:
        """Returns the hash of all that decides the rows."""
        return _hash(self.parts)


def _hash(data: Any) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True, default=str).encode()).hexdigest()


def read_campaign(
    campaign: Path | str | Source,
    overrides: Mapping[str, Any] | None = None,
    sets: Mapping[str, Any] | None = None,
    loads: bool = True,
) -> Case:
    """Returns a campaign file, or the same as data, held against its scenario and FMUs.

    Raises InputError with what is wrong.

    `overrides` take the places of top entries: `runs`, `seed`, `sampling`; `sets` are start values for all runs, by
    name. `loads`: whether modules of metrics are run, as is needed to fly.
    """
    source = extends.extended(campaign) if isinstance(campaign, Source) else extends.read(Path(campaign))
    if isinstance(source.data, dict):
        if "blocks" in source.data and "scenario" not in source.data:
            message = "is a scenario; expected a campaign, which names one under 'scenario'; remedy: orchestrate run"
            raise InputError(source.error((), message))
        for key, value in (overrides or {}).items():
            source = source.with_value(key, value, f"--{key}")
        for name, value in (sets or {}).items():
            source = source.with_set(name, value)
    flown = _scenario(source)
    checked = complaints.checked(
        Campaign, source, flown.data if flown is not None and isinstance(flown.data, dict) else {}
    )
    assert flown is not None
    return prepare(checked, source, load(_changed(checked, source, flown)), loads)


def _scenario(source: Source) -> Source | None:
    """Returns the scenario's own source; None where the file names none. Raises InputError."""
    given = source.data.get("scenario") if isinstance(source.data, dict) else None
    if isinstance(given, str) and given:
        with source.naming(("scenario",)):
            path = located(given, source.folder)
            here = Path.cwd()
            return read(path.relative_to(here) if path.is_absolute() and path.is_relative_to(here) else path)
    if not isinstance(given, dict):
        return None
    lines = {key[1:]: line for key, line in source.lines.items() if key[:1] == ("scenario",)}
    return extends.extended(Source(given, source.file, source.folder, lines))


def _changed(campaign: Campaign, source: Source, flown: Source) -> Source:
    """Returns the scenario with the campaign's swaps, start values and flavour."""
    if unswapped := next((block for block in campaign.map if block not in campaign.swap), None):
        raise InputError(
            source.error(("map", unswapped), f"{unswapped} is not swapped{hint(unswapped, campaign.swap)}")
        )
    flown = swapped(flown, [_swap(campaign, source, block) for block in campaign.swap])
    for name, value in campaign.set.items():
        if name in campaign.vary:
            raise InputError(source.error(("set", name), f"{name} varies; expected it under 'set' or 'vary'"))
        flown = flown.with_start(name, value)
        flown.options[StartName.of(name).key] = source.where(("set", name))
    return flown if campaign.flavour is None else flown.with_value("flavour", campaign.flavour, "flavour:")


def _swap(campaign: Campaign, source: Source, block: str) -> Swap:
    swap = Swap(block, str(located(campaign.swap[block], source.folder).absolute()), source.where(("swap", block)))
    if block not in campaign.map:
        return swap
    mapping = str(located(campaign.map[block], source.folder).absolute())
    return replace(swap, mapping=mapping, mapping_place=source.where(("map", block)))


def prepare(campaign: Campaign, source: Source, scenario: Scenario, loads: bool = True) -> Case:
    """Returns a campaign held against its scenario. Raises InputError."""
    opened = open_scenario(scenario)
    plan = opened.plan
    if plan.scenario.cycle != scenario.cycle:  # the orbit of the start values is another; times counted in it follow
        campaign = complaints.checked(Campaign, source, plan.scenario.source.data)
    measures: list[metrics.Measure] = []
    codes: dict[str, Code] = {}
    broken: set[str] = set()
    with Problems() as problems:
        for number, metric in enumerate(campaign.metrics):
            key: Key = ("metrics", number)
            try:
                measures.append(metrics.prepare(source, key, metric, plan.models, plan.scenario))
                if metric.python and metric.python.partition(":")[0] not in broken:
                    place = source.where((*key, "python"))
                    codes[metric.python] = find(metric.python, source.folder, place, loads)
            except InputError as error:
                problems += error.problems
                if isinstance(error, NotLoaded):  # of a module that several metrics name, once
                    broken.add(error.module)
        with problems.gathered():
            draws = drawing.prepare(campaign, source, plan.models)
            _resolved(campaign, source, plan.scenario, draws, plan.models)
            for section, least in (("sensitivity", 2), ("search", 1)):
                if getattr(campaign, section) is not None and draws.dimension < least:
                    message = f"expected {least} or more numbers that vary, found {draws.dimension}"
                    problems.append(source.error((section,), message))
    requirements = _requirements(campaign, source, measures, [check.expectation.name for check in plan.checks])
    try:
        made = design(campaign.sampling, campaign.seed, campaign.runs, draws)
    except InputError as error:
        raise InputError(*(problem.at(source.place(())) for problem in error.problems)) from None
    job = Job(opened, draws, made, tuple(measures), tuple(requirements), codes)
    names = [name for name, _ in job.columns]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise InputError(
            source.error((), f"two columns of the dataset would be called {twice!r}; remedy: another name for one")
        )
    few = hints(requirements, made.runs, campaign.stop == "decided") if campaign.sampling != "grid" else []
    beyond = [str(index) for index in campaign.keep.runs if index >= made.runs]
    lost = [f"keep.runs: {', '.join(beyond)}: not flown, the last run is {made.runs - 1}"] if beyond else []
    varied = cycles.varied(plan.scenario, plan.models, [StartName.of(name) for name in campaign.vary])
    return Case(campaign, source, scenario, job, [*plan.notes, *varied, *notes(made), *few, *lost])


def _resolved(campaign: Campaign, source: Source, scenario: Scenario, draws: drawing.Draws, models: Any) -> None:
    """Sets the values at some points of the unit cube, so that a wrong name, unit or item is known before a run.

    Raises InputError.
    """
    places = {StartName.of(name): source.where(("vary", name)) for name in campaign.vary}
    for point in samples(draws):
        try:
            values = draws.given(draws.at(point))
        except NoValue as error:
            raise InputError(source.error(error.key, error.text)) from None
        resolve(with_values(scenario, values, places), models)


def _requirements(
    campaign: Campaign, source: Source, measures: list[metrics.Measure], expectations: list[str]
) -> list[CheckedRequirement]:
    known = [measure.metric.name for measure in measures]
    requirements = []
    with Problems() as problems:
        for number, entry in enumerate(campaign.requirements):
            key: Key = ("requirements", number)
            given = entry.name, entry.probability, entry.confidence
            if entry.expectation is not None:
                expected = f"{entry.expectation}: met"
                requirements.append(CheckedRequirement(*given, None, entry.expectation, None, expected))
                if entry.expectation not in expectations:
                    text = f"the scenario has no expectation {entry.expectation!r} that is evaluated"
                    text += hint(entry.expectation, expectations)
                    problems.append(source.error((*key, "expectation"), text))
                continue
            if entry.metric not in known:
                text = f"there is no metric {entry.metric!r}{hint(str(entry.metric), known)}"
                problems.append(source.error((*key, "metric"), text))
                continue
            place = known.index(entry.metric)
            assert entry.bound is not None
            try:
                unit = measures[place].unit
                limits = numeric(entry.metric, unit if shown(unit) else None, entry.bound)
            except QuantityError as error:
                problems.append(source.error((*key, entry.bound.kind), str(error)))
            else:
                expected = f"{entry.metric} {limits.text}"
                requirements.append(CheckedRequirement(*given, place, None, limits, expected))
    return requirements
