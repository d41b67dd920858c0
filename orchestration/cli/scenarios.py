"""`orchestrate scenarios`: the project's own scenarios, and copies of them to start from."""

from __future__ import annotations

from pathlib import Path

import click

from fmus import places

from ..errors import InputError
from ..fmu.archive import shown
from .console import say
from .fmus import copied
from .paths import PATH


@click.command("scenarios")
@click.option("--copy", type=PATH, metavar="DIR", help="Copy them into this folder.")
def command(copy: Path | None) -> None:
    """List the project's own scenarios, or copy them."""
    paths = sorted(places.shared("scenarios").glob("*.yaml"))
    if copy is not None and (there := next((copy / p.name for p in paths if (copy / p.name).exists()), None)):
        raise InputError(f"{there} is there already; expected a folder without it")
    for path in paths:
        say(str(shown(path if copy is None else copied(path, copy))))
