"""Live pages at drawn settings of their sliders and faults: the hash of each flight beside that of the native run."""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

import click
import numpy as np

from orchestration.live.page import page
from orchestration.live.system import prepare
from orchestration.session.read import load
from orchestration.session.run import whole

from ..orchestration.live.drawn import flown, paused, trials
from ..orchestration.results.browser import executable, launched

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def made(folder: Path, stem: str) -> Path:
    """Writes the live page of a scenario of the folder, beside it."""
    live, file = prepare(load(folder / "scenarios" / f"{stem}.yaml")), folder / f"{stem}.html"
    file.write_text(page(live, whole(live.scenario)), "utf-8")
    return file


@click.command("pages")
@click.argument("names", nargs=-1)
@click.option("--count", default=20, show_default=True, help="Settings of each page.")
@click.option("--seed", default=1, show_default=True)
def command(names: tuple[str, ...], count: int, seed: int) -> None:
    """Fly the pages of scenarios, of all where none is named, and their native runs."""
    path = executable()
    assert path is not None, "no Chromium on this machine (Debian: apt-get install chromium)"
    bad = 0
    with tempfile.TemporaryDirectory(prefix="pages-") as name, launched(path) as tab:
        folder = Path(name)
        shutil.copytree(SCENARIOS, folder / "scenarios")
        for stem in names or sorted(file.stem for file in SCENARIOS.glob("*.yaml")):
            tab.open(made(folder, stem), 1400)
            flown(tab)
            paused(tab)
            try:
                seen = trials(tab, folder / "scenarios", count, np.random.default_rng(seed))
            except (AssertionError, TimeoutError) as error:
                bad += 1
                click.echo(f"{stem}: ERROR: {error}")
            else:
                click.echo(f"{stem}: {count} settings, {len(seen)} hashes, each flight that of the native run")
    sys.exit(bool(bad))
