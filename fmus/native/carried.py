"""The C of a block as one folder of files: `sources/` of its FMU, and a project of flight software.

Which files these are is what `lay_out` gives the compiler, as folders of headers with the C beside them. Here they only
get names within one folder. Tests: tests/native/test_carried.py.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from posixpath import normpath

from ..interface import InterfaceError

_INCLUDED = re.compile(r'^#include ["<]([\w/.]+)[">]', re.MULTILINE)


def collected(folders: Iterable[Path], without: Collection[str] = ()) -> dict[str, bytes]:
    """Returns the C in these folders and the headers that it includes, by their names from the folder on, sorted.

    `without`: names that are left out. Raises InterfaceError where two files would have one name.
    """
    files: dict[str, bytes] = {}
    for folder in folders:
        for path in sorted(path for path in folder.rglob("*") if path.suffix in (".c", ".cpp", ".h")):
            name = path.relative_to(folder).as_posix()
            if name in files:
                raise InterfaceError(f"{path}: another file of the block's sources has the name {name}")
            if name not in without:
                files[name] = path.read_bytes().replace(b"\r\n", b"\n")
    return _reached(files)


def _reached(files: Mapping[str, bytes]) -> dict[str, bytes]:
    reached, open_ = set(), [name for name in files if name.endswith((".c", ".cpp"))]
    while open_:
        name = open_.pop()
        if name not in reached:
            reached.add(name)
            beside = name.rpartition("/")[0]
            for included in _INCLUDED.findall(files[name].decode()):
                open_ += [place for place in (normpath(f"{beside}/{included}"), included) if place in files]
    return {name: files[name] for name in sorted(reached)}
