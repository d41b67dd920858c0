"""`orchestrate export`: the system as a file for other tools."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import InputError
from ..export import container as container_writer
from ..export import ssp as ssp_writer
from ..export.system import flat
from ..fmu.archive import shown
from ..runner.read import load, read
from .console import say
from .overrides import overridden


@click.command("export")
@click.argument("scenario", type=click.Path(path_type=Path))
@click.option(
    "--ssp", type=click.Path(path_type=Path), metavar="FILE.ssp", help="As an SSP 1.0 archive: FMUs, wires and values."
)
@click.option(
    "--container",
    type=click.Path(path_type=Path),
    metavar="FILE.fmu",
    help="As one FMU that holds them all (needs fmu-manipulation-toolbox).",
)
@click.option("--step", metavar="T", help="Base step instead of the scenario's, in s or with a unit.")
@click.option("--flavour", metavar="native|python", help="Build of the project's own blocks instead of the scenario's.")
def command(scenario: Path, ssp: Path | None, container: Path | None, step: str | None, flavour: str | None) -> None:
    """Write a scenario as a file that other FMI tools read."""
    if ssp is None and container is None:
        raise InputError("expected --ssp FILE.ssp or --container FILE.fmu, or both")
    source = overridden(read(scenario), step=step, flavour=flavour)
    targets = [(path, suffix) for path, suffix in ((ssp, ".ssp"), (container, ".fmu")) if path is not None]
    for path, suffix in targets:
        if path.suffix != suffix:
            raise InputError(f"{path}: expected a name that ends in {suffix}")
        if not path.absolute().parent.is_dir():
            raise InputError(f"{path}: there is no folder {path.parent}")
    system = flat(load(source))
    for path, suffix in targets:
        try:
            (ssp_writer if suffix == ".ssp" else container_writer).write(system, path)
        except OSError as error:
            raise InputError(f"{path}: {error.strerror}") from None
        say(f"{shown(path)}  {path.stat().st_size / 1000:.0f} kB")
