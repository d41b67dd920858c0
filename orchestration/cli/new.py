"""`orchestrate new`: writes a small project for another team's FMU or device, with a test vector from our block.

Tests: tests/orchestration/cli/test_new_satellite.py, tests/fmus/kit/.
"""

from __future__ import annotations

import re
import shlex
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import click

from fmus import kit
from fmus.interface import BLOCKS, load
from fmus.kit import linked
from fmus.native.toolchain import CompilerError

from ..acceptance.vector import name_of, record, scenario_of
from ..campaign.drawing.expression import Expression
from ..errors import BlockError, InputError, ResultsError, hint, writing
from ..fmu.archive import shown
from ..quantities import QuantityError, parse_unit, value_in
from ..results.whole import put
from ..scenario import template
from ..session.open import open_scenario
from ..session.read import load as load_scenario
from ..session.read import read
from ..session.run import whole
from .console import say
from .help import examples
from .overrides import settings
from .paths import PATH


@click.command(
    "new",
    epilog=examples(
        "orchestrate new allocator",
        "orchestrate new controller mine --lang python",
        "orchestrate new plant --scenario loop.yaml",
        "orchestrate new controller board --link",
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
@click.option("--set", "sets", multiple=True, metavar="NAME=VALUE", help="A value of a satellite; may be repeated.")
def command(
    block: str, folder: Path | None, lang: str | None, link_: bool, scenario: Path | None, sets: tuple[str, ...]
) -> None:
    """Write a project for another team, or a satellite's file.

    The project's FMU has the exact interface of BLOCK.
    The project contains the build files (C needs only a compiler and make), a README and a test vector.
    With --link the project contains a skeleton of the device's firmware, a bench that plays the vector at the device,
    and the FMU that stands for the block in any tool and asks the device over UDP, TCP, a serial line or a pipe.

    For a satellite it writes its file and a scenario that flies it, which is called after DIR;
    without --set NAME=VALUE the command says which values it needs.
    """
    if block in template.names():
        options = {"--lang": lang, "--link": link_, "--scenario": scenario}
        if given := [option for option, value in options.items() if value]:
            raise InputError(f"{given[0]}: a {block} is data alone and has no project; expected --set NAME=VALUE only")
        _fill(template.read(block), folder or Path(block), settings(sets))
        return
    lang = lang or "c"
    if sets:
        raise InputError(f"--set: {block!r} has no values to set; only {', '.join(template.names())} has")
    if block not in BLOCKS:
        raise InputError(f"there is no block {block!r}{hint(block, [*BLOCKS, *template.names()])}")
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
            files = linked.write(load(block), target, lang) if link_ else kit.write(load(block), target, lang)
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


def _computed(found: template.Template, given: dict[str, Any]) -> dict[str, str]:
    """Returns the values that follow from given ones, and from those. Raises InputError for one that is no number."""
    values: dict[str, str] = {}
    for name, entry in found.values.items():
        if "expression" not in entry:
            continue
        expression = Expression(entry["expression"], found.values, list(found.values))
        needed, known = expression.uses & found.values.keys(), {**values, **given}
        if needed <= known.keys():
            numbers = {used: _number(used, known[used], found.values[used]) for used in needed}
            try:
                values[name] = f"{expression.value(numbers):.7g} {entry['unit']}"
            except QuantityError:
                used = ", ".join(f"--set {used}={known[used]}" for used in sorted(needed))
                raise InputError(
                    f"{used}: the value of {name} cannot be computed from it; it is {entry['what']}"
                ) from None
    return values


def _number(name: str, value: Any, entry: dict[str, Any]) -> float:
    """Returns the number in the unit and the range that are stated for it. Raises InputError."""
    try:
        unit = parse_unit(entry["unit"])
        number = value_in(str(value), unit)
    except QuantityError as error:
        raise InputError(f"--set {name}: {error}") from None
    if "range" in entry:
        least, most = entry["range"]
        if not value_in(least, unit) <= number <= value_in(most, unit):
            found = f"{value} ({number:.10g} {entry['unit']})"
            raise InputError(f"--set {name}: expected {least} to {most}, found {found}")
    return number


def _fill(found: template.Template, folder: Path, given: dict[str, Any]) -> None:
    """Writes the files of a template, none that is there already, and flies a sample.

    So a value that no block takes is told now.
    """
    if own := re.sub(r"[^\w.-]", "_", folder.absolute().name).lstrip(".-"):
        given = {"name": own, **given}
    files = {folder / name: text for name, text in found.filled(given, _computed(found, given)).items()}
    if there := next((path for path in files if path.exists()), None):
        raise InputError(f"{there} is there already; expected a folder without it")
    new = not folder.exists()
    try:
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            for path, text in files.items():
                put(path, text)
        written = read(folder / found.flown)
        loop = open_scenario(load_scenario(written)).plan.scenario
        sample = loop.step * max(entry.every for entry in loop.blocks.values())
        short = written.without([("record",), ("expect",), ("figures",)]).with_entry(("duration",), sample)
        first = whole(load_scenario(short))
        if first.failure is not None:
            raise InputError(f"{first.failure}\nnothing was written; remedy: --set with a value that the block takes")
    except (InputError, BlockError, ResultsError, KeyboardInterrupt) as error:
        with suppress(OSError):
            for path in files:
                path.unlink(missing_ok=True)
            if new:
                folder.rmdir()
        if isinstance(error, InputError):
            raise InputError(*(found.told(problem, folder) for problem in error.problems)) from None
        raise
    say(f"{folder}: {found.about}")
    for path in files:
        say(f"  {path}")
