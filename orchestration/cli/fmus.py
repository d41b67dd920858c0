"""`orchestrate fmus`: lists or copies the project's own FMUs. Tests: tests/orchestration/cli/test_cli.py."""

from __future__ import annotations

import filecmp
import shutil
from pathlib import Path

import click

from fmus.build import BLOCKS, BuildError, blocks_of, ensure, ensure_all

from ..errors import InputError, writing
from ..fmu.archive import shown
from ..results.place import check_writable
from ..results.whole import putting
from .console import say
from .help import examples
from .options import FLAVOUR
from .paths import PATH


@click.command(
    "fmus",
    epilog=examples("orchestrate fmus", "orchestrate fmus --copy .", "orchestrate fmus --copy python --flavour python"),
)
@click.option("--copy", type=PATH, metavar="DIR", help="Copy them into this folder.")
@FLAVOUR
def command(copy: Path | None, flavour: str) -> None:
    """List the project's own FMUs, or copy them.

    Those that are missing or older than their sources are built first.
    """
    if copy is not None:
        check_writable(copy)
    try:
        if flavour == "native":
            ensure_all(blocks_of(flavour))
        paths = [ensure(block, flavour) for block in blocks_of(flavour)]
    except BuildError as error:
        raise InputError(str(error)) from None
    for path in paths:
        there = None if copy is None else copy / path.name
        if there and there.exists() and not (there.is_file() and filecmp.cmp(path, there, shallow=False)):
            raise InputError(f"{there} is there already and differs; expected a folder without it")
    for path in paths:
        say(f"{shown(path if copy is None else copied(path, copy))}  {path.stat().st_size / 1000:.0f} kB")
    for block in BLOCKS:
        if block not in blocks_of(flavour):
            say(f"{block} has no flavour {flavour!r}")


def copied(path: Path, folder: Path) -> Path:
    """Copies a file into a folder, which is made if it is missing, and returns it. Raises ResultsError."""
    target = folder.absolute() / path.name
    with writing(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        with putting(target) as part:
            shutil.copyfile(path, part)
    return target
