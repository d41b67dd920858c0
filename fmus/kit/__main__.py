"""python -m fmus.kit FOLDER: writes what is generated in FOLDER anew from FOLDER/interface.toml.
Tests: tests/fmus/kit/test_kit.py."""

from __future__ import annotations

import sys
from pathlib import Path

from . import linked, regenerate

for folder in map(Path, sys.argv[1:]):
    for path in (linked.regenerate if linked.is_of_device(folder) else regenerate)(folder):
        print(path)
