"""A campaign from its first run to its verdicts: what is left is flown, rows are written as they come, requirements are
decided.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

from ..errors import lacking, reason
from ..interrupt import held
from ..results.place import refuse_links, reserved
from .case import Case
from .flying.batches import Crew, Tell
from .flying.crew import crew
from .record import announced_first, earlier_start, manifest
from .report import page as report
from .statistics.bounds import looks
from .statistics.verdicts import Announced, Verdict, verdicts
from .sums import write

try:
    from .extras import ANALYSES, analyse, keep
    from .flying.dataset import Dataset
    from .flying.flights import Flights
except ModuleNotFoundError:  # in a place without PyArrow, of which `fly` tells
    Dataset = None  # type: ignore[assignment, misc]


@dataclass
class Finished:
    """The outcome of a campaign, or of the part that was flown."""

    state: str
    """`completed`, `stopped early` or `interrupted`."""
    flown: int
    failed: int
    verdicts: list[Verdict]
    reason: str | None
    """Why the first run failed that did."""
    wall: float
    """Seconds of this start."""
    interrupted: int
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

    `workers` 0 flies in this process; `scheduler` is the address of a Dask cluster. Ctrl-C ends it, and what is written
    is valid. Raises InputError where the folder holds another campaign, ResultsError where it cannot be written.
    """
    if Dataset is None:
        raise lacking("a campaign", "pyarrow")
    with reserved(folder), ExitStack() as stack:
        flight = _Campaign(case, folder, partial(crew, case.job, workers, scheduler, dashboard), stack, tell, remark)
        flight.fly()
    return replace(flight.finished, page=page(folder, remark))


class _Campaign:
    """A campaign that is being flown: what is there, who flies, and what is known of the requirements."""

    def __init__(
        self,
        case: Case,
        folder: Path,
        hired: Callable[[], AbstractContextManager[tuple[Crew, list[str]]]],
        stack: ExitStack,
        tell: Tell | None,
        remark: Callable[[str], None],
    ) -> None:
        """Takes over what an earlier start left in the folder.

        Raises InputError where it is damaged or another campaign's.
        """
        self._case, self._folder, self._hired, self._stack, self._tell, self._remark = (
            case, folder, hired, stack, tell, remark,
        )  # fmt: skip
        self._begun = perf_counter()
        refuse_links(folder)
        self._earlier = earlier_start(case, folder)
        self._announced = announced_first(case, self._earlier)
        self._data = Dataset(folder, case.job, case.runs, self._earlier, self._note)
        self._flights = Flights(case.job, self._data, self._earlier, self._hire, remark)
        self._state, self._verdicts, self._signal = "running", list[Verdict](), 0
        self._more = {key: self._earlier[key] for key in ("kept", "analyses", *ANALYSES) if key in self._earlier}

    @property
    def finished(self) -> Finished:
        """Returns the outcome up to now."""
        counts = int(self._data.done.sum()), int(self._data.failed.sum())
        wall = perf_counter() - self._begun
        return Finished(self._state, *counts, self._verdicts, self._data.reason, wall, self._signal)

    def fly(self) -> None:
        """Flies what is left, and writes the folder."""
        case, announced = self._case, self._announced.runs
        if case.runs != announced and not self._announced.early:
            self._remark(
                f"{announced} runs were announced, and {case.runs} are another end, which may be chosen by what "
                "is seen: "
                "the bounds are those of a confidence sequence, and wider"
            )
        self._note()
        try:
            self._state, self._verdicts = self._flown()
            self._data.flush()
            self._note()  # before what follows, which may take as long again
            analyse(case, self._folder, self._flights.crew, self._more, self._remark)
            self._more["kept"] = keep(case, self._folder, self._remark)
        except KeyboardInterrupt as signal:
            self._state, self._signal = "interrupted", getattr(signal, "number", 2)
        finally:
            with held():
                self._data.flush()
                if self._state in ("running", "interrupted"):
                    self._state, self._verdicts = "interrupted", self._so_far()
                self._note()

    def _note(self) -> None:
        wall = perf_counter() - self._begun
        record = manifest(self._case, self._state, self._data, self._verdicts, wall, self._earlier, self._announced)
        write(self._folder, {**record, **self._flights.state, **self._more})

    def _hire(self) -> Crew:
        flying, remarks = self._stack.enter_context(self._hired())
        for text in remarks:
            self._remark(text)
        return flying

    def _flown(self) -> tuple[str, list[Verdict]]:
        """Flies up to the end, or until all is decided."""
        case = self._case
        if case.campaign.stop != "decided":
            self._flights.up_to(case.runs, self._tell)
            return "completed", self._so_far()
        for look in looks(case.runs):
            self._flights.up_to(look, self._tell)
            said = self._of_first(look)
            if look < case.runs and all(verdict.status != "undecided" for verdict in said):
                return "stopped early", said
        return "completed", self._so_far()

    def _so_far(self) -> list[Verdict]:
        """Returns the verdicts of the runs that are there, up to the first that is not: among later ones the quick runs
        would count too often.
        """
        return self._of_first(self._case.runs if self._data.done.all() else int(self._data.done.argmin()))

    def _of_first(self, count: int) -> list[Verdict]:
        return verdicts_of_first(self._case, self._data, count, self._announced)


def verdicts_of_first(case: Case, data: Any, count: int, announced: Announced) -> list[Verdict]:
    """Returns the verdicts of the first `count` runs of a campaign that was so announced.

    Where every run failed, they have the reason, since the share says nothing of the bounds then.
    """
    met = {name: int(flags[:count].sum()) for name, flags in data.met.items()}
    said = verdicts(case.job.requirements, met, count, announced)
    if not count or not data.failed[:count].all():
        return said
    return [replace(v, text=f"{v.text}; every run failed, the first with: {data.reason}") for v in said]


def page(folder: Path, remark: Callable[[str], None]) -> Path | None:
    """Returns the report page. Where it cannot be written, the results stand without it."""
    try:
        return report.write(folder)
    except Exception as error:
        why = reason(error) if isinstance(error, OSError) else f"{type(error).__name__}: {error}"
        remark(f"{folder / 'campaign.html'} cannot be written: {why}")
        return None
