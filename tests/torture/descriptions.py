"""FMUs whose modelDescription.xml is changed at random: checked, and opened for a run in which their code does not
start."""

from __future__ import annotations

import sys
import tempfile
import zipfile
from functools import cache
from pathlib import Path
from random import Random

import click
import fmpy

from orchestration.fmu.archive import open_fmu

from ..orchestration import as_fmi3, fmus
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


@cache
def _three() -> str:
    """The motor of FMI 3.0, with arrays."""
    with tempfile.TemporaryDirectory() as folder:
        return as_fmi3.description(open_fmu(fmus.write(Path(folder, "motor.fmu"), fmus.description("motor"))), {})


def _make(random: Random, folder: Path) -> list[str]:
    platform, text = random.choice(((fmpy.platform, fmus.description("motor")), (fmpy.platform_tuple, _three())))
    xml = mutate.encoded(random, mutate.text(random, text))
    with zipfile.ZipFile(folder / "motor.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", xml)
        archive.writestr(f"binaries/{platform}/probe{fmpy.sharedLibraryExtension}", b"no library")
    fmus.write(folder / "reference.fmu", fmus.description("motor"))
    return random.choice(
        (
            ["check", "motor.fmu", "--as", "reference.fmu"],
            ["check", "motor.fmu", "--as", "reference.fmu", "--lenient", "--json"],
            ["run", "strict.yaml"],
            ["run", "lenient.yaml"],
        )
    )
