"""python -m fmus.native FOLDER [BLOCK]...: writes the headers that the blocks' C includes and that builds generate.
Tests: tests/native/test_embedding.py."""

from __future__ import annotations

import sys
from pathlib import Path

from ..block import Block, BuildError
from ..interface import BLOCKS
from . import generated_sources

folder, *names = sys.argv[1:] or ["--help"]
if folder.startswith("-"):
    sys.exit("python -m fmus.native FOLDER [BLOCK]...")
try:
    blocks = [Block.named(name) for name in names or BLOCKS]
except BuildError as error:
    sys.exit(f"python -m fmus.native: {error}")
for block in blocks:
    # The code of a block for a set of parts includes headers of the same names.
    into = Path(folder) if block.name == block.interface.code else Path(folder, block.name)
    into.mkdir(parents=True, exist_ok=True)
    for name, text in generated_sources(block.interface, block.folder).items():
        (into / name).write_text(text, "utf-8", newline="\n")
