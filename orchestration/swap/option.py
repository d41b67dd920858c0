"""Blocks swapped on the command line: `--swap` and `--map`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError, hint
from ..fmu.interfaces import is_path, own
from ..paths import located
from ..scenario.source import Source


def swapped(source: Source, swaps: Sequence[str], maps: Sequence[str] = ()) -> Source:
    """A scenario's source with blocks swapped: `allocator=vendor.fmu`, and `mapping.yaml` or `allocator=mapping.yaml`."""
    files: dict[str, str] = {}
    for text in swaps:
        block, file = _parted(text, f"--swap {text}", "block=file.fmu, such as allocator=vendor.fmu")
        if block in files:
            raise InputError(f"--swap {text}: {block} is swapped twice")
        files[block] = file
    blocks = source.data.get("blocks") if isinstance(source.data, dict) else None
    mappings_of: dict[str, str] = {}
    for text in maps:
        block, _, file = text.rpartition("=")
        if not block and len(files) != 1:
            where = "the --swap that it belongs to" if not files else f"which of {', '.join(files)}: --map BLOCK={text}"
            raise InputError(f"--map {text}: expected {where}")
        block = block.strip() or next(iter(files))
        if block not in files:
            raise InputError(f"--map {text}: {block} is not swapped{hint(block, files)}")
        if block in mappings_of:
            raise InputError(f"--map {text}: {block} is mapped twice")
        mappings_of[block] = file.strip()
    for block, file in files.items():
        option = f"--swap {block}={file}"
        entry = blocks.get(block) if isinstance(blocks, dict) else None
        if not isinstance(entry, dict):
            raise InputError(f"{option}: there is no block {block!r}{hint(block, blocks or ())}")
        source = _swap(source, block, entry, file, mappings_of.get(block), option)
    return source


def _swap(source: Source, block: str, entry: dict[str, Any], file: str, map_file: str | None, option: str) -> Source:
    here = Path.cwd()
    if not is_path(file):
        raise InputError(f"{option}: expected the path of an .fmu")
    interface: Any = entry.get("interface", entry.get("fmu"))
    if "interface" not in entry and isinstance(interface, str) and is_path(interface):
        # What stands there now keeps an interface of its own, unless its name says which.
        interface = block if block in own() else str((source.folder / interface).resolve())
    values = {"fmu": str(located(file, here)), "interface": interface, "flavour": None}
    for key, value in values.items():
        source = source.with_entry(("blocks", block, key), value, option if value is not None else "")
    path = None if map_file is None else str(located(map_file, here))
    return source.with_entry(("blocks", block, "map"), path, f"--map {map_file}" if path else "")


def _parted(text: str, option: str, expected: str) -> tuple[str, str]:
    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name or not value:
        raise InputError(f"{option}: expected {expected}")
    return name, value
