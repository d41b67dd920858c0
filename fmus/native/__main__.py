"""python -m fmus.native [BLOCK]...: rewrites the blocks' `native/ports.h` from the interfaces, by default all."""

from __future__ import annotations

import sys

from ..interface import BLOCKS, load
from .generate import ports_header, ports_path

for block in sys.argv[1:] or BLOCKS:
    path = ports_path(block)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(ports_header(load(block)), "utf-8", newline="\n")
