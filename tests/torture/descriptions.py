"""FMUs whose modelDescription.xml is changed at random: checked, and opened for a run in which their code does not start."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path
from random import Random

import click
import fmpy

from ..orchestration import fmus
from ..orchestration.wrong_inputs import SCENARIO
from . import _mutate as mutate
from ._campaign import campaign


@click.command("descriptions")
@click.option("--count", default=1000, show_default=True, help="Inputs.")
@click.option("--seed", default=1, show_default=True)
def command(count: int, seed: int) -> None:
    """Check and run FMUs whose modelDescription.xml is changed at random."""
    sys.exit(campaign(_make, _prepare, count, seed))


def _prepare(folder: Path) -> None:
    fmus.write_pair(folder, runnable=False)
    (folder / "strict.yaml").write_text(SCENARIO, "utf-8")
    (folder / "lenient.yaml").write_text(
        SCENARIO.replace("fmu: motor.fmu", "fmu: motor.fmu\n    validation: lenient"), "utf-8"
    )


def _make(random: Random, folder: Path) -> list[str]:
    xml = mutate.encoded(random, mutate.text(random, fmus.description("motor")))
    with zipfile.ZipFile(folder / "motor.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", xml)
        archive.writestr(f"binaries/{fmpy.platform}/probe{fmpy.sharedLibraryExtension}", b"no library")
    fmus.write(folder / "reference.fmu", fmus.description("motor"))
    return random.choice(
        (
            ["check", "motor.fmu", "--as", "reference.fmu"],
            ["check", "motor.fmu", "--as", "reference.fmu", "--lenient", "--json"],
            ["run", "strict.yaml"],
            ["run", "lenient.yaml"],
        )
    )
