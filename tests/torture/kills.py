"""Runs that are killed at random times, into one folder with earlier results.

After each kill the folder must hold one run's results, whole: the manifest's hashes are those of the files, and all are
of the same run. What a run left unfinished by SIGKILL in the middle of replacing is completed by the next, which is
checked, too.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

import click

from orchestration.errors import InputError
from orchestration.results.place import reserved

from ..orchestration import fmus
from ..orchestration.wrong_inputs import SCENARIO

ROOT = Path(__file__).parents[2]
_HUNG = -999
_PATIENCE = 10.0  # s
_SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)


@click.command("kills")
@click.option("--count", default=200, show_default=True, help="Runs to be killed.")
@click.option("--seed", default=1, show_default=True)
def command(count: int, seed: int) -> None:
    """Kill runs at random times and look at what they leave."""
    choose = random.Random(seed)
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(prefix="kills-") as name:
        folder = Path(name)
        (folder / "temporary").mkdir()
        fmus.write_pair(folder)
        # Many samples, so that a good part of a run is the writing of its results.
        (folder / "loop.yaml").write_text(SCENARIO.replace("duration: 2 s", "duration: 1500 s") + "isolation: none\n")
        whole = [_run(folder, 0.0)[0] for _ in range(2)][1]  # the first one may have to compile the step loop
        _judge(folder, "whole", counts)
        for number in range(1, count + 1):
            sent = choose.choice(_SIGNALS)
            # Half of the kills fall into the last third of a run, in which the results are written.
            at = whole * (choose.uniform(0.6, 1.1) if choose.random() < 0.5 else choose.uniform(0.0, 1.1))
            before = _left(folder)
            taken, status = _run(folder, float(number), sent, at)
            counts[f"{sent.name}: ended by itself" if status in (0, 1) else f"{sent.name}: killed"] += 1
            if status not in (0, 1, -sent, 128 + sent):
                counts["ERROR: another exit status"] += 1
                click.echo(f"run {number}: {sent.name} after {at:.3f} s: exit status {status}")
            for path in _left(folder) - before:
                counts[
                    f"{'' if sent is signal.SIGKILL else 'ERROR: '}{sent.name}: left {path.name.rpartition('-')[0]}"
                ] += 1
            _judge(folder, sent.name, counts)
            if status in (0, 1):
                whole = 0.9 * whole + 0.1 * taken
        _run(folder, 0.5)
        _judge(folder, "whole", counts)
        counts["ERROR: left in the folder by a whole run"] = len(list((folder / "out").glob(".orchestrate-*")))
    for text, n in sorted(counts.items()):
        click.echo(f"{n:6} {text}")
    raise SystemExit(any(n for text, n in counts.items() if text.startswith("ERROR")))


def _run(folder: Path, speed: float, sent: signal.Signals | None = None, at: float = 0.0) -> tuple[float, int]:
    """A run with this initial speed, killed after a time; how long it took and its status."""
    default = {signal.SIGINT: signal.default_int_handler}
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "orchestration",
            "loop.yaml",
            "--quiet",
            "--out",
            "out",
            "--set",
            f"motor.speed0={speed}",
        ],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(folder / "temporary")},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        preexec_fn=lambda: [signal.signal(n, default.get(n, signal.SIG_DFL)) for n in (signal.SIGINT, signal.SIGTERM)],
    )
    begun = time.monotonic()
    try:
        if sent is not None:
            with suppress(subprocess.TimeoutExpired):
                process.wait(at)
            process.send_signal(sent)
        status = process.wait(120)
    except subprocess.TimeoutExpired:
        process.kill()
        status = _HUNG
    return time.monotonic() - begun, status


def _left(folder: Path) -> set[Path]:
    """What runs have left unfinished, in their folder and in that for temporary files."""
    return {*(folder / "out").glob(".orchestrate-part-*"), *(folder / "temporary").glob("orchestrate-*")}


def _clear(out: Path) -> None:
    """Clears the folder as the next run does, when the process that ends with the killed one has ended."""
    until = time.monotonic() + _PATIENCE
    while True:
        try:
            with reserved(out):
                return
        except InputError:
            if time.monotonic() > until:
                raise
            time.sleep(0.02)


def _judge(folder: Path, after: str, counts: Counter[str]) -> None:
    """Looks at the folder as it is; where replacing was broken off by SIGKILL, after the next run's clearing."""
    out = folder / "out"
    if (out / ".orchestrate-ready").exists():
        counts[f"{after}: to be completed by the next run"] += 1
        _clear(out)
    try:
        manifest = json.loads((out / "manifest.json").read_text())
        speed = manifest["parameters"]["motor"]["speed0"]
        for name, digest in manifest["files"].items():
            if hashlib.sha256((out / name).read_bytes()).hexdigest() != digest:
                raise ValueError(f"{name} is not that of the manifest")
        first = (out / "signals.csv").read_text().splitlines()[1].split(",")
        if manifest["outcome"] == "completed" and float(speed) not in map(float, first):
            raise ValueError("the signals are of another run")
        counts["folders whole"] += 1
        counts[f"results of a run that was {manifest['outcome']}"] += 1
    except (OSError, ValueError, KeyError) as error:
        counts["ERROR: folders torn"] += 1
        click.echo(f"after {after}: {type(error).__name__}: {error}")
