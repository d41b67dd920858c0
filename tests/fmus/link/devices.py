"""Devices for tests: our own native blocks as firmware on this computer, and the link FMUs that ask them."""

from __future__ import annotations

import ctypes
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from fmus import link, native
from fmus.interface import load
from fmus.kit import linked
from fmus.native.toolchain import FLAGS, FREESTANDING, PLATFORMS, compile_library, compiler, host_platform
from tests.blocks import folder as folder_of
from tests.native.driver import GUID, Instance, opened
from tests.once import built

ZIG = [sys.executable, "-m", "ziglang", "cc"]


def program(block: str) -> Path:
    """A device that answers with a native block's own code, and with the arithmetic that its FMU has."""
    with tempfile.TemporaryDirectory() as folder:
        flight, line, includes = linked.lay_out(load(block), folder_of(block), Path(folder))
        sources = [*flight, *line]
        made_of = [compiler(), *FLAGS, *sources, *includes, FREESTANDING]
        return built(f"{block}_device", made_of, lambda path: _build(sources, includes, path))


def _build(sources: list[Path], includes: list[Path], path: Path) -> None:
    """The block with our own elementary functions, since those of the system's C library round otherwise."""
    folders = [f"-I{folder}" for folder in includes]
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder, "block.o")
        files = [*sources, FREESTANDING / "elementary.c"]
        bare = [*ZIG, *FLAGS, "-ffreestanding", "-nostdlib", "-r", f"-I{FREESTANDING}", *folders, *map(str, files)]
        subprocess.run([*bare, "-o", str(whole)], check=True)
        board = [link.FIRMWARE / "main.c", link.FIRMWARE / "board_computer.c", whole]
        subprocess.run([*ZIG, *FLAGS, *folders, *map(str, board), "-o", str(path)], check=True)


@cache
def fmu(block: str) -> Path:
    """The link FMU of a block for this machine."""
    made_of = [compiler(), *FLAGS, *link.sources(), native.SHELL, link.HERE / "link.toml", load(block).source]
    return built(f"{block}_link.fmu", made_of, lambda path: path.write_bytes(link.package(load(block), "host")))


@cache
def library(block: str) -> ctypes.CDLL:
    """The library of a block's link FMU, for calls without an FMU tool."""
    host = host_platform()
    with tempfile.TemporaryDirectory() as folder:
        sources, includes = link.lay_out(load(block), GUID, Path(folder))

        def make(path: Path) -> None:
            path.write_bytes(compile_library(path.name, sources, includes, [host], hosted=True)[host])

        name = f"{block}_link{PLATFORMS[host].suffix}"
        return opened(built(name, [compiler(), *FLAGS, *sources, *includes], make))


def instance(block: str, **settings: Any) -> Instance:
    """An instance of the link FMU with these link_... parameters, not yet initialized."""
    made = Instance(link.linked(load(block)), library(block))
    for name, value in settings.items():
        made.set(f"link_{name}", value)
    return made


@contextmanager
def started(command: Sequence[str | Path], **options: Any) -> Iterator[subprocess.Popen[bytes]]:
    """A program that says when it is ready, until the block of code is left; `options` are those of Popen."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, **options)
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        yield process
    finally:
        process.kill()
        process.wait()


def running(block: str, *line: str, **options: Any) -> AbstractContextManager[subprocess.Popen[bytes]]:
    """A device that serves a line: `running("controller", "udp", "5020")`."""
    return started([program(block), *line], **options)


def free_port(kind: int = socket.SOCK_DGRAM) -> str:
    """A port at which nobody listens."""
    with socket.socket(socket.AF_INET, kind) as line:
        line.bind(("127.0.0.1", 0))
        return str(line.getsockname()[1])
