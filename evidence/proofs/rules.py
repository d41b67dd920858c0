"""MISRA C:2012 by cppcheck's addon and clang-tidy's bugprone and cert checks, on the flight code, against the list of
deviations.

Shows FC-3.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections import Counter
from pathlib import Path

import yaml

from fmus.block import Block, natives
from fmus.link import NATIVE
from fmus.native import COMMON, generated_sources
from fmus.places import PACKAGES
from orchestration import InputError
from orchestration.cli.console import say

from ..tools import tool
from .coverage import FLIGHT
from .subjects import ELEMENTARY, HERE

ADVISORY = frozenset(
    "2.3 2.4 2.5 2.6 2.7 4.2 5.9 8.7 8.9 8.11 8.13 10.5 11.4 11.5 12.1 12.3 12.4 13.3 13.4 15.1 15.4 15.5 17.5 "
    "17.8 18.4 "
    "18.5 19.2 20.1 20.5 21.12".split()
)
"""Rules of MISRA C:2012 that are not required; they are not asked for."""
CHECKS = "-*,bugprone-*,cert-*,-bugprone-easily-swappable-parameters"
"""Vectors and angles in a row are what the code is about."""

FILE = HERE / "deviations.yaml"

Found = Counter[tuple[str, str]]
"""How many of each rule in each file."""


def findings() -> Found:
    """Returns the findings of both tools in files of this project. Raises InputError where one is not installed."""
    found: Found = Counter()
    with tempfile.TemporaryDirectory() as temporary:
        places = set[tuple[str, str, str]]()
        for name in FLIGHT:
            block, own = Block.named(name), Path(temporary, name)
            own.mkdir()
            for header, text in generated_sources(block.interface, block.folder).items():
                (own / header).write_text(text, "utf-8")
            folders = natives(block.folder)
            include = [f"-I{path}" for path in (*folders, COMMON, own)]
            places |= _of_tools(sorted(folders[0].rglob("*.c")), include, str(own))
        places |= _of_tools([NATIVE / "frame.c", ELEMENTARY], [f"-I{NATIVE}"], temporary)
    found.update((rule, file) for rule, file, _ in places)
    return found


def _of_tools(sources: list[Path], include: list[str], folder: str) -> set[tuple[str, str, str]]:
    """Rule, file and line of each finding; cppcheck's own files go to a folder, since it leaves them where it is
    stopped."""
    shape = "--template={id}|{file}|{line}:{column}|{severity}"
    words = [
        "-q",
        "--addon=misra",
        "--std=c11",
        "--platform=unix64",
        "--enable=style",
        f"--cppcheck-build-dir={folder}",
        shape,
    ]
    places = set()
    for line in _output([tool("cppcheck"), *words, *include, *map(str, sources)]).splitlines():
        rule, _, place = line.partition("|")
        file, _, where = place.partition("|")
        is_misra = rule.startswith("misra-c2012-") and rule.removeprefix("misra-c2012-") not in ADVISORY
        if is_misra or where.endswith("|error"):
            places.add((rule, _named(file), where))
    for line in _output(
        [tool("clang-tidy"), "-quiet", f"-checks={CHECKS}", *map(str, sources), "--", "-std=c11", *include]
    ).splitlines():
        if seen := re.match(r"(.*?):(\d+:\d+): (?:warning|error): .* \[([\w.-]+)", line):
            places.add((seen[3], _named(seen[1]), seen[2]))
    return {place for place in places if place[1]}


def _named(file: str) -> str:
    """The file in this project, with slashes; empty where it is another."""
    path = Path(file).resolve()
    return path.relative_to(PACKAGES).as_posix() if path.is_relative_to(PACKAGES) else ""


def _output(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout + done.stderr


def deviations() -> list[tuple[str, str, dict[str, int]]]:
    """Rule, reason, and how many in which file: those of deviations.yaml."""
    entries = yaml.safe_load(FILE.read_text("utf-8"))
    return [(e["rule"], e["reason"], e["places"]) for e in entries]


def check() -> Found:
    """Raises InputError where the findings are not those of the list."""
    listed: Found = Counter({(rule, file): n for rule, _, places in deviations() for file, n in places.items()})
    found = findings()
    wrong = [key for key in sorted(found.keys() | listed.keys()) if found[key] != listed[key]]
    for rule, file in wrong:
        say(f"{file}: {rule}: expected {listed[rule, file]} as in deviations.yaml, found {found[rule, file]}")
    if wrong:
        raise InputError(f"{len(wrong)} findings are not as in evidence/proofs/deviations.yaml")
    return found
