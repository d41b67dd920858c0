"""FMUs and SSP archives changed at random, as zip archives and, of SSP, in their documents: checked and run."""

from __future__ import annotations

import os
import sys
import zipfile
from pathlib import Path
from random import Random

import click

from orchestration.cli.main import main

from ..orchestration import fmus
from ..orchestration.wrong_inputs import SCENARIO
from . import _mutate as mutate
from ._campaign import campaign


@click.command("archives")
@click.option("--count", default=1000, show_default=True, help="Inputs.")
@click.option("--seed", default=1, show_default=True)
def command(count: int, seed: int) -> None:
    """Run FMUs and SSP archives that are changed at random."""
    sys.exit(campaign(_make, _prepare, count, seed))


def _prepare(folder: Path) -> None:
    """loop.ssp and its FMUs that run, and copies of the FMUs that cannot be loaded, so that no input runs for long."""
    here = Path.cwd()
    fmus.write_pair(folder)
    (folder / "loop.yaml").write_text(SCENARIO, "utf-8")
    os.chdir(folder)
    main(["export", "loop.yaml", "--ssp", "whole.ssp"], standalone_mode=False)
    os.chdir(here)
    fmus.write_pair(folder, runnable=False)
    (folder / "whole.fmu").write_bytes((folder / "motor.fmu").read_bytes())
    with zipfile.ZipFile(folder / "whole.ssp") as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(folder / "whole.ssp", "w") as archive:
        for name, data in files.items():
            block = Path(name).stem
            archive.writestr(name, (folder / f"{block}.fmu").read_bytes() if name.endswith(".fmu") else data)


def _make(random: Random, folder: Path) -> list[str]:
    kind = random.randrange(3)
    if kind == 0:
        (folder / "motor.fmu").write_bytes(mutate.archive(random, (folder / "whole.fmu").read_bytes()))
        return random.choice((["check", "motor.fmu", "--as", "whole.fmu"], ["run", "loop.yaml"]))
    if kind == 1:
        (folder / "loop.ssp").write_bytes(mutate.archive(random, (folder / "whole.ssp").read_bytes()))
    else:
        with zipfile.ZipFile(folder / "whole.ssp") as archive:
            files = {name: archive.read(name) for name in archive.namelist()}
        chosen = random.choice(["SystemStructure.ssd", *(name for name in files if name.endswith((".ssd", ".ssv")))])
        files[chosen] = mutate.encoded(random, mutate.text(random, files[chosen].decode("utf-8")))
        with zipfile.ZipFile(folder / "loop.ssp", "w") as archive:
            for name, data in files.items():
                archive.writestr(name, data)
    return ["run", "loop.ssp"]
