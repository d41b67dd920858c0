"""`orchestrate build`: builds the project's own blocks as FMUs. Tests: tests/orchestration/cli/test_cli.py."""

from __future__ import annotations

from pathlib import Path

import click

from fmus.build import BLOCKS, BuildError, blocks_of
from fmus.build import build as build_fmus

from ..errors import InputError, hint, writing
from ..fmu.archive import shown
from .console import say
from .help import examples
from .options import FLAVOUR, out_folder


@click.command(
    "build",
    epilog=examples(
        "orchestrate build", "orchestrate build plant allocator", "orchestrate build --flavour python -o fmus"
    ),
)
@click.argument("blocks", nargs=-1, metavar="[BLOCK]...")
@FLAVOUR
@out_folder("Folder for the FMUs; default: out/fmus/FLAVOUR.")
def command(blocks: tuple[str, ...], flavour: str, out: Path | None) -> None:
    """Build the project's own blocks as FMUs."""
    for block in blocks:
        if block not in BLOCKS:
            raise InputError(f"there is no block {block!r}{hint(block, BLOCKS)}")
    try:
        with writing(out or Path("out/fmus")):
            paths = build_fmus(blocks or None, flavour, out)
    except BuildError as error:
        raise InputError(str(error)) from None
    for path in paths.values():
        say(f"{shown(path)}  {path.stat().st_size / 1000:.0f} kB")
    for block in () if blocks else BLOCKS:
        if block not in blocks_of(flavour):
            say(f"{block} has no flavour {flavour!r}")
