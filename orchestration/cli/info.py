"""`orchestrate info`: shows the equations, ports and parameters of a block or an FMU, with units, ranges and frames."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Any

import click
from click.shell_completion import CompletionItem

from ..acceptance.facts import HELPER, facts
from ..errors import InputError, hint
from ..fmu.interfaces import own
from .console import folded, say, say_json, say_table, table
from .help import examples
from .options import as_json
from .paths import PATH

_TABLES = {
    "input": "Inputs",
    "output": "Outputs",
    "parameter": "Parameters",
    HELPER: "Other ways to give start values, in a scenario",
    "calculatedParameter": "Calculated parameters",
}
_COLUMNS = ("name", "unit", "frame", "default", "range")


class _BlockOrFile(click.ParamType):
    """A block of the project or an FMU; a shell completes both."""

    name = "block"

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        blocks = [CompletionItem(block) for block in own() if block.startswith(incomplete)]
        return [*blocks, *PATH.shell_complete(ctx, param, incomplete)]


@click.command(
    "info",
    epilog=examples(
        "orchestrate info plant",
        "orchestrate info plant 'rod_*' epoch",
        "orchestrate info vendor.fmu",
        "orchestrate info vendor.fmu --json",
    ),
)
@click.argument("block", type=_BlockOrFile(), metavar="BLOCK|FILE.fmu")
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("--lenient", is_flag=True, help="Show an FMU whose description is not valid as far as it can be read.")
@as_json("all of it")
def command(block: str, names: tuple[str, ...], lenient: bool, json_: bool) -> None:
    """Show a block's equations, ports and parameters with units.

    BLOCK is one of the project's own, or the path of an FMU. NAMEs show these variables only; '*' stands for any text.
    Nothing of the FMU is run.
    """
    data = facts(block, lenient)
    data["variables"] = _chosen(data["variables"], names)
    if json_:
        say_json(data)
        return
    if not names:
        _head(data)
        _equations(data)
    for causality, title in _TABLES.items():
        if rows := [entry for entry in data["variables"] if entry["causality"] == causality]:
            _table(title, rows)
    others = [entry for entry in data["variables"] if entry["causality"] not in _TABLES]
    if others and names:
        _table("Other variables", others)
    elif others:
        say(f"\n{len(others)} other variable{'s' * (len(others) > 1)}, not exchanged in a loop; --json lists them")


def _chosen(variables: list[dict[str, Any]], names: Sequence[str]) -> list[dict[str, Any]]:
    for name in names:
        if not any(fnmatchcase(entry["name"], name) for entry in variables):
            raise InputError(f"there is no variable {name!r}{hint(name, (entry['name'] for entry in variables))}")
    return [entry for entry in variables if not names or any(fnmatchcase(entry["name"], name) for name in names)]


def _head(data: dict[str, Any]) -> None:
    say(f"{data['name']}: {data['kind']}", bold=True)
    if data["description"]:
        say(folded(data["description"]))
    say()
    experiment = {key: value for key, value in data["experiment"].items() if value is not None}
    lines = {
        "file": data.get("file"),
        "size": f"{data['bytes'] / 1000:.0f} kB" if "bytes" in data else None,
        "sha256": data.get("sha256"),
        "tool": data.get("generation_tool"),
        "author": data.get("author"),
        "version": data.get("version"),
        "flavours": ", ".join(data.get("flavours", ())),
        "platforms": ", ".join(data["platforms"]) or "none" if "platforms" in data else None,
        "capabilities": ", ".join(data.get("capabilities", ())),
        "experiment": ", ".join(
            f"{key} {value:.10g}" if isinstance(value, float) else f"{key} {value}" for key, value in experiment.items()
        ),
    }
    say_table(("", ""), [(key, text) for key, text in lines.items() if text])
    for problem in data.get("not_valid", ()):
        say(folded(f"not valid: {problem}"), fg="yellow")


def _equations(data: dict[str, Any]) -> None:
    """Prints equations and limits of a block, and what its numbers in brackets are; an FMU states none."""
    if equations := data.get("equations"):
        say("\nEquations", bold=True)
        for entry in equations:
            say(folded(entry["equation"]))
            say(folded(entry["meaning"], "    "), dim=True)
    if limits := data.get("limits"):
        say("\nLimits", bold=True)
        for limit in limits:
            say(folded(f"- {limit}"))
    if cited := data.get("citations"):
        say(f"\n{folded(cited)}")


def _table(title: str, entries: Sequence[dict[str, Any]]) -> None:
    """Prints a table with what each variable is below its row."""
    say(f"\n{title}", bold=True)
    columns = [c for c in zip(_COLUMNS, *map(_cells, entries), strict=True) if any(c[1:])]
    described = iter(entries)
    blank = [""] * len(columns)  # a line of the table behind each row, in whose place its description is printed
    rows = [cells for row in zip(*(c[1:] for c in columns), strict=True) for cells in (row, blank)]
    for line in table([c[0] for c in columns], rows, ["bold", ""] * len(entries)):
        if line:
            say(head=line)
            continue
        entry = next(described)
        items = f"one of {', '.join(entry['items'])}" if entry["items"] else ""
        if about := "; ".join(filter(None, (" ".join(entry["description"].split()), items))):
            say(folded(about, "    "), dim=True)


def _name(entry: dict[str, Any]) -> str:
    return entry["name"] + (f"[{','.join(map(str, entry['shape']))}]" if entry["shape"] else "")


def _cells(entry: dict[str, Any]) -> tuple[str, ...]:
    unit = entry["unit"] or ("" if entry["type"] in ("real", "enumeration") else entry["type"])
    default = "not connected" if entry["optional"] and entry["start"] is None else _value(entry["start"])
    return _name(entry), unit, entry["frame"] or "", default, _range(entry)


def _value(value: Any) -> str:
    """Returns a start value in words: a matrix that has nothing beside its diagonal by that."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.7g}"
    if not isinstance(value, list):
        return str(value)
    if isinstance(value[0], list) and len(value) == len(value[0]):
        diagonal = [row[i] for i, row in enumerate(value)]
        if len(value) > 1 and not any(x for i, row in enumerate(value) for j, x in enumerate(row) if i != j):
            return f"diagonal {_value(diagonal)}"
    return f"[{', '.join(map(_value, value))}]"


def _range(entry: dict[str, Any]) -> str:
    low, high = entry["min"], entry["max"]
    if low is None and high is None:
        return ""
    if low is None or high is None:
        return f"<= {_value(high)}" if low is None else f">= {_value(low)}"
    return f"{_value(low)} to {_value(high)}"
