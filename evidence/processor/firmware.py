"""A block as firmware for the emulated Cortex-M7: the flight code as it stands, the link's device, and the board's
start-up.

Needs arm-none-eabi-gcc and qemu-system-arm (Debian: gcc-arm-none-eabi qemu-system-arm).
Tests: tests/evidence/processor/test_stack.py.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from fmus import link
from fmus.block import Block
from fmus.kit.linked import lay_out
from fmus.native.toolchain import FREESTANDING
from orchestration import InputError

from ..tools import tool

MEASURE = Path(__file__).with_name("measure.c")
PROGRAMS = ("arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm")
FLAGS = (
    *("-std=c11", "-O2", "-ffreestanding", "-ffunction-sections", "-fdata-sections", "-fcallgraph-info=su"),
    # The same operations in the same order as in the FMU.
    *("-ffp-contract=off", "-fno-fast-math", "-fno-math-errno"),
    # memcpy is a loop in freestanding/memory.c, which must not become a call of memcpy.
    *("-fno-tree-loop-distribute-patterns", "-Wall", "-Wextra", "-Wconversion", "-Wno-unknown-pragmas", "-Werror"),
)


@dataclass(frozen=True)
class Board:
    """QEMU's name of a board, and the compiler's options for its processor."""

    machine: str
    options: tuple[str, ...]


PROCESSOR = ("-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard")
CORTEX_M7 = Board("mps2-an500", PROCESSOR)
CORTEX_M4 = Board("mps2-an386", ("-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"))
"""Its FPU has single precision alone."""


@dataclass(frozen=True)
class Part:
    """C that is compiled alike: `flight` is the block's, which sizes are of."""

    sources: tuple[Path, ...]
    headers: tuple[Path, ...]
    options: tuple[str, ...] = ()
    flight: bool = False


@dataclass(frozen=True)
class Firmware:
    """Program of a board, and what the compiler says of it; sizes in bytes."""

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
    doubles: tuple[str, ...] = ()
    """Functions for double precision that the block calls; none where the processor has it."""


def parts_of(block: Block, folder: Path) -> list[Part]:
    """The block as it stands, and its line; what is generated goes into `folder`."""
    flight, line, headers = lay_out(block.interface, block.folder, folder)
    return [Part(tuple(flight), tuple(headers), flight=True), Part(tuple(line), tuple(headers))]


def build(
    name: str,
    folder: Path,
    board: Board = CORTEX_M7,
    made_of: Callable[[Block, Path], list[Part]] = parts_of,
) -> Firmware:
    """The firmware of a block of this project, made in `folder`. The headers of the last part are the board's, too.

    Raises InputError.
    """
    folder.mkdir(parents=True, exist_ok=True)
    parts = made_of(Block.named(name), folder)
    names = ("main.c", "board_uart.c", "startup_cortex_m.c")
    (folder / "sizes.c").write_text(
        '#include "block.h"\nchar sizes[sizeof(Parameters) + sizeof(Inputs) + sizeof(Outputs) + sizeof(Memory)];\n'
    )
    rest = (*(link.FIRMWARE / f for f in names), MEASURE, *sorted(FREESTANDING.glob("*.c")), folder / "sizes.c")
    parts.append(Part(rest, parts[-1].headers))
    compiler = [tool("arm-none-eabi-gcc"), *board.options, *FLAGS, "-DUART_DIVIDER=16u"]
    objects: dict[Path, Path] = {}
    for number, part in enumerate(parts):
        # The elementary functions' headers last: a part may bring its own.
        folders = [f"-I{path}" for path in (*part.headers, FREESTANDING)]
        for source in part.sources:
            objects[source] = folder / f"{number}_{source.stem}.o"
            _run([*compiler, *part.options, *folders, "-c", str(source), "-o", str(objects[source])])
    sizes = objects.pop(folder / "sizes.c")
    elf = folder / "firmware.elf"
    options = [
        *board.options,
        "-nostdlib",
        "-Wl,--gc-sections",
        "-Wl,--wrap=block_sample",
        f"-T{link.FIRMWARE / 'cortex_m.ld'}",
    ]
    _run([compiler[0], *options, *map(str, objects.values()), "-lgcc", "-o", str(elf)])
    flight = [objects[source] for part in parts if part.flight for source in part.sources]
    code = sum(_size(path)[0] for path in flight)
    graphs = [target.with_suffix(".ci").read_text() for target in objects.values()]
    doubles = sorted({name for path in flight for name in _DOUBLE.findall(_run([tool("arm-none-eabi-nm"), str(path)]))})
    return Firmware(elf, code, _size(sizes)[1], *_size(elf), deepest(graphs, "block_sample"), tuple(doubles))


_DOUBLE = re.compile(r"U (__aeabi_(?:d\w+|\w+2d|cd\w+))")
"""The compiler's functions for double precision, where the processor has none."""


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
