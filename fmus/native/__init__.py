"""The native flavour: a block's C and the FMI shell, compiled to libraries that need nothing else.

package(load("controller"), Path("controller"))                     # the FMU's bytes, for all platforms
package(load("controller"), Path("controller"), platforms="host")   # quicker: for this machine only
"""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Sequence
from pathlib import Path

from ..block import lenders, module_of
from ..contents.archive import archive, common
from ..contents.description import Capabilities, guid_from, model_description
from ..interface import Interface
from .carried import collected
from .generate import block_header, ports_header, table
from .toolchain import FLAGS, FREESTANDING, PLATFORMS, CompilerError, compile_library, compiler, host_platform

__all__ = ["CAPABILITIES", "PLATFORMS", "CompilerError", "package", "sources"]

CAPABILITIES = Capabilities(needsExecutionTool=False, canNotUseMemoryManagementFunctions=False)

HOST = (
    "Nothing: this is the native flavour, compiled from C for Linux, Windows and macOS (64 bits). It needs no "
    "other library, "
    "interpreter or tool, keeps no globals, and several instances live side by side."
)

_HERE = Path(__file__).parent
SHELL, COMMON = _HERE / "shell", _HERE / "common"
"""The C that all blocks' FMUs share, and the headers that the blocks themselves share."""


def package(
    interface: Interface, folder: Path, licence: Path | None = None, platforms: str | Sequence[str] = tuple(PLATFORMS)
) -> bytes:
    """The FMU of the block whose C stands in `folder`/native. The same sources give the same bytes.

    `platforms` are FMI's names, or "host" for this machine's. Raises CompilerError.
    """
    chosen = [host_platform()] if platforms == "host" else [platforms] if isinstance(platforms, str) else platforms
    generated = generated_sources(interface, folder)
    guid = guid_from(_digest(interface, folder, generated))
    tool = f"attitude-cosim, {compiler()}"
    with tempfile.TemporaryDirectory() as temporary:
        compiled, headers = lay_out(interface, folder, guid, Path(temporary), generated)
        made = compile_library(interface.name, compiled, headers, chosen)
        carried = collected([*headers, FREESTANDING])
    files = {
        "modelDescription.xml": model_description(
            interface, guid, CAPABILITIES, tool, sources=[name for name in carried if name.endswith(".c")]
        ),
        **common(interface, folder, licence, HOST),
        **{f"sources/{name}": data for name, data in carried.items()},
    }
    for name, library in made.items():
        files[f"binaries/{name}/{interface.name}{PLATFORMS[name].suffix}"] = library
    return archive(files)


def lay_out(
    interface: Interface, folder: Path, guid: str, generated_into: Path, generated: dict[str, str] | None = None
) -> tuple[list[Path], list[Path]]:
    """Writes the generated files; returns the C sources and the folders of headers, ready for a compiler."""
    files = {"block.h": block_header(interface, guid), "table.c": table(interface)}
    files |= generated_sources(interface, folder) if generated is None else generated
    written = _written(files, generated_into)
    native = folder / "native"
    compiled = [*sorted(SHELL.glob("*.c")), *sorted(native.rglob("*.c")), *written]
    return compiled, [SHELL, COMMON, generated_into, native]


def _written(files: dict[str, str], into: Path) -> list[Path]:
    """Writes generated files; returns the C sources among them."""
    for name, text in files.items():
        (into / name).write_text(text, "utf-8", newline="\n")
    return [into / name for name in sorted(files) if name.endswith(".c")]


def sources(folder: Path) -> list[Path]:
    """All files that decide a native FMU's bytes, but for the interface and the block's tables."""
    here = [path for path in _HERE.rglob("*") if path.suffix in (".c", ".h", ".py")]
    return sorted(here) + sorted(path for path in (folder / "native").rglob("*") if path.suffix in (".c", ".h", ".py"))


def generated_sources(interface: Interface, folder: Path) -> dict[str, str]:
    """Returns the C that a block includes and that is kept nowhere, by file name: its structures, and what
    `generated()` of `native/tables.py` returns, of the block and of those that lend to it."""
    made = ports_header(interface)
    if (folder / "native" / "tables.py").exists():
        with module_of(folder, "native.tables") as tables:
            made |= tables.generated()
    for name, owner in lenders(folder).items():
        if name not in made:
            with module_of(owner, "native.tables") as tables:
                made[name] = tables.generated()[name]
    return made


def _digest(interface: Interface, folder: Path, generated: dict[str, str]) -> str:
    digest = hashlib.sha256(f"{compiler()}\n{FLAGS}\n{PLATFORMS}\n{CAPABILITIES}\n{interface.source}".encode())
    paths = [path for path in sources(folder) if path.suffix in (".c", ".h")]
    for name, data in [
        *((path.name, path.read_bytes()) for path in paths),
        *((n, t.encode()) for n, t in sorted(generated.items())),
    ]:
        digest.update(f"\n{name} {len(data)}\n".encode() + data.replace(b"\r\n", b"\n"))
    return digest.hexdigest()
