"""Mutants of an area, drawn by a seed: `python -m tests.areas AREA --count 15 --seed 1`.

Changes one token of the area's code at a time, in Python and C, and prints the changes that none of its tests sees.
Exit status 1 where there are any. `python -m tests.mutants` makes all changes of some modules by mutmut, but none of C.
Changes that no test can see stand in areas.toml, each with its reason. Works in copies of the tree.
The first run, without a change, takes the time of each test and which lines it runs, in Python also in processes that
it starts. What fails there is named and left out. A change of Python is tried with the tests that run its statement:
those that take 3 s together, then the rest; then with the quickest other tests that run its file, for 20 s. A statement
that runs at import is tried with all tests that run its file. A change of C is tried as mutants_of_c.py says.
A change is seen where a test fails, or does not end, or where a file of tests cannot be imported any more. It is also
seen where no compiler takes it. Where it takes the name of a test away, all tests of that file are tried. Any other end
of pytest, such as an error of its own, is no failure of a test: the change counts as not seen.
`--only 7,12` tries two of the changes that a seed draws again, `--tests` any with the tests that it names.
Tests: tests/test_areas.py.
"""

from __future__ import annotations

import io
import os
import random
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import tokenize
import tomllib
import warnings
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import astuple, dataclass
from functools import cache
from itertools import accumulate, chain
from math import fsum
from pathlib import Path
from queue import SimpleQueue
from types import MappingProxyType

import click

from . import covered, mutants_of_c
from .mutants import ROOT, copy

_C = (
    "tests/native/test_direct.py",
    "tests/native/test_flavours.py",
    "tests/native/test_flavours_refuse.py",
    "tests/native/test_thresholds.py",
    "tests/native/test_history.py",
    *(f"tests/native/test_history_{name}.py" for name in ("estimator", "laws", "supervisor")),
)
_PLANNER = "tests/controller/planned", "tests/native/test_planned.py"
AREAS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "acceptance": (("orchestration/acceptance/**/*.py",),
                   ("tests/orchestration/acceptance", "tests/fmus/kit", "tests/orchestration/cli/test_failed_swap.py",
                    "tests/orchestration/swap/test_inputs.py", "tests/orchestration/swap/test_own_claims.py",
                    "tests/orchestration/swap/test_mapping.py", "tests/orchestration/telemetry/test_log.py")),
    "campaign": (("orchestration/campaign/**/*.py",), ("tests/orchestration/campaign",)),
    "link": (("fmus/link/**/*.py", "fmus/link/**/*.c"), ("tests/fmus/link",)),
    "packaging": (("hatch_build.py", "release/*.py", "fmus/fingerprint.py", "fmus/build.py"),
                  ("tests/packaging/test_layout.py", "tests/packaging/test_wheel.py", "tests/release", "tests/fmus")),
    "scenario": (("orchestration/scenario/*.py", "orchestration/system/*.py"),
                 ("tests/orchestration/scenario", "tests/orchestration/system", "tests/plant/test_inputs.py",
                  "tests/orchestration/test_wrong_input.py", "tests/orchestration/test_timeline.py",
                  "tests/orchestration/master/test_master.py", "tests/orchestration/master/test_every_step.py",
                  "tests/orchestration/cli/test_realtime.py", "tests/orchestration/cli/test_noted.py",
                  "tests/orchestration/expectations/test_expressions.py",
                  "tests/orchestration/results/test_view_data.py", "tests/orchestration/results/test_outputs.py")),
    "ssp": (("orchestration/ssp/*.py", "orchestration/export/*.py"),
            ("tests/orchestration/export", "tests/tools/test_ssp.py", "tests/tools/test_foreign_ssp.py",
             "tests/tools/test_rates.py")),
    "allocator in C": (
        ("allocator/**/native/*.c",),
        ("tests/allocator", *_C,
         *(f"tests/native/test_allocator_{name}.py" for name in ("wheels", "failed_wheels", "telemetry")))),
    "controller in C": (("controller/native/*.c",), ("tests/controller", *_C)),
    "FMI shell in C": (
        ("fmus/native/shell/*.c",),
        tuple(f"tests/native/test_{name}.py" for name in ("calls", "values", "states", "memory", "sampling", "limits",
                                                          "refusals", "fmi3"))),
    "estimator in C": (("estimator/native/*.c",), ("tests/estimator", "tests/native/test_estimator_wheels.py", *_C)),
    "planner's watches in C": (
        ("controller/planned/native/estimate/*.c", "controller/planned/native/decide/*.c",
         "controller/planned/native/controller_planned.c",
         "controller/planned/native/inputs.c"),
        _PLANNER),
    "planner's plans in C": (
        ("controller/planned/native/plan/*.c", "controller/planned/native/motion.c",
         "controller/planned/native/scales.c", "controller/planned/native/parameters.c"),
        _PLANNER),
    "plant in C": (("plant/native/*.c",), ("tests/native/test_plant.py", "tests/native/test_plant_wheels.py", *_C)),
    "sensors in C": (("plant/sensors/native/*.c",), ("tests/plant/sensors", *_C)),
    "supervisor in C": (("supervisor/native/*.c",), ("tests/supervisor", *_C)),
}  # fmt: skip
"""By area: its code, and the tests that it is held against."""
EQUIVALENT: dict[str, str] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
_FINE, _FAILED, _NOT_FOUND = (0, 5), 1, 4
"""Exit status of pytest: all pass, or there are none of the kind; one fails; one that is named is not there."""
_NO_IMPORT = "ERROR collecting", "while loading conftest"
"""What pytest says where a file of tests cannot be imported."""
_PAIRS = (
    *("< <=", "> >=", "== !=", "+ -", "* /", "+= -=", "&& ||", "and or"),
    *("True False", "true false", "min max", "break continue"),
)
_SWAPS = {a: b for pair in _PAIRS for x, y in [pair.split()] for a, b in ((x, y), (y, x))}
_SWAPS |= {"0": "1", "1": "2", "0.0": "1.0", "1.0": "2.0", "not": "", "is": "is not", "in": "not in"}
_C_TOKEN = re.compile(
    r"/\*.*?\*/|//[^\n]*|\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])*'|^[ \t]*#(?:\\\n|[^\n])*"
    r"|(?<= )(?:&&|\|\||[<>=!+-]=|[<>+*/-])(?= )|\b(?:true|false|break|continue|0\.0|1\.0|[01])(?![\w.])",
    re.DOTALL | re.MULTILINE,
)


def changes(path: Path) -> Iterator[tuple[int, int, str]]:
    """Yields begin, end and other text of each token that can be changed."""
    text = path.read_text("utf-8")
    if path.suffix == ".c":
        for match in _C_TOKEN.finditer(text):
            if (other := _SWAPS.get(match[0])) is not None:
                yield match.start(), match.end(), other
        return
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        begin, end = starts[token.start[0] - 1] + token.start[1], starts[token.end[0] - 1] + token.end[1]
        if token.type in (tokenize.OP, tokenize.NAME, tokenize.NUMBER) and token.line[:1].isspace():
            other = _SWAPS.get(token.string)
            if other is not None and _compiles(text[:begin] + other + text[end:]):
                yield begin, end, other


def _compiles(text: str) -> bool:
    try:
        with warnings.catch_warnings(action="ignore"):
            compile(text, "mutant", "exec")
    except SyntaxError:
        return False
    return True


@dataclass(frozen=True)
class Change:
    """Of one token of a file, whose text the change gives."""

    number: int
    file: str
    line: int
    words: str
    text: str

    @property
    def names(self) -> list[str]:
        """As areas.toml has it: by the line, or by that and which of the lines alike it is."""
        name, above = f"{self.file}: {self.words}", self.text.splitlines()[: self.line - 1]
        return [name, f"{name} ({1 + sum(name.endswith(f': {line.strip()}') for line in above)})"]


def equivalent(change: Change) -> str | None:
    """Why no test can see it; None where one should."""
    return next((EQUIVALENT[name] for name in change.names if name in EQUIVALENT), None)


def change_of(root: Path, path: Path, number: int, begin: int, end: int, other: str) -> Change:
    text = path.read_text("utf-8")
    line = text.count("\n", 0, begin)
    words = f"{text[begin:end]!r} -> {other!r}: {text.splitlines()[line].strip()}"
    return Change(number, path.relative_to(root).as_posix(), line + 1, words, text[:begin] + other + text[end:])


def drawn(root: Path, area: str, count: int, seed: int) -> Iterator[Change]:
    """Yields the changes that a seed draws in the code of an area, larger files more often."""
    draw = random.Random(seed)
    files = [path for pattern in AREAS[area][0] for path in sorted(root.glob(pattern)) if path.stem != "__init__"]
    of = cache(lambda path: list(changes(path)))
    files = [path for path in files if of(path)]
    for number in range(1, count + 1):
        path = draw.choices(files, [path.stat().st_size for path in files])[0]
        yield change_of(root, path, number, *draw.choice(of(path)))


@click.command()
@click.argument("area", type=click.Choice(list(AREAS)))
@click.option("--count", default=15, show_default=True, help="How many changes.")
@click.option("--seed", default=1, show_default=True, help="Draws them.")
@click.option("--only", default="", metavar="N,N,...", help="Try these of them alone.")
@click.option("--tests", default="", metavar="TEST...", help="Try them with these tests alone.")
@click.option("--processes", default=1, show_default=True, help="How many of Python are tried side by side.")
@click.option(
    "--share",
    type=click.FloatRange(0.0, 1.0),
    help="In Python, only the quickest of the tests of `make test`, which take this share of their time.",
)
def main(area: str, count: int, seed: int, only: str, tests: str, processes: int, share: float | None) -> None:
    """Count what the tests of AREA see of changes to its code."""
    chosen = [one for one in drawn(ROOT, area, count, seed) if not only or str(one.number) in only.split(",")]
    left = []
    for change in chosen:
        elsewhere = change.file.endswith("_windows.c") and sys.platform != "win32"
        if reason := "not compiled on this machine" if elsewhere else equivalent(change):
            _say(change, f"equivalent, {reason}:")
        else:
            left.append(change)
    in_c = [] if tests else [change for change in left if change.file.endswith(".c")]
    others = [change for change in left if change not in in_c]
    unseen = 0
    with tempfile.TemporaryDirectory() as folder:
        if others:
            unseen += _unseen(area, others, tests.split(), share, Path(folder), processes)
        if in_c:
            root = Path(folder) / "c"
            copy(root)
            _with_objects(root, Path(folder))
            unseen += mutants_of_c.unseen(
                root, Path(folder) / "cc", [astuple(change) for change in in_c], AREAS[area][1]
            )
    equal = len(chosen) - len(left)
    print(f"{area}: {len(left) - unseen} of {len(left)} changes seen, and {equal} that no test can see")
    sys.exit(1 if unseen else 0)


def _say(change: Change, end: str) -> None:
    print(f"{change.number} {end} {change.file}:{change.line}: {change.words}", flush=True)


def _unseen(
    area: str, chosen: list[Change], tests: Sequence[str], share: float | None, folder: Path, processes: int
) -> int:
    """Tries the changes, each in one of the copies of the tree; returns how many no test saw."""
    copies: SimpleQueue[Path] = SimpleQueue()
    for number in range(processes):
        copies.put(root := folder / str(number))
        copy(root)
        for kept in ("fmus", "tests"):
            if (ROOT / "out" / kept).is_dir():
                shutil.copytree(ROOT / "out" / kept, root / "out" / kept)
        if any(change.file.endswith(".c") for change in chosen):
            _with_objects(root, folder)
    lines = None
    if tests:
        _check(area, _run(root, tests, 600.0))
    else:
        lines = _lines(root, area, share is None)

    def one(change: Change) -> bool:
        root = copies.get()
        path = root / change.file
        text = path.read_text("utf-8")
        tried = [(tests, 600.0)] if lines is None else _covering(lines, root, change, text, share)
        time = path.stat().st_mtime
        path.write_text(change.text, "utf-8")
        os.utime(path, (time, time + change.number))  # by which Python knows that what it compiled is old
        seen = any(fails(root, some, limit) for some, limit in tried if some)
        path.write_text(text, "utf-8")
        os.utime(path, (time, time))
        copies.put(root)
        _say(change, "seen" if seen else "NOT SEEN")
        return seen

    with ThreadPoolExecutor(processes) as pool:
        return sum(not seen for seen in pool.map(one, chosen))


def _with_objects(root: Path, folder: Path) -> None:
    """Lets a copy compile for this machine alone, and only what has changed."""
    toolchain = root / "fmus" / "native" / "toolchain.py"
    toolchain.write_text(toolchain.read_text("utf-8").replace('("ziglang")', '("no compiler")'), "utf-8")
    kept, compiler = folder / "objects", folder / "cc"
    kept.mkdir(exist_ok=True)
    command = shlex.join([sys.executable, "-I", "-S", str(root / "tests" / "objects.py"), str(kept), "cc"])
    compiler.write_text(f'#!/bin/sh\nexec {command} "$@" $MORE_FLAGS\n', "utf-8")
    compiler.chmod(0o700)


def _check(area: str, end: subprocess.CompletedProcess[str] | None) -> None:
    """Raises ClickException where tests that ran without a change have failed, or could not be found."""
    if end is None or end.returncode not in _FINE:
        last = "they did not end" if end is None else end.stdout[-2000:]
        raise click.ClickException(f"the tests of {area} fail without a change:\n{last}")


def _lines(root: Path, area: str, thorough: bool) -> covered.Lines:
    """Which of the area's tests run which lines of its Python, from one run."""
    folder, start = root / "covered", root / "sitecustomize.py"
    folder.mkdir()
    files = [str(path) for pattern in AREAS[area][0] for path in root.glob(pattern)]
    settings = folder / "settings.ini"
    settings.write_text(covered.SETTINGS.format(files=",".join(files), data=folder), "utf-8")
    start.write_text(covered.BEGIN, "utf-8")
    more = ["-n2", "-p", "tests.covered", "--maxfail=1000", *([] if thorough else ["-m", "not thorough"])]
    measured = {"COVERAGE_PROCESS_START": str(settings), "COVERED": str(folder)}
    end = _run(root, AREAS[area][1], 3600.0, more, measured)
    start.unlink()
    if end is None or not (folder / "times").exists():
        raise click.ClickException(f"the tests of {area} do not run:\n{'' if end is None else end.stdout[-2000:]}")
    lines = covered.read(folder)
    print(f"{len(lines.times)} tests take {fsum(lines.times.values()):.0f} s; left out: {lines.failed}", flush=True)
    return lines


def _covering(
    lines: covered.Lines, root: Path, change: Change, text: str, share: float | None
) -> Iterator[tuple[list[str], float]]:
    """The tests that can see a change, in the order in which they are tried, and a time, s, that they do not take."""
    near, other = lines.of(root / change.file, text, change.line)
    first, rest = within(near, lines.times, 3.0)
    if share is not None:
        rest, other = within(rest, lines.times, share * fsum(lines.times[test] for test in near))[0], []
    for tests in (first, rest, within(other, lines.times, 20.0)[0]):
        by_file: dict[str, list[str]] = {}
        for test in tests:
            by_file.setdefault(test.partition("::")[0], []).append(test)
        limit = 60.0 + 4.0 * fsum(lines.times[test] for test in tests)
        yield list(chain.from_iterable(by_file.values())), limit


def within(tests: Sequence[str], times: Mapping[str, float], most: float) -> tuple[list[str], list[str]]:
    """The first of the tests, which take no more than this time together, but one at least; and the rest."""
    spent = list(accumulate(times[test] for test in tests))
    count = max(1, sum(time <= most for time in spent))
    return list(tests[:count]), list(tests[count:])


def fails(root: Path, tests: Sequence[str], limit: float) -> bool:
    """Whether one of the tests fails, or does not end, or cannot be imported."""
    end = _run(root, tests, limit)
    files = list(dict.fromkeys(test.partition("::")[0] for test in tests))
    if end is not None and end.returncode == _NOT_FOUND and not no_import(end.stdout) and files != list(tests):
        return fails(root, files, 600.0)
    return end is None or end.returncode == _FAILED or no_import(end.stdout)


def no_import(said: str) -> bool:
    """Whether pytest says that a file of tests cannot be imported."""
    return any(each in said for each in _NO_IMPORT)


def _run(
    folder: Path,
    tests: Sequence[str],
    limit: float,
    more: Sequence[str] = (),
    settings: Mapping[str, str] = MappingProxyType({}),
) -> subprocess.CompletedProcess[str] | None:
    """Runs tests in the copy, of which processes that they start import, too; None where they do not end."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-p", "no:randomly", *more]
    command += [f"@{folder / 'tests.txt'}"]
    (folder / "tests.txt").write_text("\n".join(tests), "utf-8")
    compiler = folder.parent / "cc"
    run = subprocess.Popen(
        command,
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(folder)} | settings | ({"CC": str(compiler)} if compiler.exists() else {}),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    try:
        said = run.communicate(timeout=limit)[0]
        return subprocess.CompletedProcess(command, run.returncode, said)
    except subprocess.TimeoutExpired:
        os.killpg(run.pid, signal.SIGKILL)
        run.wait()
        return None


if __name__ == "__main__":
    main(prog_name="python -m tests.areas")
