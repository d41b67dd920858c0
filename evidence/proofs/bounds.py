"""What flight software asks for beside the proofs: the depth of the stack, and no recursion, heap or call through a
pointer.

Shows FC-2.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from fmus.block import Block, natives
from fmus.native import COMMON, generated_sources
from fmus.native.toolchain import FREESTANDING
from orchestration import InputError

from ..processor.firmware import FLAGS, PROCESSOR, deepest
from ..tools import tool
from .subjects import CALLS

HEAP = ("malloc", "calloc", "realloc", "free", "alloca", "aligned_alloc", "posix_memalign", "strdup")


@dataclass(frozen=True)
class Bounds:
    """Stack of a block on a Cortex-M7, with the elementary functions; bytes."""

    block: str
    stack: dict[str, int]
    """The deepest chain of calls from each of the block's functions."""


def bounds_of(name: str) -> Bounds:
    """Raises InputError where the compiler is missing or fails, or a function calls itself, a pointer or the heap."""
    block = Block.named(name)
    own = natives(block.folder)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for header, text in generated_sources(block.interface, block.folder).items():
            (folder / header).write_text(text, "utf-8")
        include = [f"-I{path}" for path in (*own, COMMON, FREESTANDING, folder)]
        sources = [*(path for native in own for path in sorted(native.rglob("*.c"))), *sorted(FREESTANDING.glob("*.c"))]
        as_written = [_graph(source, include, folder, "-O0") for source in sources]
        graphs = [_graph(source, include, folder) for source in sources]
    refuse_heap(name, [*as_written, *graphs])
    for call in CALLS:  # the optimiser follows a pointer that is constant, and turns a last call into a loop
        deepest(as_written, f"{block.interface.code}_{call}")
    return Bounds(name, {call: deepest(graphs, f"{block.interface.code}_{call}") for call in CALLS})


def refuse_heap(name: str, graphs: Iterable[str]) -> None:
    """Raises InputError where the call graphs of -fcallgraph-info name a function of the heap."""
    calls = set(re.findall(r'targetname: "([^"]+)"', "\n".join(graphs)))
    if used := calls & set(HEAP):
        raise InputError(f"{name} calls {', '.join(sorted(used))}; expected no heap")


def _graph(source: Path, include: list[str], folder: Path, *options: str) -> str:
    target = folder / f"{source.stem}.o"
    words = [*PROCESSOR, *FLAGS, *options, *include]
    command = [tool("arm-none-eabi-gcc"), *words, "-c", str(source), "-o", str(target)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(f"arm-none-eabi-gcc failed: {' '.join(command)}\n{done.stderr}")
    return target.with_suffix(".ci").read_text("utf-8")
