"""Gives a kit another name: its FMU, its files and the names in its code. Tests: tests/fmus/kit/test_rename.py."""

from __future__ import annotations

import re
from pathlib import Path

from ..interface import parse
from ..native.generate import camel_case

_NAME = re.compile(r"[a-z][a-z0-9_]*")
_TEXT = {".c", ".h", ".py", ".md", ".toml", ".csv", ""}
_OURS = ("fmi_shell", "tools", "vector", "build", ".venv", ".git")
"""Folders that hold nothing of this name."""


def rename(folder: Path, name: str) -> list[Path]:
    """Renames the kit in a folder and returns the files that changed; what is generated is left to `regenerate`.

    `--as allocator` and the swap's block keep the block's name. Raises ValueError where the name is no C identifier in
    small letters, the folder holds no kit, or a file of the new name is there.
    """
    there = folder / "interface.toml"
    if not there.is_file():
        raise ValueError(f"{folder} holds no interface.toml, so it is no kit; remedy: the folder of one")
    if not _NAME.fullmatch(name):
        raise ValueError(f"{name!r}: expected a name of small letters, digits and _, such as actuators")
    old = parse(there.read_text("utf-8"), str(there)).name
    if old == name:
        return []
    files = [p for p in sorted(folder.rglob("*")) if p.is_file() and p.relative_to(folder).parts[0] not in _OURS]
    moved = {path: path.with_name(_stem(path.name, old, name)) for path in files}
    if taken := [new for path, new in moved.items() if new != path and new.exists()]:
        raise ValueError(f"{taken[0]} is there already; remedy: another name")
    changed = []
    for path, new in moved.items():
        before = path.read_bytes()
        after = _renamed(before.decode("utf-8"), old, name).encode() if path.suffix in _TEXT else before
        if path.parts[-2:-1] == ("generated",) and new != path:
            path.unlink()  # it is written anew
        elif (after, new) != (before, path):
            path.unlink()
            new.write_bytes(after)
            changed.append(new)
    if (folder / old).is_dir():
        (folder / old).rename(folder / name)
        inside = [path for path in changed if folder / old in path.parents]
        changed = [path for path in changed if path not in inside]
        changed += [folder / name / path.relative_to(folder / old) for path in inside]
    return changed


def _stem(file: str, old: str, name: str) -> str:
    return re.sub(rf"^{re.escape(old)}(?=[._])", name, file)


def _renamed(text: str, old: str, name: str) -> str:
    """Returns a text with the names of code and files changed, but not what is said of the block that it replaces."""
    word, title = re.escape(old), re.escape(camel_case(old))
    text = re.sub(rf'(?m)^name = "{word}"$', f'name = "{name}"', text)
    text = re.sub(rf"(?<![\w-])(?<!--as ){word}(?=_\w|\.(?:fmu|c|h|py)\b|/|\$\(SUFFIX\))", name, text)
    text = re.sub(rf'(?<=here / "){word}(?=")|(?<=\[")(?:{word})(?="\])', name, text)
    text = re.sub(rf"\b{title}(?=[A-Z]\w*)", camel_case(name), text)
    return re.sub(rf"\b{re.escape(old.upper())}_H\b", f"{name.upper()}_H", text)
