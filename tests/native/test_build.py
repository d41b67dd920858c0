"""Native FMUs as files: the same bytes every time, for every platform, needing no library, valid."""

from __future__ import annotations

import io
import struct
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from fmus import native
from fmus.build import ensure
from fmus.interface import BLOCKS, load
from fmus.native import toolchain
from tests.blocks import folder, some
from tests.machine import lacking

from .driver import ROOT

WHOLE = ("plant", "allocator_bounded")
"""Blocks that are built again for all platforms, one with tables and one without; the others for this machine alone."""


@pytest.fixture(scope="module")
def packaged() -> dict[str, bytes]:
    """As they were built before, for all tests and mostly by another process."""
    return {block: ensure(block).read_bytes() for block in BLOCKS}


def _library(data: bytes, path: str) -> bytes:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return archive.read(path)


@pytest.mark.thorough
@pytest.mark.parametrize("block", BLOCKS)
def test_the_same_sources_give_the_same_bytes(
    block: str, packaged: dict[str, bytes], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("ZIG_LOCAL_CACHE_DIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    platforms = list(toolchain.PLATFORMS) if block in WHOLE else "host"
    again = native.package(load(block), folder(block), ROOT / "LICENSE", platforms)
    with zipfile.ZipFile(io.BytesIO(again)) as new, zipfile.ZipFile(io.BytesIO(packaged[block])) as kept:
        assert new.namelist() == [n for n in kept.namelist() if n in new.namelist()]
        for name in new.namelist():
            assert new.read(name) == kept.read(name), name
        if block in WHOLE:
            end = len(kept.comment)  # the fingerprint, which `build` adds, and its length
            assert again[:-2] == packaged[block][: -2 - end]


@pytest.mark.parametrize("block", BLOCKS)
def test_an_fmu_is_valid_and_small_and_has_all_platforms(
    block: str, packaged: dict[str, bytes], tmp_path: Path
) -> None:
    path = tmp_path / f"{block}.fmu"
    path.write_bytes(packaged[block])
    assert validate_fmu(str(path)) == []
    assert len(packaged[block]) < 2**20  # a third of it sources
    with zipfile.ZipFile(path) as archive:
        names = [name for name in archive.namelist() if name.startswith("binaries/")]
    assert sorted(names) == [
        f"binaries/{p}/{block}{toolchain.PLATFORMS[p].suffix}"
        for p in ("aarch64-linux", "darwin64", "linux64", "win64")
    ]
    about = read_model_description(str(path)).coSimulation
    assert about.canGetAndSetFMUstate
    assert about.canSerializeFMUstate
    assert not about.needsExecutionTool
    assert not about.canBeInstantiatedOnlyOncePerProcess


@pytest.mark.parametrize("block", BLOCKS)
def test_the_linux_library_exports_fmi_only_and_needs_nothing(block: str, packaged: dict[str, bytes]) -> None:
    exported, undefined, needed = _elf(_library(packaged[block], f"binaries/linux64/{block}.so"))
    assert not undefined
    assert not needed
    assert len(exported) == 34
    assert all(name.startswith("fmi2") for name in exported)


@pytest.mark.parametrize("block", BLOCKS)
def test_the_windows_library_exports_fmi_only_and_needs_nothing(block: str, packaged: dict[str, bytes]) -> None:
    data = _library(packaged[block], f"binaries/win64/{block}.dll")
    (pe,) = struct.unpack_from("<I", data, 0x3C)
    machine, sections, _ = struct.unpack_from("<HHI", data, pe + 4)
    assert machine == 0x8664
    optional = pe + 24
    exports, _, imports, _ = struct.unpack_from("<IIII", data, optional + 112)
    assert imports == 0
    (optional_size,) = struct.unpack_from("<H", data, pe + 20)
    names = _pe_exports(data, optional + optional_size, sections, exports)
    assert len(names) == 34
    assert all(name.startswith("fmi2") for name in names)


@pytest.mark.parametrize("block", BLOCKS)
def test_the_mac_library_is_universal_and_its_arm_part_is_signed(block: str, packaged: dict[str, bytes]) -> None:
    data = _library(packaged[block], f"binaries/darwin64/{block}.dylib")
    magic, count = struct.unpack_from(">II", data)
    assert (magic, count) == (0xCAFEBABE, 2)
    found = {}
    for i in range(count):
        cpu, _, offset, size, alignment = struct.unpack_from(">IIIII", data, 8 + 20 * i)
        assert offset % (1 << alignment) == 0
        part = data[offset : offset + size]
        assert struct.unpack_from("<II", part)[0] == 0xFEEDFACF
        found[cpu] = _mach_commands(part)
    assert set(found) == {0x01000007, 0x0100000C}  # x86-64 and arm64
    for commands, libraries in found.values():
        assert libraries == ["/usr/lib/libSystem.B.dylib"]  # every process on macOS has it; nothing is taken from it
        assert 0x32 in commands  # the least version of macOS
    assert 0x1D in found[0x0100000C][0]  # LC_CODE_SIGNATURE: arm64 loads no library without one


def test_a_block_runs_on_every_x86_64(tmp_path: Path) -> None:
    """The compiler may use no instruction beyond SSE2, which each of these processors has."""
    beyond = " || ".join(f"defined __{name}__" for name in ("SSE3", "SSSE3", "SSE4_1", "AVX", "AVX2", "FMA", "BMI"))
    source = tmp_path / "block.c"
    source.write_text(
        f"#if {beyond} || !defined __SSE2__\n#error\n#endif\nint block(void);\nint block(void) {{ return 0; }}\n"
    )
    assert set(toolchain.compile_library("block", [source], [], ["linux64", "win64"])) == {"linux64", "win64"}


def test_an_unknown_platform_is_refused() -> None:
    with pytest.raises(
        native.CompilerError, match="platform 'linux32': expected linux64, aarch64-linux, win64, darwin64"
    ):
        native.package(load("allocator"), ROOT / "allocator", platforms=["linux32"])


def test_sources_that_do_not_compile_are_refused_with_the_compilers_words(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.c"
    wrong.write_text("int f(void) { int x; return 1; }\n")
    with pytest.raises(native.CompilerError, match="unused variable 'x'"):
        toolchain.compile_library("wrong", [wrong], [], ["linux64"])


def test_the_compiler_is_found_while_another_thread_changes_the_path_of_imports(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As `importing_from` does beside it: a folder that it put in front goes again while the path is searched."""

    class Shifting(list[str]):
        at = 0

        def __iter__(self) -> Iterator[str]:
            for number, entry in enumerate(super().__iter__()):
                if number == self.at:
                    self.pop(0)
                yield entry

    found = toolchain.zig()
    assert found is not None
    before = sys.path.copy()
    for at in range(len(before) + 1):
        shifting = Shifting(["/nowhere", *before])
        shifting.at = at
        monkeypatch.setattr(sys, "path", shifting)
        assert toolchain.zig() == found


@pytest.mark.parametrize("block", some(BLOCKS, "allocator"))
def test_without_ziglang_the_systems_compiler_builds_for_this_machine(
    block: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    host = toolchain.host_platform()
    try:
        toolchain._system_compiler()
    except native.CompilerError:
        lacking("there is no system compiler")
    monkeypatch.setattr(toolchain, "find_spec", lambda name: None)
    built = native.package(load(block), folder(block))
    with zipfile.ZipFile(io.BytesIO(built)) as archive:
        assert [n for n in archive.namelist() if n.startswith("binaries/")] == [
            f"binaries/{host}/{block}{toolchain.PLATFORMS[host].suffix}"
        ]
    assert "ziglang is not installed" in caplog.text


def _elf(data: bytes) -> tuple[list[str], list[str], list[str]]:
    """Exported and undefined names of an ELF library's dynamic symbols, and the libraries that it needs."""
    (table,) = struct.unpack_from("<Q", data, 40)
    size, count = struct.unpack_from("<HH", data, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, table + i * size) for i in range(count)]
    symbols = next(s for s in sections if s[1] == 11)
    strings = sections[symbols[6]]
    dynamic = next(s for s in sections if s[1] == 6)

    def text(at: int) -> str:
        start = strings[4] + at
        return data[start : data.index(b"\0", start)].decode()

    exported, undefined = [], []
    for at in range(symbols[4] + 24, symbols[4] + symbols[5], 24):
        name, _, _, section = struct.unpack_from("<IBBH", data, at)
        (exported if section else undefined).append(text(name))
    entries = [struct.unpack_from("<QQ", data, at) for at in range(dynamic[4], dynamic[4] + dynamic[5], 16)]
    return exported, undefined, [text(value) for tag, value in entries if tag == 1]


def _pe_exports(data: bytes, table: int, count: int, directory: int) -> list[str]:
    sections = [struct.unpack_from("<IIII", data, table + 40 * i + 8) for i in range(count)]

    def place(address: int) -> int:
        return next(
            raw + address - virtual for size, virtual, _, raw in sections if virtual <= address < virtual + size
        )

    number, _, names = struct.unpack_from("<III", data, place(directory) + 24)
    found = []
    for (address,) in struct.iter_unpack("<I", data[place(names) : place(names) + 4 * number]):
        start = place(address)
        found.append(data[start : data.index(b"\0", start)].decode())
    return found


def _mach_commands(part: bytes) -> tuple[list[int], list[str]]:
    (count,) = struct.unpack_from("<I", part, 16)
    at, commands, libraries = 32, [], []
    for _ in range(count):
        command, size = struct.unpack_from("<II", part, at)
        commands.append(command)
        if command == 0xC:
            libraries.append(part[at + 24 : at + size].rstrip(b"\0").decode())
        at += size
    return commands, libraries
