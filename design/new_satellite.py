"""`orchestrate new satellite`: a satellite's file, its sensors and a tumble, from what its data sheet gives."""

from __future__ import annotations

import re
import shlex
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import click

from fmus import places
from orchestration import InputError
from orchestration.cli.console import complain, say
from orchestration.cli.console import notes as tell
from orchestration.cli.help import examples
from orchestration.cli.overrides import settings
from orchestration.errors import BlockError, ResultsError, reason, writing
from orchestration.results.whole import content, put
from orchestration.scenario.text import parse
from orchestration.session.open import open_scenario
from orchestration.session.read import load, read
from orchestration.session.run import whole

from . import template
from .plausible import findings
from .sheet import followed, wheel_axes
from .template import flow

PARTS = {
    "cubesat": ("sensors_cubesat.yaml", ["cubesat.yaml"]),
    "star tracker": ("sensors_star_tracker.yaml", ["50kg_star_tracker.yaml", "paper_satellite.yaml"]),
    "perfect": ("sensors_perfect.yaml", []),
}
"""By the name of a set of sensors: its template, and the files of scenarios/sensors that it extends."""


def templates() -> template.Template:
    return template.read(places.shared("scenarios") / "templates" / "satellite")


class _Command(click.Command):
    """Its help lists the values."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Values; in brackets what holds if they are not given"):
            formatter.write_dl(templates().listed())
        super().format_epilog(ctx, formatter)


@click.command(
    "satellite",
    cls=_Command,
    epilog=examples("orchestrate new satellite mine --interactive", "orchestrate new satellite"),
)
@click.argument("folder", required=False, type=click.Path(path_type=Path), metavar="[DIR]")
@click.option("--set", "sets", multiple=True, metavar="NAME=VALUE", help="A value of the satellite; may be repeated.")
@click.option("--interactive", is_flag=True, help="Ask in the terminal for what is not given.")
def command(folder: Path | None, sets: tuple[str, ...], interactive: bool) -> None:
    """Write a satellite's file, its sensors and a tumble that flies them, from what its data sheet gives.

    Without --set NAME=VALUE the command says which values it needs. The files have each value as it was given, and in a
    comment what follows from it. What is not plausible is named, and written all the same.
    """
    found, given = templates(), {name: _chosen(name, value) for name, value in settings(sets).items()}
    if interactive:
        given = asked(found, given)
    fill(found, folder or Path("satellite"), given)


def asked(found: template.Template, given: dict[str, Any]) -> dict[str, Any]:
    """Returns what is given and what the user answers for each value with an example, and for wheels and sensors.

    An empty answer leaves a default, or one of two values that can stand for each other; a wrong one is asked again.
    """
    answers = dict(given)
    for name, entry in sorted(found.values.items(), key=lambda item: item[0] != "wheels"):
        instead = [other.partition("=") for other in entry.get("instead", ())]
        if name in answers or any(n in answers and (not value or answers[n] == value) for n, _, value in instead):
            continue
        if name in ("wheels", "sensors") or (name == "wheel_axis" and answers.get("wheels", "one") == "one"):
            without = f"; Enter: {flow(entry['default'])}"
        elif name == "inertia" or (name == "mass" and "inertia" in answers):
            without = "; Enter: that of a mass" if name == "inertia" else "; Enter: not stated"
        elif name == "mass" or "example" in entry:
            without = ""
        else:
            continue
        shown = f", such as {entry['example']}" if "example" in entry else ""
        while (value := _answer(found, name, f"{name}: {entry['what']}{shown}{without}")) is None and not without:
            pass
        if value is not None:
            answers[name] = value
    return answers


def _chosen(name: str, value: Any) -> Any:
    """Returns a value that is a name in small letters; `sensors` may be a path, which stays as it is."""
    if not isinstance(value, str) or name not in ("body_axis", "wheels", "sensors"):
        return value
    return value if name == "sensors" and value.lower() not in PARTS else value.lower()


def _answer(found: template.Template, name: str, text: str) -> Any:
    """Returns the answer to a question, which is asked until the answer can be taken; None of an empty one."""
    while answer := click.prompt(text, default="", show_default=False, err=True).strip():
        try:
            value = _chosen(name, parse(answer, name).data)
            if "unit" in found.values[name]:
                found.number(name, value)
            elif name == "wheels":
                wheel_axes(str(value))
            elif name == "sensors":
                _sensors(str(value))
            elif name == "inertia" and not isinstance(value, (list, dict)):
                raise InputError(f"expected three moments or three rows of three, found {answer}")
        except InputError as error:
            complain(str(error).removeprefix(f"--set {name}: "))
            continue
        return value
    return None


def fill(found: template.Template, folder: Path, given: dict[str, Any]) -> None:
    """Writes the files, none that is there already, and flies a sample, so that a wrong value is told now."""
    if own := re.sub(r"[^\w.-]", "_", folder.absolute().name).lstrip(".-"):
        given = {"name": own, **given}
    if "orbit_radius" in given and "altitude" in given:
        raise InputError("--set altitude, --set orbit_radius: expected one of them, since each follows from the other")
    found.check(given)
    values, texts = followed(found, given)
    sensors, parts = _sensors(str(values["sensors"]))
    loop = "planned.yaml" if texts["plant"] == "plant" else "wheels.yaml"
    made_of = {"satellite.yaml": "satellite.yaml", "sensors.yaml": sensors, found.flown: loop}
    files = {folder / name: found.filled(source, values, texts) for name, source in made_of.items()}
    files |= {folder / "parts" / name: text for name, text in parts.items()}
    if there := next((path for path in files if path.exists()), None):
        raise InputError(f"{there} is there already; expected a folder without it")
    notes: list[str] = []
    unused = [name for name in given if name.startswith("wheel_")] if values["wheels"] == "none" else []
    with _undone(folder, list(files)):
        try:
            with writing(folder):
                for path, text in files.items():
                    path.parent.mkdir(parents=True, exist_ok=True)
                    put(path, text)
            written = read(folder / found.flown)
            loaded = load(written)
            opened = open_scenario(loaded).plan.scenario
            notes = [str(finding) for finding in findings(loaded)]
            sample = opened.step * max(entry.every for entry in opened.blocks.values())
            first = whole(
                load(
                    written.without([("record",), ("expect",), ("figures",), ("live",)]).with_entry(
                        ("duration",), sample
                    )
                )
            )
            if first.failure is not None:
                remedy = "nothing was written; remedy: --set with a value that the block takes"
                raise InputError(f"{first.failure}\n{remedy}")
        except InputError as error:
            tell(notes)  # the reason may be among them
            raise InputError(*(found.told(problem, folder, made_of) for problem in error.problems)) from None
    say(f"{folder}: {found.about}")
    for path in files:
        say(f"  {path}")
    flown = shlex.quote(str(folder / found.flown))
    say(f"fly it:        orchestrate {flown}\nreview it:     orchestrate review {flown}")
    if bare := found.bare(given):
        tell([f"numbers without a unit were taken in SI units: {', '.join(bare)}"])
    if unused:
        tell([f"with wheels=none {', '.join(unused)} count for nothing"])
    tell(notes)


def _sensors(name: str) -> tuple[str, dict[str, str]]:
    """Returns the template of a set of sensors and the texts of the files that it extends. Raises InputError."""
    if name in PARTS:
        file, parts = PARTS[name]
        shared = places.shared("scenarios") / "sensors"
        return file, {part: (shared / part).read_text("utf-8") for part in parts}
    path = Path(name).expanduser()
    if not path.is_file():
        raise InputError(f"--set sensors: expected {', '.join(PARTS)} or the path of a file, found {name!r}")
    try:
        return "sensors_own.yaml", {"own.yaml": content(path).decode("utf-8")}
    except (OSError, ValueError) as error:
        raise InputError(f"--set sensors: {path} cannot be read: {reason(error)}") from None


@contextmanager
def _undone(folder: Path, files: list[Path]) -> Iterator[None]:
    """Leaves nothing of the files where what stands inside fails."""
    new, parts = not folder.exists(), folder / "parts"
    new_parts = not parts.exists()
    try:
        yield
    except (InputError, BlockError, ResultsError, KeyboardInterrupt):
        with suppress(OSError):
            for path in files:
                path.unlink(missing_ok=True)
            if new_parts:
                parts.rmdir()
        if new:
            shutil.rmtree(folder, ignore_errors=True)
        raise
