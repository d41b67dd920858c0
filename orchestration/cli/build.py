"""`orchestrate build`: builds the project's own blocks as FMUs. Tests: tests/orchestration/cli/test_cli.py."""

from __future__ import annotations

import hashlib
from pathlib import Path

import click

from fmus.block import Block
from fmus.build import BLOCKS, BuildError, blocks_of
from fmus.build import build as build_fmus
from fmus.kit import flight
from fmus.native.toolchain import CompilerError

from ..errors import InputError, hint, writing
from ..fmu.archive import shown
from ..results.place import check_writable
from .console import notes, say
from .help import examples
from .options import FLAVOUR, out_folder
from .paths import PATH


@click.command(
    "build",
    epilog=examples(
        "orchestrate build",
        "orchestrate build plant allocator",
        "orchestrate build --flavour python -o fmus",
        "orchestrate build --fmi 3",
        "orchestrate build controller --sources flight/controller",
    ),
)
@click.argument("blocks", nargs=-1, metavar="[BLOCK]...")
@FLAVOUR
@click.option("--fmi", type=click.Choice(["2", "3"]), default="2", show_default=True, help="Version of FMI.")
@out_folder("Folder for the FMUs; default: out/fmus/FLAVOUR, with --fmi 3 out/fmus/fmi3.")
@click.option(
    "--sources",
    type=PATH,
    metavar="DIR",
    help="Write the C of one block for a flight project instead: build files, reference vectors with a runner, bill of "
    "materials, reports.",
)
def command(blocks: tuple[str, ...], flavour: str, fmi: str, out: Path | None, sources: Path | None) -> None:
    """Build the project's own blocks as FMUs."""
    for block in blocks:
        if block not in BLOCKS:
            raise InputError(f"there is no block {block!r}{hint(block, BLOCKS)}")
    if sources is not None:
        if len(blocks) != 1 or flavour != "native" or fmi != "2" or out is not None:
            raise InputError("--sources DIR: expected one block, and neither --out, --fmi nor --flavour python")
        _write_sources(blocks[0], sources)
        return
    if out is not None:
        check_writable(out)
    try:
        with writing(out or Path("out/fmus")):
            paths = build_fmus(blocks or None, flavour, out, int(fmi))
    except BuildError as error:
        raise InputError(str(error)) from None
    for path in paths.values():
        say(f"{shown(path)}  {path.stat().st_size / 1000:.0f} kB")
    for block in () if blocks else BLOCKS:
        if block not in blocks_of(flavour):
            say(f"{block} has no flavour {flavour!r}")


def _write_sources(block: str, folder: Path) -> None:
    chosen = Block.named(block)
    try:
        with writing(folder):
            files = flight.write(chosen.interface, chosen.folder, folder)
    except (flight.InUse, CompilerError) as error:
        raise InputError(str(error)) from None
    digest = hashlib.sha256((folder / flight.SUMS).read_bytes()).hexdigest()
    say(f"{shown(folder)}  {len(files)} files; SHA-256 of {flight.SUMS}: {digest}")
    proved = (folder / "reports" / "proved.txt").read_text("utf-8")
    if proved.startswith(flight.NOT_PROVED):
        notes([proved.splitlines()[0]])
