"""A block in single precision: as an FMU for this machine, and as firmware for a Cortex-M4, whose FPU has no double
precision. Tests: tests/evidence/single/test_single.py."""

from __future__ import annotations

import zipfile
from pathlib import Path

from fmus import native
from fmus.block import Block
from fmus.build import ensure
from fmus.kit import linked
from fmus.native.toolchain import FLAGS, compile_library, host_platform, zig
from fmus.native.toolchain import run as compiled

from ..processor.firmware import Part
from .adapter import HERE, block_header, inner_header, wide
from .translate import write

INNER = HERE / "inner.c"
WARNINGS = ("-Wno-conversion", "-Wno-unknown-pragmas", "-Wdouble-promotion")
"""Of the translation: an int may become a float, and nothing becomes a double unseen."""


def lay_out(block: Block, folder: Path) -> tuple[list[Path], list[Path]]:
    """Writes the translation and its side of the adapter. Returns sources and folders of headers."""
    sources, headers = write(block, folder)
    (folder / "inner.h").write_text(inner_header(block.interface), "utf-8")
    return [*sources, INNER], [folder, *headers, HERE]


def fmu(name: str, folder: Path) -> Path:
    """The block's FMU with its library for this machine in single precision, and no other. Raises CompilerError."""
    block, host = Block.named(name), host_platform()
    inner, outer, target = folder / "inner", folder / "outer", folder / f"{name}_single.fmu"
    for path in (inner, outer):
        path.mkdir(parents=True, exist_ok=True)
    objects = []
    sources, headers = lay_out(block, inner)
    for number, source in enumerate(sources):
        objects.append(folder / f"{number}_{source.stem}.o")
        begin = [str(zig()), "cc", *FLAGS, *WARNINGS, "-ffreestanding"]
        compiled([*begin, *(f"-I{h}" for h in headers), "-c", str(source), "-o", str(objects[-1])], source)
    original = ensure(name)
    with zipfile.ZipFile(original) as archive:
        files = {entry: archive.read(entry) for entry in archive.namelist() if not entry.startswith("binaries/")}
    guid = files["modelDescription.xml"].decode().partition('guid="')[2].partition('"')[0]
    shell, shell_headers = native.lay_out(block.interface, block.folder, guid, outer)
    (outer / "block.h").write_text(block_header(block.interface, (outer / "block.h").read_text("utf-8")), "utf-8")
    (outer / "wide.c").write_text(wide(block.interface), "utf-8")
    own = [path for path in shell if path.parent == native.SHELL or path.name == "table.c"]
    made = [*own, outer / "wide.c", HERE / "outer.c", *objects]
    library = compile_library(name, made, [*shell_headers, HERE], [host])[host]
    with zipfile.ZipFile(target, "w") as archive:
        for entry, data in files.items():
            archive.writestr(entry, data)
        archive.writestr(f"binaries/{host}/{name}.so", library)
    return target


def parts_of(block: Block, folder: Path) -> list[Part]:
    """The block in single precision for `evidence.processor.firmware.build`, with its line, which has doubles."""
    sources, headers = lay_out(block, folder / "inner")
    _, line, outer_headers = linked.lay_out(block.interface, block.folder, folder)
    (folder / "block.h").write_text(block_header(block.interface, (folder / "block.h").read_text("utf-8")), "utf-8")
    (folder / "wide.c").write_text(wide(block.interface), "utf-8")
    around = (*line, folder / "wide.c", HERE / "outer.c")
    return [
        Part(tuple(s for s in sources if s != INNER), tuple(headers), WARNINGS, flight=True),
        Part((INNER,), tuple(headers), WARNINGS),
        Part(around, (*outer_headers, HERE)),
    ]
