"""FMUs of both versions that end the simulation at a step, in a process of their own and in that of the run, in both
loops."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from random import Random

import click

from orchestration.fmu.archive import open_fmu

from ..orchestration import as_fmi3, broken, fmus

ROOT = Path(__file__).parents[2]


@click.command("ends")
@click.option("--count", default=24, show_default=True, help="Runs.")
@click.option("--seed", default=1, show_default=True)
def command(count: int, seed: int) -> None:
    """Run FMUs that end the simulation, and look at what the run says and keeps."""
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(prefix="ends-") as name:
        folder = Path(name)
        library = fmus.library("broken")
        for version, how in ((2, "finish"), (3, "end")):
            xml = broken.XML.format(guid=f"step-{how}").replace('"broken"', '"probe"')
            fmus.write(folder / "two.fmu", xml, library)
            if version == 3:
                as_fmi3.write(folder / "fmi3.fmu", open_fmu(folder / "two.fmu"))
            else:
                (folder / "two.fmu").replace(folder / "fmi2.fmu")
        for number in range(count):
            _trial(Random(f"{seed}.{number}"), folder, counts, number)
    for text, n in sorted(counts.items()):
        click.echo(f"{n:6} {text}")
    sys.exit(any(text.startswith("ERROR") for text in counts))


def _trial(random: Random, folder: Path, counts: Counter[str], number: int) -> None:
    version, isolation = random.choice((2, 3)), random.choice(("none", "process"))
    loop, steps = random.choice(("compiled", "python")), random.choice((4, 10, 20))
    (folder / "run.yaml").write_text(
        f"name: run\nstep: {1 / steps} s\nduration: 2 s\nisolation: {isolation}\n"
        f"blocks:\n  vendor: {{fmu: fmi{version}.fmu}}\nconnections: [vendor.y -> vendor.x]\n"
    )
    out = folder / f"out{number}"
    command = [sys.executable, "-m", "orchestration", "run.yaml", "--loop", loop, "--quiet", "--out", str(out)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NO_COLOR": "1", "COLUMNS": "400"}
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    rows = len((out / "signals.csv").read_text().splitlines()) - 1 if (out / "signals.csv").exists() else 0
    said = f"vendor: fmi{version}DoStep at 1 s: asks to end the simulation" in done.stderr
    if (done.returncode, rows, said) == (3, steps + 1, True):
        counts[f"FMI {version}.0, isolation {isolation}, {loop} loop: told, and all samples kept"] += 1
    else:
        found = f"status {done.returncode}, {rows} rows of {steps + 1}: {done.stderr}"
        counts[f"ERROR: run {number}: FMI {version}.0, {isolation}, {loop}: {found}"] += 1
