"""Calls spread over processes, with a progress bar."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

Task = tuple[Callable[..., Any], tuple[Any, ...]]


def each(tasks: Mapping[str, Task], processes: int, done: int = 0) -> Iterator[tuple[str, Any]]:
    """Names and results of the calls as they end; `done` of them were known before and count in the bar."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # threads of BLAS would only take the processes' cores
    columns = (TextColumn("{task.description:28}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, TimeRemainingColumn()) as progress, ProcessPoolExecutor(processes) as pool:
        bar = progress.add_task("", total=len(tasks) + done, completed=done)
        futures = {pool.submit(call, *arguments): name for name, (call, arguments) in tasks.items()}
        try:
            for future in as_completed(futures):
                name = futures[future]
                yield name, future.result()
                progress.update(bar, advance=1, description=name)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
