"""Writes the folder in which a record of calls can be played without Python, and plays one by the same program.

Tests: tests/orchestration/instances/record/test_play.py.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from fmus import places

from ...errors import InputError, reason
from ...fmu.archive import Fmu, open_fmu
from ...temporary import temporary
from ..compilation import kept
from ..process import signal_name
from .recorder import FIRST, FOLDER, complete

RECORD = "calls.bin"
_SOURCES = "replay.c", "calls.h"
_LIMIT = 600.0
"""Seconds that a replay may take."""


@dataclass(frozen=True)
class Played:
    """Result of a replay."""

    lines: list[str]
    """What the program said: the first call that differs, and how many do."""
    log: list[str]
    """What the FMU logged or printed on its standard error."""
    same: bool
    """Whether all answers are those of the record."""
    ended: str = ""
    """How the FMU ended the program; empty where it did not."""


def write_folder(folder: Path, fmu: Fmu) -> None:
    """Puts the program, its Makefile and the FMU beside the record. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in _SOURCES:
        shutil.copy(FOLDER / name, folder)
    shutil.copy(fmu.path, folder / f"{folder.name}.fmu")
    text = (FOLDER / "Makefile.template").read_text("utf-8").replace("{fmu}", f"{folder.name}.fmu")
    (folder / "Makefile").write_text(text, "utf-8")


def play(
    record: Path,
    other: Path | None = None,
    *,
    tolerance: float = 0.0,
    until: int | None = None,
    shortest: Path | None = None,
    log: bool = False,
) -> Played:
    """Plays a record on the FMU beside it, or on another. Raises InputError.

    `tolerance` is a share of the largest value that a port has had. `shortest` is a file for the record up to the first
    call that differs, fails or does not return.
    """
    try:
        complete(record)
    except OSError as error:
        raise InputError(f"{record}: {reason(error)}") from None
    head = _head(record)
    path = other or _beside(record)
    fmu = open_fmu(path.absolute(), lenient=True)
    if other is None and fmu.sha256 != (recorded := head.get("sha256")):
        text = f"{path} has another hash than the FMU that was recorded, {recorded}; remedy: --fmu {path}"
        raise InputError(text)
    options = ["--tolerance", repr(tolerance), "--library", fmu.library]
    options += ["--until", str(until)] if until is not None else []
    options += ["--shortest", str(shortest.absolute())] if shortest is not None else []
    options += ["--log"] if log else []
    with temporary() as work:
        fmu.extract(work / "fmu")
        command = [str(_program()), str(record.absolute()), str(work / "fmu"), *options]
        return _played(command, work, path)


def _played(command: Sequence[str], work: Path, path: Path) -> Played:
    try:
        done = subprocess.run(
            command, capture_output=True, cwd=work, timeout=_LIMIT, check=False, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired as late:
        lines = (late.stdout or b"").decode("utf-8", "replace").splitlines()
        return Played(lines, [], same=False, ended=f"did not end within {_LIMIT:g} s")
    lines, log = (text.decode("utf-8", "replace").splitlines() for text in (done.stdout, done.stderr))
    if done.returncode == 2:
        raise InputError(f"{path}: {log[-1] if log else 'the record cannot be played'}")
    ended = ""
    if done.returncode < 0:
        ended = f"crashed with {signal_name(-done.returncode)}"
    elif done.returncode not in (0, 1):
        ended = f"ended the program, with exit status {done.returncode}"
    return Played(lines, log, done.returncode == 0, ended)


def _head(record: Path) -> dict[str, str]:
    """Returns what a record says of its FMU, but for the variables."""
    if record.exists() and not record.is_file():
        raise InputError(f"{record}: expected a record of calls, found no regular file")
    try:
        with record.open("rb") as file:
            lines = [line.decode("utf-8", "replace").rstrip("\n") for line in _until_empty(file)]
    except OSError as error:
        raise InputError(f"{record}: {reason(error)}") from None
    if lines[:1] != [FIRST]:
        raise InputError(f"{record}: expected a record of calls, as 'orchestrate run --record-calls BLOCK' writes it")
    return dict(line.partition(" ")[::2] for line in lines[1:] if not line.startswith("variable "))


def _until_empty(file: Iterator[bytes]) -> Iterator[bytes]:
    for line in file:
        if line in (b"\n", b"") or len(line) > 10_000:
            return
        yield line


def _beside(record: Path) -> Path:
    found = sorted(record.absolute().parent.glob("*.fmu"))
    if len(found) != 1:
        raise InputError(f"{record}: expected one FMU beside it, found {len(found)}; remedy: --fmu FILE")
    return found[0]


def _program() -> Path:
    """Returns replay.c as a program of this machine, compiled where it is missing or out of date. Raises InputError."""
    try:
        return kept("replay", [FOLDER / name for name in _SOURCES], _compile, ".exe")
    except RuntimeError as error:
        raise InputError(f"a record is played by a program in C, which cannot be made: {error}") from None
    except OSError as error:
        raise InputError(f"{places.work() / 'replay'}: {reason(error)}") from None


def _compile(program: Path) -> None:
    """Raises InputError without a compiler, and RuntimeError with the words of one."""
    from fmus.native import toolchain  # here, since it takes 15 ms  # noqa: PLC0415

    zig, found = toolchain.zig(), next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
    if zig is None and found is None:
        raise InputError("a record is played by a program in C; remedy: pip install ziglang, or a C compiler (cc)")
    compiler = [str(zig), "cc"] if zig is not None else [str(found)]
    link = ["-lm", "-ldl"] if sys.platform == "linux" else []
    toolchain.run([*compiler, "-O2", "-std=c11", str(FOLDER / _SOURCES[0]), *link, "-o", str(program)], program)
