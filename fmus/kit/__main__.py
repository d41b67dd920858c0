"""python -m fmus.kit FOLDER: writes FOLDER/generated/ anew from FOLDER/interface.toml."""

from __future__ import annotations

import sys
from pathlib import Path

from . import regenerate

for folder in sys.argv[1:]:
    for path in regenerate(Path(folder)):
        print(path)
