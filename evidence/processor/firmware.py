"""A block as firmware for the emulated Cortex-M7: the flight code as it stands, the link's device, and the board's
start-up.

Needs arm-none-eabi-gcc and qemu-system-arm (Debian: gcc-arm-none-eabi qemu-system-arm).
Tests: tests/evidence/processor/test_stack.py.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from fmus import link
from fmus.block import Block
from fmus.kit.linked import lay_out
from fmus.native.toolchain import FREESTANDING
from orchestration import InputError

from ..tools import tool

MEASURE = Path(__file__).with_name("measure.c")
MACHINE = "mps2-an500"
PROCESSOR = ("-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard")
PROGRAMS = ("arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm")
FLAGS = (
    *("-std=c11", "-O2", "-ffreestanding", "-ffunction-sections", "-fdata-sections", "-fcallgraph-info=su"),
    # The same operations in the same order as in the FMU.
    *("-ffp-contract=off", "-fno-fast-math", "-fno-math-errno"),
    # memcpy is a loop in freestanding/memory.c, which must not become a call of memcpy.
    *("-fno-tree-loop-distribute-patterns", "-Wall", "-Wextra", "-Wconversion", "-Wno-unknown-pragmas", "-Werror"),
)


@dataclass(frozen=True)
class Firmware:
    """What a board runs, and what the compiler says of it; sizes in bytes."""

    elf: Path
    code: int
    """Of the block: instructions and constants."""
    ram: int
    """Of the block: ports, parameters, state and work space; none of it is on the stack."""
    whole_code: int
    """With the link, the board's start-up and elementary functions."""
    whole_ram: int
    """With the line's buffers, without the stack."""
    stack: int
    """The deepest chain of calls from the block's function on, by the compiler's call graph."""


def build(name: str, folder: Path) -> Firmware:
    """The firmware of a block of this project, made in `folder`. Raises InputError."""
    block = Block.named(name)
    folder.mkdir(parents=True, exist_ok=True)
    flight, line, headers = lay_out(block.interface, block.folder, folder)
    board = [link.FIRMWARE / f for f in ("main.c", "board_uart.c", "startup_cortex_m.c")]
    rest = [*line, *board, MEASURE, *FREESTANDING.glob("*.c")]
    (folder / "sizes.c").write_text(
        '#include "block.h"\nchar sizes[sizeof(Parameters) + sizeof(Inputs) + sizeof(Outputs) + sizeof(Memory)];\n'
    )
    folders = [f"-I{path}" for path in (*headers, FREESTANDING)]
    compiler = [tool("arm-none-eabi-gcc"), *PROCESSOR, *FLAGS, "-DUART_DIVIDER=16u", *folders]
    objects = {p: folder / f"{p.stem}.o" for p in (*flight, *rest, folder / "sizes.c")}
    for source, target in objects.items():
        _run([*compiler, "-c", str(source), "-o", str(target)])
    sizes = objects.pop(folder / "sizes.c")
    elf = folder / "firmware.elf"
    options = [
        *PROCESSOR,
        "-nostdlib",
        "-Wl,--gc-sections",
        "-Wl,--wrap=block_sample",
        f"-T{link.FIRMWARE / 'cortex_m.ld'}",
    ]
    _run([compiler[0], *options, *map(str, objects.values()), "-lgcc", "-o", str(elf)])
    code = sum(_size(objects[p])[0] for p in flight)
    graphs = [target.with_suffix(".ci").read_text() for target in objects.values()]
    return Firmware(elf, code, _size(sizes)[1], *_size(elf), deepest(graphs, "block_sample"))


def _run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(f"{Path(command[0]).name} failed: {' '.join(command)}\n{done.stderr}")
    return done.stdout


def _size(path: Path) -> tuple[int, int]:
    """Code with constants, and RAM."""
    text, data, bss = map(int, _run([tool("arm-none-eabi-size"), str(path)]).splitlines()[1].split()[:3])
    return text + data, data + bss


_NODE = re.compile(r'node: \{ title: "([^"]+)" label: "[^"]*?\\n(\d+) bytes \((\w+)[^"]*"')
_EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')


def deepest(graphs: Iterable[str], name: str) -> int:
    """Bytes of stack of the deepest chain of calls from this function, by the files of -fcallgraph-info=su.

    Raises InputError where a frame has no fixed size, a call goes through a pointer or a function calls itself.
    """
    frames: dict[str, int] = {}
    calls: dict[str, set[str]] = {}
    for graph in graphs:
        for function, size, kind in _NODE.findall(graph):
            if kind != "static":
                raise InputError(f"{function}: its frame on the stack has no fixed size")
            frames[function] = int(size)
        for caller, callee in _EDGE.findall(graph):
            calls.setdefault(caller, set()).add(callee)

    def depth(function: str, above: tuple[str, ...]) -> int:
        if function in above or function == "__indirect_call":
            raise InputError(f"{above[-1]} calls {function}: the depth of the stack has no bound")
        below = (depth(callee, (*above, function)) for callee in calls.get(function, ()))
        return frames.get(function, 0) + max(below, default=0)

    return depth(name, ())
