"""`orchestrate scenarios`: lists or copies the project's own scenarios. Tests: tests/packaging/test_wheel.py."""

from __future__ import annotations

from pathlib import Path

import click

from fmus import places

from ..errors import InputError
from ..fmu.archive import shown
from .console import say
from .fmus import copied
from .help import examples
from .paths import PATH


@click.command("scenarios", epilog=examples("orchestrate scenarios", "orchestrate scenarios --copy mine"))
@click.option("--copy", type=PATH, metavar="DIR", help="Copy them into this folder.")
def command(copy: Path | None) -> None:
    """List the project's own scenarios, or copy them."""
    folder = places.shared("scenarios")
    paths = sorted(folder.glob("*.yaml"))
    parts = sorted(folder.glob("*/*.yaml"))  # which scenarios extend
    inside = [path.relative_to(folder) for path in (*paths, *parts)]
    if copy is not None and (there := next((copy / path for path in inside if (copy / path).exists()), None)):
        raise InputError(f"{there} is there already; expected a folder without it")
    for path in paths if copy is None else (*paths, *parts):
        say(str(shown(path if copy is None else copied(path, (copy / path.relative_to(folder)).parent))))
