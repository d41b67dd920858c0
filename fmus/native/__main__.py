"""Rewrites `<block>/native/ports.h` from the interfaces."""

from __future__ import annotations

from ..interface import BLOCKS, load
from .generate import ports_header, ports_path

for block in BLOCKS:
    ports_path(block).write_text(ports_header(load(block)), "utf-8", newline="\n")
