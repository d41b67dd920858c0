"""`orchestrate new`: a small project for another team, for its FMU or its device, with a test vector from our block."""

from __future__ import annotations

from pathlib import Path

import click

from fmus import kit
from fmus.interface import BLOCKS, load
from fmus.kit import linked
from fmus.native.toolchain import CompilerError

from ..acceptance.vector import record, scenario_of
from ..errors import InputError, hint, reason
from ..fmu.archive import shown
from .console import say
from .help import examples
from .paths import PATH


@click.command(
    "new",
    epilog=examples(
        "orchestrate new allocator",
        "orchestrate new controller mine --lang python",
        "orchestrate new plant --scenario loop.yaml",
        "orchestrate new controller board --link",
    ),
)
@click.argument("block")
@click.argument("folder", required=False, type=PATH, metavar="[DIR]")
@click.option(
    "--lang", type=click.Choice(["c", "python"]), default="c", show_default=True, help="Language of the project."
)
@click.option(
    "--link",
    "link_",
    is_flag=True,
    help="For a device at the end of a line instead: its firmware, and the FMU that asks it.",
)
@click.option(
    "--scenario",
    type=PATH,
    metavar="FILE",
    help="The run of which the test vector is a part; default: one of the project's own.",
)
def command(block: str, folder: Path | None, lang: str, link_: bool, scenario: Path | None) -> None:
    """Write a project from which another team makes its FMU or, with --link, its device.

    Its FMU has the block's exact interface. The project contains the build files (C needs only a compiler and make), a README and a test vector.
    With --link the project contains a skeleton of the device's firmware, a bench that plays the vector at the device, and the
    FMU that stands for the block in any tool and asks the device over UDP, TCP, a serial line or a pipe.
    """
    if block not in BLOCKS:
        raise InputError(f"there is no block {block!r}{hint(block, BLOCKS)}")
    target = folder or Path(f"{block}_device_{lang}" if link_ else f"{block}_{lang}")
    run = scenario or scenario_of(block)
    if not run.exists():
        raise InputError(
            f"{shown(run)}: there is no such file; --scenario names the run that the test vector is taken from"
        )
    if target.exists() and not target.is_dir():
        raise InputError(f"{target} is a file; expected a folder")
    try:
        kit.refuse_other(load(block), target, "vector", *(linked.PARTS if link_ else ()))
        rows = record(run, block, target / "vector")
        files = linked.write(load(block), target, lang) if link_ else kit.write(load(block), target, lang)
    except (kit.InUse, CompilerError) as error:
        raise InputError(str(error)) from None
    except OSError as error:
        raise InputError(f"{error.filename}: {reason(error)}; expected a folder that can be written") from None
    say(f"{target}: {len(files)} files, and a test vector of {rows} instants from {shown(run)}")
    if link_:
        say(f"\n  cd {target}")
        say("  make vector" if lang == "c" else f"  python bench.py vector run {block}_device.py")
        say(f"  {'build/device' if lang == 'c' else f'python {block}_device.py'} udp 5020 &")
        say(f"  orchestrate check {block}_link.fmu --as {block} --vector vector")
        return
    build = "make" if lang == "c" else "python build.py"
    say(f"\n  cd {target} && {build}")
    if lang == "c":
        say("  make vector")
    say(f"  orchestrate check {block}.fmu --as {block} --vector vector")
