"""Mutants of an area in C, in a few seconds each: `python -m tests.mutants_of_c "allocator in C" --seed 1`.

Draws the changes that tests/areas.py draws, and prints the same. One process
imports the tests once. A fork of it runs each test alone, and gcov says which lines of C that executes. A fork for each
change then runs the tests that execute its line, the quickest first, until one fails. A process that is ended tells
gcov nothing: `python -m tests.areas` with `--only` tries a change with all tests.
Tests: tests/test_areas.py.
"""

from __future__ import annotations

import ctypes
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from time import monotonic
from typing import Any

import click
import pytest

from . import areas, mutants

_ASKED = "MUTANTS_OF_C"
_HERE = Path(__file__).parents[1]


@click.command()
@click.argument("area", type=click.Choice([area for area in areas.AREAS if area.endswith(" in C")]))
@click.option("--count", default=15, show_default=True, help="How many changes.")
@click.option("--seed", default=1, show_default=True, help="Draws them.")
@click.option("--only", default="", metavar="N,N,...", help="Try these of them alone.")
@click.option("--tests", default="", metavar="PATH PATH ...", help="Tests in the place of the area's.")
def main(area: str, count: int, seed: int, only: str, tests: str) -> None:
    """Count what the tests of AREA see of changes to its code."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "0"
        mutants.copy(root)
        areas._with_objects(root, Path(folder))
        compiler = Path(folder) / "cc"
        compiler.write_text(compiler.read_text("utf-8").replace('"$@"', '"$@" $MORE_FLAGS'), "utf-8")
        asked = json.dumps({"area": area, "count": count, "seed": seed, "only": only.split(",") if only else []})
        more = {"PYTHONPATH": str(root), "CC": str(compiler), _ASKED: asked, "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, "-m", "pytest", "-q", "-s", "-p", "no:randomly", "-p", "no:cacheprovider"]
        command += ["-p", "no:xdist", "-p", __spec__.name if __spec__ else "tests.mutants_of_c"]
        command += tests.split() or areas.AREAS[area][1]
        sys.exit(subprocess.run(command, cwd=root, env=os.environ | more, check=False).returncode)


def pytest_runtestloop(session: pytest.Session) -> bool | None:
    """Takes the place of the run of the tests."""
    if _ASKED not in os.environ:
        return None
    asked = json.loads(os.environ[_ASKED])
    chosen = [
        one
        for one in areas.drawn(_HERE, asked["area"], asked["count"], asked["seed"])
        if not asked["only"] or str(one.number) in asked["only"]
    ]
    functions = {item.nodeid: [item] for item in session.items}
    executed, times = _executed(session, functions, {change.file for change in chosen})
    for kept in ("tests", "fmus"):
        shutil.rmtree(_HERE / "out" / kept, ignore_errors=True)
    if not _passes(session, functions, {name: time for name, time in times.items() if time >= 0.0}):
        raise pytest.UsageError("the tests fail without a change")
    ends: Counter[str] = Counter()
    begun = monotonic()
    for change in chosen:
        elsewhere = change.file.endswith("_windows.c")
        if reason := "not compiled on this machine" if elsewhere else areas.equivalent(change):
            end = f"equivalent, {reason}:"
        else:
            these = sorted(executing(*executed[change.file], change.line), key=times.__getitem__)
            path = _HERE / change.file
            text = path.read_text("utf-8")
            path.write_text(change.text, "utf-8")
            seen = these and not _passes(session, functions, {name: times[name] for name in these})
            end = "seen" if seen else "NOT SEEN"
            path.write_text(text, "utf-8")
            end += "" if these else " (no test)"
        ends[end.partition(",")[0].removesuffix(" (no test)")] += 1
        _say(f"{change.number} {end} {change.file}:{change.line}: {change.words}")
    equal = ends["equivalent"]
    _say(f"{asked['area']}: {ends['seen']} of {len(chosen) - equal} changes seen, and {equal} that no test can see")
    _say(f"{(monotonic() - begun) / 60:.1f} minutes")
    session.testsfailed = ends["NOT SEEN"]
    return True


def executing(executed: Mapping[int, set[str]], functions: set[tuple[int, int]], line: int) -> set[str]:
    """The tests that execute a line, or the one before it where its statement begins; those that execute any line of
    the file where the line is in no function."""
    for begin, end in functions:
        if begin <= line <= end:
            return executed[max(n for n in executed if begin <= n <= line)]
    return set().union(*executed.values())


def _executed(
    session: pytest.Session, functions: Mapping[str, Sequence[pytest.Item]], files: set[str]
) -> tuple[dict[str, tuple[dict[int, set[str]], set[tuple[int, int]]]], dict[str, float]]:
    """By file of C the tests that execute each line, and where its functions begin and end; and the time of each test.

    One that fails is left out, and said.
    """
    found: dict[str, tuple[dict[int, set[str]], set[tuple[int, int]]]] = {file: ({}, set()) for file in files}
    times = {}
    os.environ["MORE_FLAGS"] = "-O0 --coverage"
    with tempfile.TemporaryDirectory() as folder:
        for number, name in enumerate(functions):
            os.environ["GCOV_PREFIX"] = f"{folder}/{number}"
            begun = monotonic()
            if not _passes(session, functions, {name: 600.0}, ctypes.CDLL(None).exit):
                _say(f"{name} fails without a change")
                times[name] = -1.0  # and is left out
                continue
            times[name] = monotonic() - begun
            for file, noted in _covered(Path(folder, str(number)), files):
                lines, bounds = found[file]
                bounds |= {(each["start_line"], each["end_line"]) for each in noted["functions"]}
                for line in noted["lines"]:
                    lines.setdefault(line["line_number"], set()).update([name] if line["count"] else [])
    del os.environ["GCOV_PREFIX"]
    os.environ["MORE_FLAGS"] = ""
    _say(f"{len(functions)} tests, {sum(times.values()):.0f} s")
    return found, times


def _covered(folder: Path, files: set[str]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yields each of the files, and what gcov noted of it in a folder."""
    wanted = [str(_HERE / file).encode() for file in files]
    data = []
    for path in folder.rglob("*.gcda"):
        notes = Path("/", path.relative_to(folder)).with_suffix(".gcno")
        if any(each in notes.read_bytes() for each in wanted):
            path.with_suffix(".gcno").symlink_to(notes)
            data.append(path.name)
            where = path.parent
    if not data:
        return
    said = subprocess.run(["gcov", "--json-format", "--stdout", *data], cwd=where, capture_output=True, check=True)
    for text in said.stdout.splitlines():
        for file in json.loads(text)["files"]:
            path = Path(file["file"])
            if path.is_relative_to(_HERE) and path.relative_to(_HERE).as_posix() in files:
                yield path.relative_to(_HERE).as_posix(), file


def _passes(
    session: pytest.Session,
    functions: Mapping[str, Sequence[pytest.Item]],
    times: Mapping[str, float],
    leave: Callable[[int], object] = os._exit,
) -> bool:
    """Whether test functions pass in a fork, none of them in more than many times its time."""
    child = os.fork()
    if child:
        _, status = os.waitpid(child, 0)
        with suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
        return status == 0
    os.setsid()
    null = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(null, descriptor)
    failed = 1
    try:
        items = [(item, time) for name, time in times.items() for item in functions[name]]
        for (item, time), (after, _) in zip(items, [*items[1:], (None, 0)], strict=True):
            signal.alarm(10 + int(5.0 * time))
            session.config.hook.pytest_runtest_protocol(item=item, nextitem=after)
            if session.testsfailed:
                break
        else:
            failed = 0
        signal.alarm(0)
    finally:
        leave(failed)
        os._exit(failed)
    return False


def _say(text: str) -> None:
    print(text, flush=True)


if __name__ == "__main__":
    main(prog_name="python -m tests.mutants_of_c")
