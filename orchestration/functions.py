"""The functions of the package beside `run` and `load`: sweeps and campaigns, checks of another team's FMU, export.

Each does what the command of its name does, prints nothing and returns what was found. All raise InputError where their
input is wrong, and BlockError where a block fails.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .acceptance import check as acceptance
from .acceptance import compare as comparing
from .acceptance.compare import Comparison
from .acceptance.polarity import trials
from .acceptance.polarity.trials import Trials
from .errors import InputError, Place, Problem, lacking, writing
from .export import container, ssp
from .export.system import flat
from .results.result import Result
from .scenario.scenario import Scenario
from .scenario.source import Source
from .session.read import load, read
from .session.run import run
from .swap.findings import Finding
from .swap.option import Swap, swapped

if TYPE_CHECKING:
    from .campaign.engine import Finished

Given = str | Path | Scenario
"""A scenario: its file, or what `load` returned."""


@dataclass(frozen=True)
class Point:
    """One run of a sweep: the values that it had, by name, and its result."""

    values: dict[str, Any]
    result: Result


def sweep(scenario: Given, values: Mapping[str, Sequence[Any]], *, duration: float | str | None = None) -> list[Point]:
    """Runs a scenario with every combination of values, the last name's changing fastest.

    `values` has a sequence for each start value, `{"plant.inclination": ["51.6 deg", "98 deg"]}`, or for `step`.
    """
    if not values:
        raise InputError(
            Problem(expected="a start value with the values to sweep", found="none", place=Place("values"))
        )
    source = _source(scenario)
    points = (dict(zip(values, chosen, strict=True)) for chosen in product(*values.values()))
    return [Point(point, run(load(source, point), duration=duration)) for point in points]


def run_campaign(
    campaign: str | Path,
    out: str | Path | None = None,
    *,
    runs: int | None = None,
    seed: int | None = None,
    overrides: Mapping[str, Any] | None = None,
    workers: int | None = None,
) -> Finished:
    """Flies a campaign's file and returns its verdicts; the rows stand in its folder, `<out>/runs` (Parquet).

    `out` is by default `results/<name>`; what an earlier start flew there is not flown again. `runs` and `seed` take
    the place of the file's, `overrides` are start values by name. `workers` 0 flies in this process, None in one for
    each core.
    """
    try:
        from .campaign import engine  # a plain installation lacks what it needs  # noqa: PLC0415
        from .campaign.case import read_campaign  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise lacking("run_campaign", error.name) from None
    entries = {key: value for key, value in (("runs", runs), ("seed", seed)) if value is not None}
    case = read_campaign(Path(campaign), entries, dict(overrides or {}))
    return engine.fly(case, Path("results") / case.campaign.name if out is None else Path(out), workers)


def check_fmu(
    fmu: str | Path, block: str, mapping: str | Path | None = None, *, scenario: Given | None = None, play: bool = True
) -> list[Finding]:
    """Returns what is found where an FMU is to take a block's place; it fits if no finding has the level "error".

    `mapping` is the file that maps its ports to ours. With `scenario` the expectations are named that read an output of
    this FMU. `play` plays the reference data that it carries, in a process of its own.
    """
    loaded = None if scenario is None else load(_source(scenario))
    mapped = None if mapping is None else Path(mapping)
    findings, _ = acceptance.check(Path(fmu), block, mapped, scenario=loaded, tolerance=1e-6 if play else None)
    return findings


def compare_fmu(
    scenario: Given, block: str, fmu: str | Path, mapping: str | Path | None = None, *, tolerances: Sequence[str] = ()
) -> Comparison:
    """Compares an FMU with the block that it replaces: on the same inputs, and in the loop.

    `tolerances` are those of the command, `["0.1 %", "dipole_cmd=0.2 A.m2"]`; by default 1e-6 of our largest value.
    """
    source = _source(scenario)
    swap = Swap(block, str(fmu), "fmu", None if mapping is None else str(mapping), "mapping")
    return comparing.compare(source, swapped(source, [swap]), block, tolerances)


def check_polarity(scenario: Given, ports: Sequence[str] = (), *, workers: int | None = None) -> Trials:
    """Flies a loop with every port wired wrongly in every usual way; each row says what detects it.

    `ports` are those to look at, `["allocator.h_w"]`; by default all.
    """
    return trials.run(_source(scenario), None, ports, workers)


def export_loop(
    scenario: Given,
    path: str | Path,
    *,
    for_orchestrate: bool = False,
    ssp_version: str = "1.0",
    numbers: bool = False,
) -> Path:
    """Writes a scenario as an SSP archive (.ssp) or as one FMU that holds all (.fmu), and returns the path.

    `for_orchestrate` keeps rates, faults and delays in the archive's annotation, where only this program reads them.
    Without it they are parameters and FMUs. An archive is one of SSP 1.0 or 2.0 (`ssp_version`); `numbers` writes
    enumerations as whole numbers. Raises ResultsError where the file cannot be written.
    """
    target = Path(path)
    if target.suffix not in (".ssp", ".fmu"):
        raise InputError(Problem(expected="a name that ends in .ssp or .fmu", found=str(path), place=Place("path")))
    if ssp_version not in ssp.VERSIONS:
        expected = " or ".join(ssp.VERSIONS)
        raise InputError(Problem(expected=expected, found=str(ssp_version), place=Place("ssp_version")))
    system = flat(load(_source(scenario)), for_orchestrate and target.suffix == ".ssp")
    with writing(target):
        if target.suffix == ".ssp":
            ssp.write(system, target, ssp.Style(ssp_version, numbers))
        else:
            container.write(system, target, numbers)
    return target


def _source(scenario: Given) -> Source:
    return scenario.source if isinstance(scenario, Scenario) else read(Path(scenario))
