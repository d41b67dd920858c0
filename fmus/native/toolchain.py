"""Compiles a block's C for FMI's platforms: with the compiler of the package ziglang, from any host for all of them.

The libraries need no other library: no C runtime, no libm. So they load beside any C runtime, on any glibc and on
musl, and their bytes depend on the sources and zig's version only. Where ziglang cannot be had, the system's C
compiler builds for the host. Longer than 250 lines: the table of platforms stands beside what compiles for them.
Tests: tests/native/test_build.py.
"""

from __future__ import annotations

import logging
import os
import platform
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from threading import BoundedSemaphore

from ..versions import version_of

log = logging.getLogger(__name__)

FLAGS = (
    *(
        "-std=c11",
        "-O2",
        "-g0",
        "-fPIC",
        "-fvisibility=hidden",
        "-fno-stack-protector",
        "-fno-asynchronous-unwind-tables",
        "-fomit-frame-pointer",
    ),
    # The same operations in the same order everywhere: no fused multiply-add, no reordering, no errno from sqrt.
    *("-ffp-contract=off", "-fno-fast-math", "-fno-math-errno"),
    *("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Wstrict-prototypes", "-Werror"),
)
_NOT_OF_CPP = {"-std=c11", "-Wpedantic", "-Wstrict-prototypes"}
CPP_FLAGS = (
    *("-x", "c++", "-std=c++20", "-nostdinc++", "-fno-exceptions", "-fno-rtti"),
    *(flag for flag in FLAGS if flag not in _NOT_OF_CPP),
    # What C allows and C++ does not warns; in the C it is checked by the C compiler.
    *("-Wno-missing-field-initializers", "-Wno-missing-designated-field-initializers"),
)
"""Of a C++ file: the block's C with other numbers, without library and run-time."""
FREESTANDING = Path(__file__).parent / "freestanding"
"""Stands in for the C library: headers, sin to expm1, memcpy to strcmp."""
COMMON = Path(__file__).parent / "common"
"""The headers that the blocks share."""


class CompilerError(RuntimeError):
    """There is no compiler, or it refused the sources; the message has its words."""


@dataclass(frozen=True)
class Platform:
    """One of FMI's platforms: the suffix of its libraries and zig's targets, which share one file."""

    suffix: str
    targets: tuple[str, ...]
    link: tuple[str, ...] = ()
    system: tuple[str, ...] = ()
    """Options for what is linked with the operating system's own libraries."""
    memory: tuple[str, ...] = ()
    """Options for what asks the operating system for memory and for nothing else."""
    blocks: tuple[str, ...] = ()
    """Options for the blocks' code, which make it quicker and leave the bits alone: all sources as one,
    where zig's linker can."""


_ELF = "-Wl,--build-id=none", "-Wl,-z,noexecstack"
PLATFORMS: Mapping[str, Platform] = {
    "linux64": Platform(".so", ("x86_64-linux-gnu.2.17",), _ELF, blocks=("-flto",)),
    # FMI 2.0 has no name for it; this is that of FMI 3.0.
    "aarch64-linux": Platform(".so", ("aarch64-linux-gnu.2.17",), _ELF, blocks=("-flto",)),
    "win64": Platform(
        ".dll", ("x86_64-windows-gnu",), system=("-nostdlib", "-lkernel32", "-lws2_32"), memory=("-lkernel32",)
    ),
    "darwin64": Platform(
        ".dylib",
        ("x86_64-macos.11.0", "aarch64-macos.11.0"),
        ("-Wl,-install_name,@rpath/{library}",),
        memory=("-lSystem",),
    ),
}


def host_platform() -> str:
    """FMI's name of the platform that this interpreter runs on."""
    linux = "aarch64-linux" if platform.machine().lower() in ("aarch64", "arm64") else "linux64"
    return {"Windows": "win64", "Darwin": "darwin64"}.get(platform.system(), linux)


def compiler() -> str:
    """Returns which compiler is used, with its version: it has a say in a library's bytes."""
    version = version_of("ziglang")
    return f"ziglang {version}" if version else f"system compiler {_system_compiler()}"


def compile_library(
    name: str, sources: Sequence[Path], includes: Sequence[Path], platforms: Iterable[str], hosted: bool = False
) -> dict[str, bytes]:
    """The shared library of these C sources for each of the platforms. Raises CompilerError.

    `hosted`: it uses the operating system, and the C library where that is a part of it.
    """
    made = compile_slices(name, sources, includes, platforms, hosted)
    return {platform: universal(list(slices.values())) for platform, slices in made.items()}


def suffix_of(place: str) -> str:
    """Returns the suffix of the libraries in a folder of binaries, by FMI 2.0's name (win64) or FMI 3.0's
    (x86_64-windows).
    """
    return ".dll" if "win" in place.replace("darwin", "") else ".dylib" if "darwin" in place else ".so"


def compile_slices(
    name: str,
    sources: Sequence[Path],
    includes: Sequence[Path],
    platforms: Iterable[str],
    hosted: bool = False,
    asks_memory: bool = False,
) -> dict[str, dict[str, bytes]]:
    """The shared libraries of each of the platforms, by FMI 3.0's names of system and processor (x86_64-linux).

    `hosted`: as in `compile_library`; `asks_memory`: it asks the operating system for memory. Raises CompilerError.
    """
    wanted = list(platforms)
    if unknown := [p for p in wanted if p not in PLATFORMS]:
        raise CompilerError(f"platform {unknown[0]!r}: expected {', '.join(PLATFORMS)}")
    if zig() is None:
        processor = "aarch64" if platform.machine().lower() in ("aarch64", "arm64") else "x86_64"
        here = f"{processor}-{platform.system().lower()}"
        return {host_platform(): {here: _with_system_compiler(name, sources, includes, wanted)}}
    jobs = [(p, target) for p in wanted for target in PLATFORMS[p].targets]

    def one(job: tuple[str, str]) -> bytes:
        if hosted:
            return _hosted(name, sources, includes, *job)
        return _freestanding(name, sources, includes, *job, PLATFORMS[job[0]].memory if asks_memory else ())

    with ThreadPoolExecutor(max_workers=os.cpu_count() or 2) as pool:
        slices = dict(zip(jobs, pool.map(one, jobs), strict=True))
    return {p: {_tuple(target): slices[p, target] for target in PLATFORMS[p].targets} for p in wanted}


def _tuple(target: str) -> str:
    """FMI 3.0's name of one of zig's targets."""
    processor, system = target.split("-")[:2]
    return f"{processor}-{'darwin' if system.startswith('macos') else system}"


def find_spec(name: str) -> ModuleSpec | None:
    """Returns where a package stands. A copy of the path is searched: another thread that imports a block's tables
    changes `sys.path`, and a search of that itself can then miss a folder."""
    return PathFinder.find_spec(name, sys.path.copy())


def zig() -> Path | None:
    """The compiler of the package ziglang; None where that is not installed."""
    spec = find_spec("ziglang")
    if spec is None or spec.origin is None:
        return None
    return Path(spec.origin).with_name("zig.exe" if os.name == "nt" else "zig")


def shared_library(name: str, platform_name: str, target: str, arguments: Sequence[str | Path]) -> bytes:
    """The shared library of this file name that zig makes of sources and further options. Raises CompilerError."""
    compiler = zig()
    if compiler is None:
        raise CompilerError(
            f"{name} for {platform_name} needs the compiler of the package ziglang: pip install ziglang"
        )
    link = [argument.format(library=name) for argument in PLATFORMS[platform_name].link]
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, name)
        begin: list[str | Path] = [compiler, "cc", "-target", target]
        inputs = _compiled_cpp(begin, arguments, Path(folder))
        command = [*begin, *FLAGS, "-shared", "-s", *link, *inputs, "-o", library]
        run([str(argument) for argument in command], library)
        return library.read_bytes()


def _compiled_cpp(begin: Sequence[str | Path], arguments: Sequence[str | Path], folder: Path) -> list[str | Path]:
    """The arguments of a compiler of C with an object in the place of each C++ file. Raises CompilerError."""
    made = []
    for argument in arguments:
        path = argument
        if isinstance(path, Path) and path.suffix == ".cpp":
            path = folder / f"{path.stem}.o"
            includes = [each for each in arguments if str(each).startswith(("-I", "-ffreestanding"))]
            run([str(each) for each in (*begin, "-c", *CPP_FLAGS, *includes, argument, "-o", path)], path)
        made.append(path)
    return made


def run_program(sources: Sequence[Path], includes: Sequence[Path]) -> str:
    """Returns what a program of these sources prints on this machine, whatever its status. Raises CompilerError."""
    compiler = zig()
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder, "program.exe")
        command = [*([str(compiler), "cc"] if compiler else [_system_compiler()]), *FLAGS]
        run([*command, *(f"-I{path}" for path in includes), *map(str, sources), "-o", str(program)], program)
        return subprocess.run([program], capture_output=True, text=True, check=False).stdout


def _freestanding(
    name: str,
    sources: Sequence[Path],
    includes: Sequence[Path],
    platform: str,
    target: str,
    more: Sequence[str] = (),
) -> bytes:
    files = [*sources, *sorted(FREESTANDING.glob("*.c"))]
    arguments: list[str | Path] = [
        *PLATFORMS[platform].blocks,
        "-ffreestanding",
        "-nostdlib",
        *(f"-I{path}" for path in (FREESTANDING, *includes)),
        *files,
        *more,
    ]
    return shared_library(name + PLATFORMS[platform].suffix, platform, target, arguments)


def _hosted(name: str, sources: Sequence[Path], includes: Sequence[Path], platform: str, target: str) -> bytes:
    files, folders, more = list(sources), list(includes), list(PLATFORMS[platform].system)
    if (
        windows := zig() if "-nostdlib" in more else None
    ):  # Windows: its headers, but no C library, which is not a part of it
        files += sorted(FREESTANDING.glob("*.c"))
        folders.append(FREESTANDING)
        more += ["-isystem", str(windows.parent / "lib" / "libc" / "include" / "any-windows-any")]
    arguments: list[str | Path] = [*(f"-I{path}" for path in folders), *files, *more]
    return shared_library(name + PLATFORMS[platform].suffix, platform, target, arguments)


def _system_compiler() -> str:
    for candidate in (os.environ.get("CC"), "cc", "gcc", "clang"):
        if candidate and shutil.which(candidate):
            return candidate
    raise CompilerError("a native FMU needs a C compiler: pip install ziglang, or install a system compiler (cc)")


def _with_system_compiler(name: str, sources: Sequence[Path], includes: Sequence[Path], wanted: list[str]) -> bytes:
    host = host_platform()
    log.warning(
        "ziglang is not installed: %s builds %s for %s only (pip install ziglang for all platforms)",
        _system_compiler(),
        name,
        host,
    )
    if host not in wanted:
        raise CompilerError(f"without ziglang only {host} can be built, but {', '.join(wanted)} was asked for")
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, name + PLATFORMS[host].suffix)
        paths = [f"-I{path}" for path in includes]
        inputs = _compiled_cpp([_system_compiler()], [*paths, *sources], Path(folder))
        run([_system_compiler(), *FLAGS, "-shared", *map(str, inputs), "-o", str(library), "-lm"], library)
        return library.read_bytes()


_CORES = BoundedSemaphore(os.cpu_count() or 2)


def run(command: list[str], about: Path) -> None:
    """Runs a compiler, one a core at a time in this process. Raises CompilerError with its words."""
    with _CORES:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise CompilerError(f"{about.name}: {Path(command[0]).name} failed:\n{' '.join(command)}\n{done.stderr}")


def universal(slices: list[bytes]) -> bytes:
    """One Mach-O file for several architectures; a single slice is returned as it is."""
    if len(slices) == 1:
        return slices[0]
    alignment = 14  # 16 KB, the page of arm64
    header = struct.pack(">II", 0xCAFEBABE, len(slices))
    body = b""
    start = 1 << alignment
    for part in slices:
        cpu_type, cpu_subtype = struct.unpack_from("<II", part, 4)
        offset = start + len(body)
        header += struct.pack(">IIIII", cpu_type, cpu_subtype, offset, len(part), alignment)
        body += part + b"\0" * (-len(part) % (1 << alignment))
    return header.ljust(start, b"\0") + body
