"""Runs Frama-C's Eva on a program and reads what it could not prove.

Needs frama-c (Debian: frama-c-base).
"""

from __future__ import annotations

import csv
import re
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from orchestration import InputError

from ..tools import tool

MACHINE = "gcc_x86_64"
FLAGS = (
    *("-machdep", MACHINE, "-eva", "-eva-split-return", "auto"),
    *("-warn-signed-overflow", "-warn-signed-downcast", "-warn-unsigned-downcast", "-warn-invalid-bool"),
    "-eva-msg-key=-final-states,-initial-state",
)
_PROVED = ("Valid", "Considered valid", "Dead")


@dataclass(frozen=True, order=True)
class Alarm:
    """A property that was not proved: where, of what kind, and its text."""

    file: str
    line: int
    function: str
    kind: str
    text: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.function}: {self.kind}: {self.text}"


@dataclass(frozen=True)
class Result:
    """Result of an analysis."""

    alarms: tuple[Alarm, ...]
    proved: int
    """Properties that hold."""
    statements: tuple[int, int]
    """Reached, and all, of the functions that were analysed."""
    seconds: float
    functions: tuple[str, ...] = ()
    """Those that the program enters, by Frama-C's names: `add_3` is that of the fifth file that has an `add`."""
    rounds: tuple[tuple[str, bool], ...] = ()
    """Of each loop whose rounds are checked, `file: head` and whether its bound is proved."""


def analyse(
    program: Path,
    sources: Sequence[Path],
    headers: Sequence[Path],
    options: Sequence[str],
    define: Sequence[str],
    prelude: Path,
    numbers_only: bool,
    loops: Mapping[tuple[str, int], str],
) -> Result:
    """Eva on a program with these sources, in the folder of the program; its whole output is left in eva.log there.

    `numbers_only`: only what concerns numbers counts, since the rest is proved with more numbers elsewhere.
    `loops`: those whose rounds the C checks, by file and line. Raises InputError where Frama-C is missing or fails.
    """
    folder, began = program.parent, time.monotonic()
    table, log = folder / "properties.csv", folder / "eva.log"
    table.unlink(missing_ok=True)
    words = [f"-D{name}" for name in define] + [f"-include {prelude}"] + [f"-I{path}" for path in (*headers, folder)]
    command = [tool("frama-c"), f"-cpp-extra-args={' '.join(words)}", str(program), *map(str, sources), *FLAGS]
    command += [*options, "-then", "-report-csv", str(table), "-metrics", "-metrics-eva-cover"]
    with log.open("w", encoding="utf-8") as file:
        done = subprocess.run(command, stdout=file, stderr=subprocess.STDOUT, check=False, cwd=folder)
    text = log.read_text("utf-8")
    if done.returncode or not table.exists():
        raise InputError(f"{program}: Frama-C failed; its words are in {log}")
    rows = [row for row in csv.DictReader(table.open(encoding="utf-8"), delimiter="\t") if _counts(row, numbers_only)]
    checks = [row for row in rows if row["property kind"] == "user check" and row["status"] != "Dead"]
    rows = [row for row in rows if row["property kind"] != "user check"]
    rounds = tuple(sorted({(loops[_place(row)], row["status"] in _PROVED) for row in checks}))
    alarms = tuple(sorted({_alarm(row) for row in rows if row["status"] not in _PROVED}))
    valid = sum(row["status"] == "Valid" for row in rows)
    entered = tuple(re.findall(r"^  (\w+): [1-9]\d* stmts out of", text, re.MULTILINE))
    return Result(alarms, valid, _reached(text), time.monotonic() - began, entered, rounds)


def _counts(row: dict[str, str], numbers_only: bool) -> bool:
    """A precondition of the C library counts where it is called."""
    about_memory = row["property kind"] in ("initialization", "mem_access", "index_bound")
    return not row["directory"].startswith("FRAMAC_SHARE") and not (numbers_only and about_memory)


def _place(row: dict[str, str]) -> tuple[str, int]:
    """The file in the folder `packages` of the proof, with slashes, and the line."""
    return f"{row['directory']}/{row['file']}".rpartition("/packages/")[2], int(row["line"])


def _alarm(row: dict[str, str]) -> Alarm:
    function = re.sub(r"_\d+$", "", row["function"])
    return Alarm(Path(row["file"]).name, int(row["line"]), function, row["property kind"], row["property"].strip())


def _reached(text: str) -> tuple[int, int]:
    found = re.search(r"(\d+) statements reached \(out of (\d+)\)", text)
    if found is None:
        raise InputError("Frama-C's summary has no statements reached; remedy: the version that the page names")
    return int(found[1]), int(found[2])
