"""A campaign from its first run to its verdicts: what is left is flown, rows are written as they come, requirements are decided."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from ..errors import InputError, reason
from ..interrupt import held
from ..results.place import reserved
from .case import Case
from .flying.batches import Batches, Crew
from .flying.crew import crew
from .record import MANIFEST, earlier_start, manifest, write
from .report import page as report
from .statistics import verdicts as statistics
from .statistics.verdicts import Verdict

try:
    from .extras import ANALYSES, analyse, keep
    from .flying.dataset import Dataset
except ModuleNotFoundError:  # in a place without PyArrow, of which `fly` tells
    Dataset = None  # type: ignore[assignment, misc]


@dataclass(frozen=True)
class Progress:
    """Where a campaign stands."""

    flown: int
    """Runs that are there, those of an earlier start included."""
    wanted: int
    failed: int
    fresh: int
    """Runs of this start."""
    seconds: float
    """Since its first batch was sent."""


Tell = Callable[[Progress], None]


@dataclass
class Finished:
    """What came of a campaign, or of the part that was flown."""

    state: str
    """`completed`, `stopped early` or `interrupted`."""
    flown: int
    failed: int
    verdicts: list[Verdict]
    reason: str | None
    """Why the first run failed that did."""
    wall: float
    """Seconds of this start."""
    interrupted: int = 0
    """The number of the signal that ended it; 0 for none."""
    page: Path | None = None
    """The report page."""


def fly(
    case: Case,
    folder: Path,
    workers: int | None = None,
    scheduler: str | None = None,
    dashboard: bool = False,
    tell: Tell | None = None,
    remark: Callable[[str], None] = lambda text: None,
) -> Finished:
    """Flies what is left of a campaign, and writes its folder: `campaign.json` and the dataset `runs/`.

    `workers` 0 flies in this process; `scheduler` is the address of a Dask cluster. Ctrl-C ends it, and what is written is valid.
    Raises InputError where the folder holds another campaign, ResultsError where it cannot be written.
    """
    if Dataset is None:
        raise InputError("a campaign needs the package 'pyarrow'; remedy: pip install 'attitude-cosim[campaign]'")
    begun = perf_counter()
    with reserved(folder), ExitStack() as stack:
        earlier = earlier_start(case, folder)
        data = Dataset(folder, case.job, case.runs)
        state, interrupted, verdicts = "running", 0, list[Verdict]()
        if (extended := _extended(case, earlier)) and case.campaign.stop != "decided":
            remark(
                "runs were added to a campaign that already had its verdicts, which is a second look: "
                "the bounds are those of a confidence sequence, and wider"
            )
        more: dict[str, Any] = {key: earlier[key] for key in ("kept", "analyses", *ANALYSES) if key in earlier}

        def note() -> None:
            record = manifest(case, state, data, verdicts, perf_counter() - begun, earlier)
            looked = record["early"] or extended or (state == "interrupted" and not data.done.all())
            write(folder / MANIFEST, {**record, "early": looked, "extended": extended, **more})

        @cache
        def hands() -> Crew:
            flying, remarks = stack.enter_context(crew(case.job, workers, scheduler, dashboard))
            for text in remarks:
                remark(text)
            return flying

        note()
        try:
            state, verdicts = _flown(case, data, hands, tell, extended)
            data.flush()
            note()  # before what follows, which may take as long again
            analyse(case, folder, hands, more, remark)
            more["kept"] = keep(case, folder)
        except KeyboardInterrupt as signal:
            state, interrupted = "interrupted", getattr(signal, "number", 2)
        finally:
            with held():
                data.flush()
                if state in ("running", "interrupted"):
                    state, verdicts = "interrupted", verdicts_so_far(case, data, extended)
                note()
        page = _page(folder, remark)
    counts = int(data.done.sum()), int(data.failed.sum())
    return Finished(state, *counts, verdicts, data.reason, perf_counter() - begun, interrupted, page)


def _flown(
    case: Case, data: Any, hands: Callable[[], Crew], tell: Tell | None, extended: bool
) -> tuple[str, list[Verdict]]:
    """Flies up to the end, or until all is decided."""
    begun, there = perf_counter(), int(data.done.sum())
    if case.campaign.stop != "decided":
        _up_to(case, data, hands, case.runs, begun, there, tell)
        return "completed", verdicts_so_far(case, data, extended)
    verdicts: list[Verdict] = []
    for look in statistics.looks(case.runs):
        _up_to(case, data, hands, look, begun, there, tell)
        met = {name: int(flags[:look].sum()) for name, flags in data.met.items()}
        verdicts = _with_cause(data, look, statistics.verdicts(case.job.requirements, met, look, early=True))
        if look < case.runs and all(verdict.status != "undecided" for verdict in verdicts):
            return "stopped early", verdicts
    return "completed", verdicts


def _up_to(
    case: Case, data: Any, hands: Callable[[], Crew], look: int, begun: float, there: int, tell: Tell | None
) -> None:
    """Flies those of the first `look` runs that are not there yet."""
    left = np.flatnonzero(~data.done[:look])
    if not len(left):
        return
    points = case.job.design.points if case.job.design.early else None
    flying = hands()
    batches = Batches(left, points, flying.slots)
    flown, failed = int(data.done.sum()), int(data.failed.sum())
    for rows in flying.fly(batches):
        data.add(rows)
        flown += len(rows)
        failed += sum(row[1] != "ok" for row in rows)
        if tell is not None:
            tell(Progress(flown, case.runs, failed, flown - there, perf_counter() - begun))
    data.flush()


def verdicts_so_far(case: Case, data: Any, extended: bool) -> list[Verdict]:
    """The verdicts of the runs that are there, up to the first that is not: among later ones the quick runs would count too often.

    Where these are not the runs that were planned first, the campaign is looked at more than once, and the bounds allow for that.
    """
    there = case.runs if data.done.all() else int(data.done.argmin())
    met = {name: int(flags[:there].sum()) for name, flags in data.met.items()}
    early = extended or there < case.runs or case.campaign.stop == "decided"
    return _with_cause(data, there, statistics.verdicts(case.job.requirements, met, there, early=early))


def _with_cause(data: Any, there: int, verdicts: list[Verdict]) -> list[Verdict]:
    """The verdicts; where every run failed, with the reason, since their share says nothing of the bounds then."""
    if not there or not data.failed[:there].all():
        return verdicts
    return [replace(v, text=f"{v.text}; every run failed, the first with: {data.reason}") for v in verdicts]


def _extended(case: Case, earlier: dict[str, Any]) -> bool:
    """Whether runs were added to a campaign that had its verdicts on fewer."""
    runs = earlier.get("runs", {})
    judged = bool(earlier.get("verdicts")) and runs.get("flown") == runs.get("wanted", case.runs) < case.runs
    return judged or bool(earlier.get("extended"))


def _page(folder: Path, remark: Callable[[str], None]) -> Path | None:
    """The report page. Where it cannot be written, the results stand without it."""
    try:
        return report.write(folder)
    except Exception as error:
        why = reason(error) if isinstance(error, OSError) else f"{type(error).__name__}: {error}"
        remark(f"{folder / 'campaign.html'} cannot be written: {why}")
        return None
