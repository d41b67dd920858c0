"""Changes of C, tried in a few seconds each: the part of `python -m tests.areas` that tries them.

One process imports the tests once. A fork of it runs each test alone, and gcov says which lines of C that executes. A
fork for each change then runs the tests that execute its line, the quickest first, until one fails. A process that is
ended tells gcov nothing: "no test" behind a change says that none is known, and `--tests` tries it with those named.
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
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from time import monotonic
from typing import Any

import click
import pytest

_ASKED = "MUTANTS_OF_C"
_HERE = Path(__file__).parents[1]


def unseen(root: Path, compiler: Path, chosen: Sequence[tuple[int, str, int, str, str]], tests: Sequence[str]) -> int:
    """Tries changes (number, file, line, words, text) in a copy of the tree; returns how many no test saw."""
    asked, answer = root / "changes.json", root / "unseen"
    asked.write_text(json.dumps(chosen), "utf-8")
    more = {"PYTHONPATH": str(root), "CC": str(compiler), _ASKED: str(asked), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "pytest", "-q", "-s", "-p", "no:randomly", "-p", "no:cacheprovider"]
    command += ["-p", "no:xdist", "-p", __name__, *tests]
    subprocess.run(command, cwd=root, env=os.environ | more, check=False)
    if not answer.exists():
        raise click.ClickException("the tests do not run, or fail without a change")
    return int(answer.read_text("utf-8"))


def pytest_runtestloop(session: pytest.Session) -> bool | None:
    """Takes the place of the run of the tests."""
    if _ASKED not in os.environ:
        return None
    asked = Path(os.environ[_ASKED])
    chosen = json.loads(asked.read_text("utf-8"))
    functions = {item.nodeid: item for item in session.items}
    executed, times = _executed(session, functions, {file for _, file, *_ in chosen})
    for kept in ("tests", "fmus"):  # compiled to say what is executed
        shutil.rmtree(_HERE / "out" / kept, ignore_errors=True)
    if not _passes(session, functions, {name: time for name, time in times.items() if time >= 0.0}):
        raise pytest.UsageError("the tests fail without a change")
    lost = 0
    for number, file, line, words, changed in chosen:
        these = sorted(executing(*executed[file], line), key=times.__getitem__)
        path = _HERE / file
        text = path.read_text("utf-8")
        path.write_text(changed, "utf-8")
        seen = bool(these) and not _passes(session, functions, {name: times[name] for name in these})
        path.write_text(text, "utf-8")
        lost += not seen
        end = "seen" if seen else "NOT SEEN" if these else "NOT SEEN, no test"
        _say(f"{number} {end} {file}:{line}: {words}")
    asked.with_name("unseen").write_text(str(lost), "utf-8")
    return True


def executing(executed: Mapping[int, set[str]], functions: set[tuple[int, int]], line: int) -> set[str]:
    """The tests that execute a line, or the one before it where its statement begins; those that execute any line of
    the file where the line is in no function."""
    for begin, end in functions:
        if begin <= line <= end:
            return executed[max(n for n in executed if begin <= n <= line)]
    return set().union(*executed.values())


def _executed(
    session: pytest.Session, functions: Mapping[str, pytest.Item], files: set[str]
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
    functions: Mapping[str, pytest.Item],
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
        items = [(functions[name], time) for name, time in times.items()]
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
