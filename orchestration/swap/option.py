"""Blocks swapped by `--swap` and `--map` on the command line, or by the same entries of a campaign."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import InputError, Place, Problem, hint
from ..fmu.interfaces import is_path, own
from ..paths import located
from ..scenario.source import Source


@dataclass(frozen=True)
class Swap:
    """Another FMU in a block's place."""

    block: str
    file: str
    place: str
    """Where it is asked for, for messages: `--swap allocator=vendor.fmu`."""
    mapping: str | None = None
    mapping_place: str = ""


def swaps_of(swaps: Sequence[str], maps: Sequence[str] = ()) -> list[Swap]:
    """Returns what `allocator=vendor.fmu`, and `mapping.yaml` or `allocator=mapping.yaml`, ask for.

    Raises InputError.
    """
    asked: dict[str, Swap] = {}
    for text in swaps:
        block, equals, file = (part.strip() for part in text.partition("="))
        if not equals or not block or not file:
            raise InputError(f"--swap {text}: expected block=file.fmu, such as allocator=vendor.fmu")
        if block in asked:
            raise InputError(f"--swap {text}: {block} is swapped twice")
        asked[block] = Swap(block, file, f"--swap {block}={file}")
    for text in maps:
        block, _, file = (part.strip() for part in text.rpartition("="))
        if not block and len(asked) != 1:
            where = "the --swap that it belongs to" if not asked else f"which of {', '.join(asked)}: --map BLOCK={text}"
            raise InputError(f"--map {text}: expected {where}")
        block = block or next(iter(asked))
        if block not in asked:
            raise InputError(f"--map {text}: {block} is not swapped{hint(block, asked)}")
        if asked[block].mapping is not None:
            raise InputError(f"--map {text}: {block} is mapped twice")
        asked[block] = replace(asked[block], mapping=file, mapping_place=f"--map {file}")
    return list(asked.values())


def swapped(source: Source, swaps: Iterable[Swap]) -> Source:
    """Returns a scenario's source with blocks swapped; relative paths start at the current folder.

    Raises InputError.
    """
    blocks = source.data.get("blocks") if isinstance(source.data, dict) else None
    for swap in swaps:
        entry = blocks.get(swap.block) if isinstance(blocks, dict) else None
        if not isinstance(entry, dict):
            text = f"there is no block {swap.block!r}{hint(swap.block, blocks or ())}"
            raise InputError(Problem(text, place=Place(swap.place)))
        if not is_path(swap.file):
            raise InputError(Problem(expected="the path of an .fmu", place=Place(swap.place)))
        interface: Any = entry.get("interface", entry.get("fmu"))
        if "interface" not in entry and isinstance(interface, str) and is_path(interface):
            # What stands there now keeps an interface of its own, unless its name says which.
            interface = swap.block if swap.block in own() else str((source.folder / interface).resolve())
        here = Path.cwd()
        source = source.without(("blocks", swap.block, key) for key in ("telemetry", "python", "orbit"))
        values = {"fmu": str(located(swap.file, here)), "interface": interface, "flavour": None}
        for key, value in values.items():
            source = source.with_entry(("blocks", swap.block, key), value, swap.place if value is not None else "")
        path = str(located(swap.mapping, here)) if swap.mapping else None
        source = source.with_entry(("blocks", swap.block, "map"), path, swap.mapping_place if path else "")
    return source
