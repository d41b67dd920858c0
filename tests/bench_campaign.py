"""`python -m tests.bench_campaign`, a part of `make bench`: how fast campaigns are on this machine. Prints figures;
asserts nothing."""

from __future__ import annotations

import argparse
import logging
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import orchestration
from orchestration.campaign import engine
from orchestration.campaign.case import prepare
from orchestration.campaign.file.campaign import Campaign
from orchestration.campaign.flying.batches import TARGET, Progress
from orchestration.campaign.flying.job import Pilot
from orchestration.master.compiled import CompiledLoop
from orchestration.scenario.source import Source

Row = Callable[[str, str, str], None]


def case(scenario: dict[str, Any], runs: int) -> Any:
    """The paper's loop with its start rate and attitude varied."""
    data = {
        "name": "bench",
        "scenario": scenario,
        "runs": runs,
        "vary": {"plant.Q0": {"rotation": "uniform"}, "plant.omega_B0": {"sphere": 0.097}},
        "metrics": [{"name": "momentum", "signal": "plant.h_w", "statistic": "peak"}],
    }
    return prepare(Campaign.model_validate(data), Source(data), orchestration.load(scenario))


def overhead(scenario: dict[str, Any], row: Row) -> None:
    """CPU time of a run beside its loop, in a process that has flown it before."""
    pilot = Pilot(case({**scenario, "duration": 386.1}, 100).job)
    points = pilot.job.design.points(range(101))
    pilot.fly(0, points[0])
    loop, spent = CompiledLoop.advance, [0.0]

    def timed(self: Any, *arguments: Any) -> None:
        begun = time.process_time()
        loop(self, *arguments)
        spent[0] += time.process_time() - begun

    CompiledLoop.advance = timed
    begun = time.process_time()
    for index in range(1, 101):
        pilot.fly(index, points[index])
    whole = time.process_time() - begun
    CompiledLoop.advance = loop
    pilot.close()
    row("campaign: a run beside its loop", f"{10 * (whole - spent[0]):.2f} ms", "CPU time")


def orbits(scenario: dict[str, Any], count: int, row: Row) -> None:
    """So many orbits by worker processes, the start of these included; and a quarter by half of them. The rate is
    without the start."""
    cores = os.cpu_count() or 1
    for workers, runs in ((cores, count), (max(cores // 2, 1), count // 4)):
        with tempfile.TemporaryDirectory() as folder:
            marks: list[Progress] = []
            finished = engine.fly(case(scenario, runs), Path(folder) / "out", workers, tell=marks.append)
        flying = marks[-1].seconds
        name = f"campaign: {runs} orbits, {workers} worker{'s' * (workers > 1)}"
        row(name, f"{finished.wall:.1f} s", f"{runs / flying:.1f} orbits/s")


def scheduler(row: Row) -> None:
    """Batches of nothing: how many a scheduler deals out in a second, and so how many workers it bears."""
    from distributed import Client, LocalCluster, as_completed

    with (
        LocalCluster(
            n_workers=os.cpu_count() or 1,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            scheduler_kwargs={"dashboard": False},
            silence_logs=logging.CRITICAL,
        ) as local,
        Client(local, set_as_default=False) as client,
    ):
        count, begun = 0, 0.0
        pending = as_completed([client.submit(abs, -i, pure=False) for i in range(200)], loop=client.loop)
        for future in pending:
            future.result()
            count += 1
            if count == 200:
                begun = time.perf_counter()
            if count < 3000:
                pending.add(client.submit(abs, -count, pure=False))
        rate = (count - 200) / (time.perf_counter() - begun)
    # The scheduler, the client and the workers share this machine's cores here.
    row("campaign: empty batches by the scheduler", f"{rate:,.0f} /s", f"bears {TARGET * rate:,.0f} workers")


def rows(scenario: dict[str, Any], count: int, row: Row) -> None:
    """All of them."""
    overhead(scenario, row)
    orbits(scenario, count, row)
    scheduler(row)


if __name__ == "__main__":
    from .bench import orbit
    from .bench import row as shown

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--orbits", type=int, default=1000)
    rows(orbit("native", 4), parser.parse_args().orbits, shown)
