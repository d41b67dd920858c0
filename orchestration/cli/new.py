"""`orchestrate new`: writes a small project for another team's FMU or device, with a test vector from our block.

Tests: tests/fmus/kit/.
"""

from __future__ import annotations

import shlex
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

import click

from fmus import kit
from fmus.interface import BLOCKS, load
from fmus.kit import linked
from fmus.native.toolchain import CompilerError

from ..acceptance.vector import name_of, record, scenario_of
from ..errors import InputError, hint, writing
from ..fmu.archive import shown
from ..instances.law import ESTIMATE
from ..session.open import asked_for, open_fmus
from ..session.read import load as load_scenario
from .console import say
from .help import examples
from .paths import PATH


def others() -> dict[str, EntryPoint]:
    """Returns what installed packages write, by their entry points of the group `orchestrate.new`: commands of their
    own."""
    return {point.name: point for point in entry_points(group="orchestrate.new")}


class _New(click.Command):
    """`orchestrate new NAME ...` is a command of its own where a package has one of this name."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        if args and (point := others().get(args[0])) is not None:
            own: click.Command = point.load()
            return own.make_context(f"{info_name} {args[0]}", args[1:], parent, **extra)
        return super().make_context(info_name, args, parent, **extra)


@click.command(
    "new",
    cls=_New,
    epilog=examples(
        "orchestrate new allocator",
        "orchestrate new controller mine --lang python",
        "orchestrate new plant --scenario loop.yaml",
        "orchestrate new controller board --link",
        "orchestrate new controller packed --from my_law.py",
        "orchestrate new satellite",
    ),
)
@click.argument("block")
@click.argument("folder", required=False, type=PATH, metavar="[DIR]")
@click.option("--lang", type=click.Choice(["c", "python"]), show_default="c", help="Language of the project.")
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
@click.option(
    "--from",
    "law",
    type=PATH,
    metavar="LAW.py",
    help="A law in Python that the project packs.",
)
def command(
    block: str, folder: Path | None, lang: str | None, link_: bool, scenario: Path | None, law: Path | None
) -> None:
    """Write a project for another team, or a satellite's file.

    The project's FMU has the exact interface of BLOCK.
    The project contains the build files (C needs only a compiler and make), a README and a test vector.
    With --link the project contains a skeleton of the device's firmware, a bench that plays the vector at the device,
    and the FMU that stands for the block in any tool and asks the device over UDP, TCP, a serial line or a pipe.

    `orchestrate new satellite -h` lists what a satellite's file is made of.
    """
    if law is not None and (link_ or lang == "c"):
        raise InputError(f"--from: expected neither --link nor --lang c beside it, since {law} is Python")
    if law is not None and not law.is_file():
        raise InputError(f"--from {law}: there is no such file")
    lang = lang or ("python" if law else "c")
    if block not in BLOCKS:
        raise InputError(f"there is no block {block!r}{hint(block, [*BLOCKS, *others()])}")
    target = folder or Path(f"{block}_device_{lang}" if link_ else f"{block}_{lang}")
    run = scenario or scenario_of(block)
    if not run.exists():
        raise InputError(
            f"{shown(run)}: there is no such file; --scenario names the run that the test vector is taken from"
        )
    if target.exists() and not target.is_dir():
        raise InputError(f"{target} is a file; expected a folder")
    try:
        with writing(target), _undone(target):
            kit.refuse_other(load(block), target, "vector", *(linked.PARTS if link_ else ()))
            rows = record(run, block, target / "vector")
            if link_:
                files = linked.write(load(block), target, lang)
            elif law is None:
                files = kit.write(load(block), target, lang)
            else:
                files = kit.write(load(block), target, lang, law.read_bytes(), _left_out(run, block))
    except (kit.InUse, CompilerError) as error:
        raise InputError(str(error)) from None
    say(f"{target}: {len(files)} files, and a test vector of {rows} instants from {shown(run)}")
    there = shlex.quote(str(target))
    if link_:
        say(f"\n  cd {there}")
        say("  make vector" if lang == "c" else f"  python bench.py vector run {block}_device.py")
        say(f"  {'build/device' if lang == 'c' else f'python {block}_device.py'} udp 5020 &")
        _two_ways(f"{block}_link.fmu", block, run, [])
        return
    build = "make" if lang == "c" else "python build.py"
    say(f"\n  cd {there} && {build}")
    say(f"  orchestrate check {block}.fmu --as {block}")
    _two_ways(f"{block}.fmu", block, run, ["make vector"] if lang == "c" else [])


def _left_out(run: Path, block: str) -> dict[str, float | str]:
    """Returns by outputs what they are where a law leaves them out, as where its file flies in this scenario."""
    scenario = load_scenario(run)
    name, fmus = name_of(scenario, block) or block, open_fmus(scenario)
    model = asked_for(scenario, name, fmus).model
    found: dict[str, float | str] = {}
    for variable in model.of("output"):
        value = model.starts.get(variable.elements[0])
        inputs = {v.name for v in model.of("input")}
        if variable.name in model.needed:
            if (own := variable.name.removesuffix(ESTIMATE)) != variable.name and own in inputs:
                found[variable.name] = own
        elif value and value != fmus[name].model.starts.get(variable.elements[0]):
            found[variable.name] = value
    return found


@contextmanager
def _undone(folder: Path) -> Iterator[None]:
    """Leaves nothing of what fails inside in a folder that was missing or empty."""
    new = next((path for path in (*reversed(folder.parents), folder) if not path.exists()), None)
    empty = new is None and not any(folder.iterdir())
    try:
        yield
    except BaseException:
        if new is not None or empty:
            shutil.rmtree(new or folder, ignore_errors=True)
        if empty:
            folder.mkdir(exist_ok=True)
        raise


def _two_ways(fmu: str, block: str, run: Path, more: list[str]) -> None:
    """Prints how to judge the block: only one with our equations can give the outputs of the vector."""
    say("\nWith the same equations as ours, compare it with the test vector:")
    for command in (*more, f"orchestrate check {fmu} --as {block} --vector vector"):
        say(f"  {command}")
    say("With equations of your own, fly it in the loop:")
    say(f"  orchestrate {shlex.quote(str(run.resolve()))} --swap {name_of(load_scenario(run), block)}={fmu}")
