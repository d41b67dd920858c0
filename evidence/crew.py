"""The workers of a study: campaigns are flown one after the other, and functions called, all on the same processes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from operator import itemgetter
from pathlib import Path
from typing import Any

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from orchestration import InputError
from orchestration.campaign.case import Case, read_campaign
from orchestration.campaign.engine import fly
from orchestration.campaign.flying.rows import Rows
from orchestration.interrupt import Stopped
from orchestration.scenario.source import Source

AT_ONCE = 8
"""Results between two writings of their file."""


def case(campaign: Mapping[str, Any], folder: Path) -> Case:
    """A campaign given as data; its Python metrics and relative paths are looked for in the folder.

    Raises InputError.
    """
    return read_campaign(Source(dict(campaign), str(campaign["name"]), folder))


def folder_of(wanted: Case, results: Path) -> Path:
    """Returns where the runs of a campaign stand: named by all that decides them, so what other FMUs flew is never
    mixed in.
    """
    return results / f"{wanted.campaign.name}-{wanted.fingerprint[:8]}"


def runs_of(wanted: Case, results: Path) -> Rows | None:
    """The runs of a campaign that stand in its folder; None where it has not begun."""
    folder = folder_of(wanted, results)
    return Rows(folder) if (folder / "runs").exists() else None


class Crew:
    """Worker processes behind a scheduler's address; without one, this process."""

    def __init__(self, address: str | None, progress: Progress) -> None:
        self._address, self._progress = address, progress

    def fly(self, wanted: Case, results: Path) -> Rows:
        """The runs of a campaign, of which those that are in its folder under `results` are not flown again.

        Raises Stopped on Ctrl-C, and InputError where every run failed.
        """
        folder = folder_of(wanted, results)
        bar = self._progress.add_task(wanted.campaign.name, total=wanted.runs)
        finished = fly(
            wanted,
            folder,
            0 if self._address is None else None,
            self._address,
            tell=lambda now: self._progress.update(bar, completed=now.flown),
        )
        if finished.interrupted:
            raise Stopped(finished.interrupted)
        if finished.failed == finished.flown:
            raise InputError(f"{wanted.campaign.name}: every run failed, the first with: {finished.reason}")
        self._progress.update(bar, completed=finished.flown)
        return Rows(folder)

    def each(self, name: str, function: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
        """The results of a function of each item, in their order."""
        return [result for _, result in sorted(self.as_found(name, function, list(items)), key=itemgetter(0))]

    def as_found(self, name: str, function: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        """The results as they are found, each with the place of its item."""
        from orchestration.campaign.flying.cluster import each  # Dask, which takes 2 s to import  # noqa: PLC0415

        bar = self._progress.add_task(name, total=len(items))
        for found in each(function, items, self._address) if self._address else enumerate(map(function, items)):
            self._progress.update(bar, advance=1)
            yield found


@contextmanager
def crew(jobs: int) -> Iterator[Crew]:
    """A crew of so many processes; of 0, this process. Shows a progress bar for each campaign."""
    from orchestration.campaign.flying.cluster import local  # Dask, which takes 2 s to import  # noqa: PLC0415

    columns = (TextColumn("{task.description:28}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with ExitStack() as stack:
        progress = stack.enter_context(Progress(*columns, TimeRemainingColumn()))
        yield Crew(stack.enter_context(local(jobs)).scheduler_address if jobs else None, progress)


def complete(jobs: int, wanted: Iterable[Case], results: Path) -> None:
    """Flies what the folders under `results` lack of campaigns, one after the other."""
    with crew(jobs) as hands:
        for one in wanted:
            there = runs_of(one, results)
            if there is None or len(there) < one.runs:
                hands.fly(one, results)


def in_parts(
    jobs: int,
    name: str,
    function: Callable[[Any], Any],
    wanted: Sequence[Any],
    found: list[Any],
    save: Callable[[list[Any]], None],
) -> Iterator[str]:
    """Appends the results of a function to those found, in their order, saves them after each AT_ONCE, and tells of
    it."""
    save(found)
    if not wanted:
        return
    there, results = list(found), dict[int, Any]()
    with crew(jobs) as hands:
        for place, result in hands.as_found(name, function, wanted):
            results[place] = result
            if len(results) % AT_ONCE == 0 or len(results) == len(wanted):
                found[:] = [*there, *(results[i] for i in sorted(results))]
                save(found)
                yield f"{name}: {len(results)} of {len(wanted)}"
