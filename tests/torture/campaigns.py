"""Campaigns under what may befall them: many runs, several workers, workers and clients that are killed.

The loop is that of the tests, dx/dt = -x in steps of 0.1 s, so each row's metric is known in closed form.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import click
import psutil
import pyarrow.dataset as ds

from ..orchestration import fmus
from ..orchestration.campaign.flying.test_cluster import KILLER
from ..orchestration.campaign.toy import FILE, SHRINKS
from ..orchestration.wrong_inputs import SCENARIO

ROOT = Path(__file__).parents[2]


@click.command("campaigns")
@click.option("--runs", default=100_000, show_default=True, help="Runs of the trial of memory.")
@click.option("--kills", default=10, show_default=True, help="Clients and workers that are killed, each.")
@click.option("--seed", default=1, show_default=True)
def command(runs: int, kills: int, seed: int) -> None:
    """Fly campaigns, kill what flies them, and look at what they leave."""
    choose = random.Random(seed)
    errors = 0
    with tempfile.TemporaryDirectory(prefix="campaigns-") as name:
        folder = Path(name)
        fmus.write_pair(folder)
        (folder / "loop.yaml").write_text(SCENARIO + "isolation: none\n")
        (folder / "toy.yaml").write_text(FILE)
        errors += _workers(folder)
        errors += _deadly(folder)
        errors += _killed_workers(folder, kills, choose)
        errors += _killed_starting_workers(folder, kills, choose)
        errors += _killed_clients(folder, kills, choose)
        errors += _memory(folder, runs)
    sys.exit(1 if errors else 0)


def _start(folder: Path, *options: object, file: str = "toy.yaml") -> subprocess.Popen[str]:
    code = "from orchestration.cli.main import main; main()"
    arguments = [sys.executable, "-c", code, "campaign", file, *map(str, options)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        arguments,
        cwd=folder,
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )


def _rows(out: Path) -> list[dict]:
    table = ds.dataset(out / "runs", format="parquet").to_table().drop_columns(["wall"])
    return table.sort_by("index").to_pylist()


def _wrong(rows: list[dict], runs: int) -> int:
    """How many rows are missing, twice there, or not those of the closed form."""
    indices = [row["index"] for row in rows]
    off = sum(
        abs(row["final"] / (SHRINKS * row["motor.speed0"]) - 1.0) > 1e-12 for row in rows if row["status"] == "ok"
    )
    return abs(runs - len(set(indices))) + len(indices) - len(set(indices)) + off


def _workers(folder: Path) -> int:
    """The same rows with 0, 1, 2 and 3 workers."""
    found = []
    for workers in (0, 1, 2, 3):
        _start(folder, "--workers", workers, "--runs", 500, "--out", f"w{workers}").communicate()
        found.append(_rows(folder / f"w{workers}"))
    differ = sum(rows != found[0] for rows in found[1:])
    click.echo(f"500 runs in this process and with 1, 2 and 3 workers: {differ} differ")
    return differ


def _deadly(folder: Path) -> int:
    """A run that ends its worker each time is a failed row; all others are there."""
    first = sorted(_rows(folder / "w0")[:30], key=lambda row: row["motor.speed0"])
    limit = (first[-1]["motor.speed0"] + first[-2]["motor.speed0"]) / 2.0
    (folder / "deadly.py").write_text(KILLER.format(mark=str(folder / "none"), always=limit, once=9.0))
    more = "metrics:\n  - {name: start, python: 'deadly:deadly', signals: [motor.speed]}"
    (folder / "deadly.yaml").write_text(FILE.replace("metrics:", more))
    output, _ = _start(folder, "--workers", 2, "--runs", 30, "--out", "deadly", file="deadly.yaml").communicate()
    rows = _rows(folder / "deadly")
    lost = [row for row in rows if row["status"] == "failed"]
    click.echo(
        f"a run that ends its worker: {len(lost)} of {len(rows)} rows failed: {lost[0]['reason'] if lost else output}"
    )
    return int([row["index"] for row in lost] != [first[-1]["index"]]) + _wrong(rows, 30)


def _killed_workers(folder: Path, kills: int, choose: random.Random) -> int:
    """Workers are killed at random while they fly; no run is lost."""
    process = _start(folder, "--workers", 2, "--runs", 20_000, "--out", "workers")
    killed = 0
    while process.poll() is None and killed < kills:
        time.sleep(choose.uniform(0.5, 3.0))
        children = _children(process)
        if children and (folder / "workers" / "runs").is_dir():
            choose.choice(children).kill()
            killed += 1
    process.communicate()
    wrong = _wrong(_rows(folder / "workers"), 20_000)
    failed = sum(row["status"] == "failed" for row in _rows(folder / "workers"))
    click.echo(f"{killed} workers killed during 20000 runs: {wrong} rows wrong, {failed} failed")
    return wrong + failed + int(killed == 0 < kills)


def _killed_starting_workers(folder: Path, kills: int, choose: random.Random) -> int:
    """Workers are killed while they start: the campaign is flown, or says that it lost them and is flown by the next
    call. No input is called wrong."""
    errors = killed = 0
    for number in range(kills):
        out = folder / f"starting{number}"
        process = _start(folder, "--workers", 2, "--runs", 40, "--out", out)
        begun, wait = time.monotonic(), choose.uniform(0.0, 2.0)
        while process.poll() is None and not (children := _children(process)) and time.monotonic() - begun < 60.0:
            time.sleep(0.02)
        time.sleep(wait)
        if process.poll() is None and children and not list((out / "runs").glob("*.parquet")):
            with suppress(psutil.Error):
                choose.choice(children).kill()
                killed += 1
        said, _ = process.communicate()
        if process.returncode not in (0, 1):
            lost = process.returncode not in (2, 70) and "the workers are lost" in said
            errors += not lost
            click.echo(f"  status {process.returncode}: {said[-300:]}")
            again = _start(folder, "--workers", 2, "--runs", 40, "--out", out)
            again.communicate()
        errors += _wrong(_rows(out), 40)
    click.echo(f"{killed} workers killed while they started: {errors} errors")
    return errors


def _children(process: subprocess.Popen[str]) -> list[psutil.Process]:
    """The workers of a client; their command line is Python's own, or Dask's where setproctitle is installed."""
    found = []
    with suppress(psutil.Error):
        for child in psutil.Process(process.pid).children():
            line = " ".join(child.cmdline())
            found += [child] if "spawn_main" in line or "dask worker" in line else []
    return found


def _killed_clients(folder: Path, kills: int, choose: random.Random) -> int:
    """Clients are killed at random and started again, until the campaign is complete."""
    out, starts, left = folder / "clients", 0, 0
    while True:
        process = _start(folder, "--workers", 1, "--runs", 20_000, "--out", "clients")
        starts += 1
        if starts <= kills:
            time.sleep(choose.uniform(1.0, 12.0))
            process.send_signal(choose.choice((signal.SIGKILL, signal.SIGTERM, signal.SIGINT)))
        process.communicate()
        time.sleep(10.0)  # workers have some seconds to see that their client is gone
        left += len(subprocess.run(["pgrep", "-g", str(process.pid)], capture_output=True, text=True).stdout.split())
        if starts > kills:
            break
    wrong = _wrong(_rows(out), 20_000)
    state = json.loads((out / "campaign.json").read_text())["state"]
    parts = len(list((out / "runs").glob("*.parquet")))
    click.echo(f"{kills} clients killed: {wrong} rows wrong, {left} processes left, {parts} parts, in the end {state}")
    return wrong + left + int(state != "completed")


def _memory(folder: Path, runs: int) -> int:
    """Memory of the client and its workers while many runs pass; it may not grow with them."""
    shutil.rmtree(folder / "many", ignore_errors=True)
    begun = time.monotonic()
    process = _start(folder, "--workers", 2, "--runs", runs, "--out", "many")
    samples: list[tuple[int, float, float]] = []
    while process.poll() is None:
        time.sleep(2.0)
        try:
            client = psutil.Process(process.pid)
            own = client.memory_info().rss / 1e6
            workers = [child.memory_info().rss / 1e6 for child in _children(process)]
        except psutil.Error:
            break
        there = sum(1 for _ in (folder / "many" / "runs").glob("*.parquet"))
        if there and len(workers) == 2:
            samples.append((there, own, max(workers)))
    process.communicate()
    seconds = time.monotonic() - begun
    wrong = _wrong(_rows(folder / "many"), runs)
    click.echo(f"{runs} runs in {seconds:.0f} s with 2 workers, {runs / seconds:.0f} runs/s: {wrong} rows wrong")
    for share in (0.1, 0.25, 0.5, 0.75, 0.95):
        _, own, workers = samples[int(share * (len(samples) - 1))]
        click.echo(f"  at {100 * share:.0f}% of the time: client {own:.0f} MB, larger worker {workers:.0f} MB")
    early, late = samples[len(samples) // 4], samples[int(0.95 * (len(samples) - 1))]
    grown = late[1] > 1.25 * early[1] + 20.0 or late[2] > 1.25 * early[2] + 20.0
    return wrong + int(grown)
