"""Blocks as WebAssembly: several of them in one module, with other C that calls them.

In one module no two functions may have one name, so all that the shell shares between its files is called after its
block:
`fmi2DoStep` of plant is `plant_fmi2DoStep`. The sources, flags and elementary functions are those of the native FMUs,
so a module gives their bits.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from pathlib import Path

from .. import places
from ..block import Block
from . import SHELL, lay_out
from .toolchain import FLAGS, FREESTANDING, CompilerError, run, zig

_FLAGS = (*(flag for flag in FLAGS if flag != "-fPIC"), "-ffreestanding", f"-I{FREESTANDING}")
_DECLARED = re.compile(r"^(?:FMI2_EXPORT |extern )?(?:const )?\w+ \*?(\w+)(?=\(|\[)", re.MULTILINE)


def module(name: str, blocks: Sequence[Block], sources: Sequence[Path], includes: Sequence[Path]) -> bytes:
    """A module without imports. Its exports are what the sources export by `export_name`. Raises CompilerError."""
    compiler = zig()
    if compiler is None:
        raise CompilerError(f"{name} needs the compiler of the package ziglang: pip install ziglang")
    kept = places.work() / "wasm"  # the compiler knows again what it has compiled by its path
    with tempfile.TemporaryDirectory() as folder:
        arguments = [*_compiled([*sources, *sorted(FREESTANDING.glob("*.c"))], [SHELL, *includes])]
        for block in blocks:
            generated = kept / block.name
            generated.mkdir(parents=True, exist_ok=True)
            laid_out = lay_out(block.interface, block.folder, block.name, generated)
            renamed = generated / "names.h"
            renamed.write_text("".join(f"#define {old} {new}\n" for old, new in names(block.name).items()), "utf-8")
            arguments += _compiled(*laid_out, ["-include", str(renamed)])
        target = Path(folder, name)
        options = ["-target", "wasm32-freestanding", "-O", "ReleaseFast", "-fstrip", "-fno-entry", "--stack", "1048576"]
        run([str(compiler), "build-exe", *options, f"-femit-bin={target}", *arguments], target)
        return target.read_bytes()


def _compiled(sources: Sequence[Path], includes: Sequence[Path], more: Sequence[str] = ()) -> list[str]:
    return ["-cflags", *_FLAGS, *(f"-I{path}" for path in includes), *more, "--", *map(str, sources)]


def names(block: str) -> dict[str, str]:
    """Returns the names of the shell's functions and tables in the module, for a block."""
    headers = "".join((SHELL / header).read_text("utf-8") for header in ("instance.h", "fmi2.h"))
    declared = _DECLARED.findall(re.sub(r"/\*.*?\*/", "", headers, flags=re.DOTALL))
    return {name: f"{block}_{name}" if name.startswith("fmi2") else f"{block}_shell_{name}" for name in declared}
