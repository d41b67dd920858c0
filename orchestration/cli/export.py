"""`orchestrate export`: writes the system as a file for other tools.

Tests: tests/orchestration/system/test_optional.py, tests/orchestration/results/test_place.py.
"""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import InputError, writing
from ..export import container as container_writer
from ..export import ssp as ssp_writer
from ..export.system import flat
from ..fmu.archive import shown
from ..fmu.interfaces import is_path
from ..scenario.scenario import Scenario
from ..session.read import load
from .console import say
from .help import examples
from .options import changes
from .overrides import Changes
from .paths import PATH


@click.command(
    "export",
    epilog=examples(
        "orchestrate export loop.yaml --ssp loop.ssp",
        "orchestrate export loop.yaml --ssp loop.ssp --ssp-version 2.0 --numbers",
        "orchestrate export loop.yaml --ssp loop.ssp --for-orchestrate",
        "orchestrate export loop.yaml --container loop.fmu --step 0.5",
    ),
)
@click.argument("scenario", type=PATH)
@click.option("--ssp", type=PATH, metavar="FILE.ssp", help="As an SSP archive: FMUs, connections and values.")
@click.option(
    "--container",
    type=PATH,
    metavar="FILE.fmu",
    help="As one FMU that holds them all.",
)
@click.option(
    "--for-orchestrate",
    is_flag=True,
    help="Keep rates, faults and delays in the SSP archive's annotation, which only orchestrate reads.",
)
@click.option(
    "--ssp-version",
    type=click.Choice(ssp_writer.VERSIONS),
    default="1.0",
    show_default=True,
    help="Which SSP the archive is of.",
)
@click.option("--numbers", is_flag=True, help="Enumerations as whole numbers, for tools that know no items.")
@changes("step", "flavour")
def command(
    scenario: Path,
    ssp: Path | None,
    container: Path | None,
    for_orchestrate: bool,
    ssp_version: str,
    numbers: bool,
    change: Changes,
) -> None:
    """Write a scenario as a file that other FMI tools read.

    The FMUs are run for one step, so that inputs get their values at t = 0 as start values.
    FMUs of others run in separate processes.
    """
    if ssp is None and container is None:
        raise InputError("expected --ssp FILE.ssp or --container FILE.fmu, or both")
    source = change.unswapped(scenario)
    targets = [(path, suffix) for path, suffix in ((ssp, ".ssp"), (container, ".fmu")) if path is not None]
    for path, suffix in targets:
        if path.suffix != suffix:
            raise InputError(f"{path}: expected a name that ends in {suffix}")
        if not path.absolute().parent.is_dir():
            raise InputError(f"{path}: there is no folder {path.parent}")
    loaded = load(source)
    if foreign := [name for name, entry in loaded.blocks.items() if is_path(entry.fmu)]:
        say(f"note: runs the FMUs of others for one step, for the values at t = 0: {', '.join(foreign)}", error=True)
    if ssp is not None and (kept := _guards(loaded)):
        say(f"note: the archive does not carry {', '.join(kept)}: who runs it decides that", error=True)
    system = flat(loaded, kept=for_orchestrate and container is None)
    for path, suffix in targets:
        with writing(path):
            if suffix == ".ssp":
                ssp_writer.write(system, path, ssp_writer.Style(ssp_version, numbers))
            else:
                container_writer.write(system, path, numbers)
        say(f"{shown(path)}  {path.stat().st_size / 1000:.0f} kB")


def _guards(scenario: Scenario) -> list[str]:
    """Returns the keys by which the scenario says how its FMUs are run."""
    blocks = scenario.blocks.values()
    keys = ("isolation", "timeout", "memory", "validation")
    return [k for k in keys if any(k in entry.model_fields_set for entry in (scenario, *blocks))]
