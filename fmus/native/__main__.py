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
Path(folder).mkdir(parents=True, exist_ok=True)
for block in blocks:
    for name, text in generated_sources(block.interface, block.folder).items():
        Path(folder, name).write_text(text, "utf-8", newline="\n")
