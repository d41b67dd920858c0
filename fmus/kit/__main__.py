"""python -m fmus.kit FOLDER: writes what is generated in FOLDER anew from FOLDER/interface.toml.
With --name NAME the kit gets another name first: its FMU, its files and the names in its code.
Tests: tests/fmus/kit/test_kit.py."""

from __future__ import annotations

import sys
from pathlib import Path

from . import linked, regenerate
from .rename import rename

arguments = sys.argv[1:]
if "--name" in arguments[:-1]:
    at = arguments.index("--name")
    name, arguments = arguments[at + 1], arguments[:at] + arguments[at + 2 :]
    for folder in map(Path, arguments):
        try:
            for path in rename(folder, name):
                print(path)
        except ValueError as error:
            sys.exit(str(error))
for folder in map(Path, arguments):
    for path in (linked.regenerate if linked.is_of_device(folder) else regenerate)(folder):
        print(path)
