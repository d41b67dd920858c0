"""The native flavour: a block's C and the FMI shell, compiled to libraries that need nothing else.

package(load("controller"), Path("controller"))                     # the FMU's bytes, for all platforms
package(load("controller"), Path("controller"), platforms="host")   # quicker: for this machine only
"""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Sequence
from pathlib import Path

from ..block import inside, lenders, module_of, natives
from ..contents.archive import archive, common
from ..contents.description import Capabilities, guid_from, model_description
from ..contents.description3 import build_description, model_description_3
from ..contents.origin import origin
from ..interface import Interface
from .carried import collected
from .derivatives import slopes
from .generate import arrays, block_header, table
from .guard import headers
from .toolchain import (
    COMMON,
    FLAGS,
    FREESTANDING,
    PLATFORMS,
    CompilerError,
    compile_slices,
    compiler,
    host_platform,
    suffix_of,
    universal,
)

__all__ = ["CAPABILITIES", "PLATFORMS", "CompilerError", "package", "sources"]

CAPABILITIES = Capabilities(needsExecutionTool=False, canNotUseMemoryManagementFunctions=False)

HOST = (
    "Nothing: this is the native flavour, compiled from C for Linux, Windows and macOS (64 bits). It needs no "
    "other library, "
    "interpreter or tool, keeps no globals, and several instances live side by side."
)

_HERE = Path(__file__).parent
SHELL, SHELL_3 = _HERE / "shell", _HERE / "shell3"
"""The C that all blocks' FMUs share, and what comes to it with FMI 3.0."""


def package(
    interface: Interface,
    folder: Path,
    licence: Path | None = None,
    platforms: str | Sequence[str] = tuple(PLATFORMS),
    version: int = 2,
) -> bytes:
    """The FMU of the block whose C stands in `folder`/native. The same sources give the same bytes.

    `platforms` are FMI 2.0's names, or "host" for this machine's; `version` is FMI's, 2 or 3. Raises CompilerError.
    """
    chosen = [host_platform()] if platforms == "host" else [platforms] if isinstance(platforms, str) else platforms
    generated = generated_sources(interface, folder)
    guid = guid_from(_digest(interface, folder, generated, version))
    tool = f"attitude-cosim, {compiler()}"
    with tempfile.TemporaryDirectory() as temporary:
        compiled, headers = lay_out(interface, folder, guid, Path(temporary), generated, version)
        made = compile_slices(interface.name, compiled, headers, chosen, asks_memory=version == 3)
        carried = collected([*headers, FREESTANDING])
    files = {f"sources/{name}": data for name, data in carried.items()}
    files |= common(interface, folder, licence, HOST, version)
    c_files = [name for name in carried if name.endswith((".c", ".cpp"))]
    if version == 2:
        files["modelDescription.xml"] = model_description(
            interface, guid, CAPABILITIES, tool, sources=c_files, origin=origin()
        )
        places = {platform: universal(list(slices.values())) for platform, slices in made.items()}
    else:
        files["modelDescription.xml"] = model_description_3(interface, guid, CAPABILITIES, tool, origin())
        files["sources/buildDescription.xml"] = build_description(interface, c_files)
        places = {name: data for slices in made.values() for name, data in slices.items()}
    for place, library in places.items():
        files[f"binaries/{place}/{interface.name}{suffix_of(place)}"] = library
    return archive(files)


def lay_out(
    interface: Interface,
    folder: Path,
    guid: str,
    generated_into: Path,
    generated: dict[str, str] | None = None,
    version: int = 2,
) -> tuple[list[Path], list[Path]]:
    """Writes the generated files; returns the C sources and the folders of headers, ready for a compiler."""
    files = {"block.h": block_header(interface, guid, version), "table.c": table(interface)}
    shells = [SHELL]
    if version == 3:
        files["arrays.c"] = arrays(interface)
        files |= {"slopes.cpp": slopes(interface, folder / "native")} if interface.derivatives else {}
        shells.append(SHELL_3)
    files |= generated_sources(interface, folder) if generated is None else generated
    written = _written(files, generated_into)
    own = natives(folder)
    of_shells = [path for shell in shells for path in sorted(shell.glob("*.c"))]
    of_block = [path for native in own for path in sorted(native.rglob("*.c"))]
    return [*of_shells, *of_block, *written], [*shells, COMMON, generated_into, *own]


def _written(files: dict[str, str], into: Path) -> list[Path]:
    """Writes generated files; returns the C sources among them."""
    for name, text in files.items():
        (into / name).write_text(text, "utf-8", newline="\n")
    return [into / name for name in sorted(files) if name.endswith((".c", ".cpp"))]


def sources(folder: Path) -> list[Path]:
    """All files that decide a native FMU's bytes, but for the interface and the block's tables."""
    here = [path for path in _HERE.rglob("*") if path.suffix in (".c", ".h", ".py")]
    of_block = (path for native in natives(folder) for path in sorted(native.rglob("*")))
    return sorted(here) + [path for path in of_block if path.suffix in (".c", ".h", ".py")]


def generated_sources(interface: Interface, folder: Path) -> dict[str, str]:
    """Returns the C that a block includes and that is kept nowhere, by file name: its structures, and what
    `generated()` of `native/tables.py` returns, of the block and of those that lend to it."""
    made = headers(interface)
    if (within := inside(folder)) is not None:
        made |= headers(within.interface)
    if (folder / "native" / "tables.py").exists():
        with module_of(folder, "native.tables") as tables:
            made |= tables.generated()
    for name, owner in lenders(folder).items():
        if name not in made:
            with module_of(owner, "native.tables") as tables:
                made[name] = tables.generated()[name]
    return made


def _digest(interface: Interface, folder: Path, generated: dict[str, str], version: int) -> str:
    made_by = f"{compiler()}\n{FLAGS}\n{PLATFORMS}\n{CAPABILITIES}\nFMI {version}\n{interface.source}"
    digest = hashlib.sha256(made_by.encode())
    paths = [path for path in sources(folder) if path.suffix in (".c", ".h")]
    for name, data in [
        *((path.name, path.read_bytes()) for path in paths),
        *((n, t.encode()) for n, t in sorted(generated.items())),
    ]:
        digest.update(f"\n{name} {len(data)}\n".encode() + data.replace(b"\r\n", b"\n"))
    return digest.hexdigest()
