"""Measures all that docs/evidence/margins.md shows: margins along the orbit, equilibria, delays, and the
changes that lose a hold. What docs/evidence/margins.json has of the same inputs is not flown again.

Tests: tests/evidence/margins/test_make.py.
"""

from __future__ import annotations

import hashlib
import json
import re
import zipfile
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

from fmus.native import SHELL
from orchestration import load
from orchestration.fmu.archive import Fmu
from orchestration.session.open import open_scenario

from ..paper import ROOT
from .cases import CASES, PLACES, PLANNED, VB, along_orbit, at_place, delayed, equilibrium, searched

KEPT = ROOT / "docs" / "evidence" / "margins.json"
WATCH, IDENTIFY = "controller.find_failures", "controller.identify"
DELAYS = {
    "as it is": ({}, (7.0, 7.4)),
    "no watch for failed rods": ({WATCH: False}, (7.0, 8.0, 8.5)),
    "no watch, no identification": ({WATCH: False, IDENTIFY: False}, (10.0, 14.0)),
}
"""Delays at the actuators of the planned hold, s, as it is and with parts of its controller off."""
TURNS = (1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)
CHANGES = {
    VB: ("delay=0..20", "gain=1..400", "gain=1..0.02", "plant.J_B=1..30", "plant.rod_gain=1..0.05"),
    PLANNED: ("sensors.attitude_noise=1..3000", "plant.J_B=1..4", "plant.rod_gain=1..0.01"),
}
_GENERATED = "block.h", "table.c"
"""They have the FMU's identity, and its variables for FMI."""


@dataclass(frozen=True)
class Job:
    """A measurement, whose rows stand under `kind`."""

    kind: str
    hold: str
    measure: Callable[..., list[dict[str, Any]]]
    arguments: tuple[Any, ...]

    @cached_property
    def name(self) -> str:
        """Its name in the file."""
        return " ".join(map(str, (self.kind, *self.arguments)))

    @cached_property
    def inputs(self) -> str:
        """The hash of scenario, case and arguments, and of code and start values of the blocks, which a build that
        changes none of them keeps."""
        case = CASES[self.hold]
        return _hash([_scenario(case.scenario), repr(case), repr(self.arguments)])


def _hash(data: Any) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True, default=str).encode()).hexdigest()[:16]


@lru_cache
def _scenario(name: str) -> str:
    opened = open_scenario(load(ROOT / "scenarios" / f"{name}.yaml"))
    stated = opened.plan.scenario.model_dump(mode="json", exclude={"description", "figures", "live"})
    return _hash([stated, {name: code(fmu) for name, fmu in opened.fmus.items()}])


def code(fmu: Fmu) -> Any:
    """Returns the start values of an FMU and its block's C, without comments, spaces and what makes an FMU of it."""
    starts = {str(element): value for element, value in fmu.model.starts.items()}
    with zipfile.ZipFile(fmu.path) as archive:
        named = ((name, name.removeprefix("sources/")) for name in archive.namelist() if name.startswith("sources/"))
        own = [name for name, file in named if file not in _GENERATED and not (SHELL / file).exists()]
        texts = {name: re.sub(r"/\*.*?\*/|//[^\n]*|\s+", "", archive.read(name).decode(), flags=re.S) for name in own}
    return [starts, texts]


def jobs() -> list[Job]:
    """Returns all of them."""
    made = [
        Job("places", name, at_place, (name, place))
        for name, case in CASES.items()
        if not case.followed
        for place in PLACES
    ]
    made += [
        Job("delays", PLANNED, delayed, (name, values, delay))
        for name, (values, delays) in DELAYS.items()
        for delay in delays
    ]
    made += [Job("equilibria", VB, equilibrium, (turn,)) for turn in TURNS]
    made += [Job("changes", hold, searched, (hold, text)) for hold, texts in CHANGES.items() for text in texts]
    return made + [Job("places", name, along_orbit, (name,)) for name, case in CASES.items() if case.followed]


def make(processes: int, cases: Sequence[str] = (), anew: bool = False) -> None:
    """Measures what is not kept of the same inputs, of these holds or all, each kept as soon as it is measured."""
    kept: dict[str, list[dict[str, Any]]] = json.loads(KEPT.read_text("utf-8")) if KEPT.exists() else {}
    known = {job.name: number for number, job in enumerate(jobs())}
    done = {(row.get("job"), row.get("inputs")) for rows in kept.values() for row in rows}
    wanted = [job for job in jobs() if not cases or job.hold in cases]
    wanted = [job for job in wanted if anew or (job.name, job.inputs) not in done]
    with ProcessPoolExecutor(processes) as pool:
        waits = {pool.submit(job.measure, *job.arguments): job for job in wanted}
        for wait in as_completed(waits):
            job = waits[wait]
            rows = [row for row in kept.get(job.kind, []) if row.get("job") in known and row["job"] != job.name]
            rows += [{"job": job.name, "inputs": job.inputs, **row} for row in wait.result()]
            kept[job.kind] = sorted(rows, key=lambda row: known[row["job"]])
            KEPT.write_text(json.dumps(kept, indent=1) + "\n", "utf-8")
