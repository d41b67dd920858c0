"""Mutants of an area, drawn by a seed: `python -m tests.areas AREA --count 15 --seed 1`.

Changes one token of the area's code at a time, in Python and C, and prints the changes that none of its tests sees.
Exit status 1 where there are any. `python -m tests.mutants` makes all changes of some modules by mutmut, but none of C.
Changes that no test can see stand in areas.toml, each with its reason.
Works in a copy of the tree. A change that no compiler takes, and a test that does not end, count as seen.
Tests: tests/test_areas.py.
"""

from __future__ import annotations

import io
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import tokenize
import tomllib
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path

import click

from .mutants import ROOT, copy

_C = (
    "tests/native/test_flavours.py",
    "tests/native/test_thresholds.py",
    "tests/native/test_history.py",
    *(f"tests/native/test_history_{name}.py" for name in ("estimator", "laws")),
)
AREAS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "acceptance": (("orchestration/acceptance/**/*.py",), ("tests/orchestration/acceptance",)),
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
    "allocator in C": (("allocator/**/native/*.c",), ("tests/allocator", *_C)),
    "controller in C": (("controller/native/*.c",), ("tests/controller", *_C)),
    "estimator in C": (("estimator/native/*.c",), ("tests/estimator", *_C)),
    "planner in C": (("controller/planned/native/**/*.c",),
                     ("tests/controller/planned", "tests/native/test_planned.py")),
    "sensors in C": (("plant/sensors/native/*.c",), ("tests/plant/sensors", *_C)),
    "supervisor in C": (("supervisor/native/*.c",), ("tests/supervisor", *_C)),
}  # fmt: skip
"""By area: its code, and the tests that it is held against."""
EQUIVALENT: dict[str, str] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
_KINDS = "not thorough", "thorough"
"""The tests of `make test`, and those of `make thorough` where the first see nothing."""
_FINE = 0, 5
"""Exit status of pytest: all pass, or there are none of the kind."""
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


@click.command()
@click.argument("area", type=click.Choice(list(AREAS)))
@click.option("--count", default=15, show_default=True, help="How many changes.")
@click.option("--seed", default=1, show_default=True, help="Draws them.")
def main(area: str, count: int, seed: int) -> None:
    """Count what the tests of AREA see of changes to its code."""
    with tempfile.TemporaryDirectory() as folder:
        sys.exit(1 if _unseen(area, count, random.Random(seed), Path(folder)) else 0)


def _unseen(area: str, count: int, draw: random.Random, folder: Path) -> int:
    copy(folder)
    if (ROOT / "out" / "fmus").is_dir():
        shutil.copytree(ROOT / "out" / "fmus", folder / "out" / "fmus")
    sources, tests = AREAS[area]
    files = [path for pattern in sources for path in sorted(folder.glob(pattern)) if path.stem != "__init__"]
    for kind in _KINDS:
        if (end := _run(folder, tests, kind)) is None or end.returncode not in _FINE:
            last = "they did not end" if end is None else end.stdout[-2000:]
            raise click.ClickException(f"the tests of {area} fail without a change:\n{last}")
    unseen = equal = 0
    files = [path for path in files if any(changes(path))]
    for number in range(1, count + 1):
        path = draw.choices(files, [path.stat().st_size for path in files])[0]
        possible = list(changes(path))
        begin, end, other = draw.choice(possible)
        text = path.read_text("utf-8")
        line = text.count("\n", 0, begin)
        change = f"{text[begin:end]!r} -> {other!r}: {text.splitlines()[line].strip()}"
        name = path.relative_to(folder).as_posix()
        if reason := EQUIVALENT.get(f"{name}: {change}"):
            equal += 1
            print(f"{number} equivalent, {reason}: {name}:{line + 1}: {change}", flush=True)
            continue
        path.write_text(text[:begin] + other + text[end:], "utf-8")
        own = [str(test.relative_to(folder)) for test in _named(folder, tests, path.stem)]
        seen = not (_pass(folder, own, "") and all(_pass(folder, tests, kind) for kind in _KINDS))
        path.write_text(text, "utf-8")
        unseen += not seen
        print(f"{number} {'seen' if seen else 'NOT SEEN'} {name}:{line + 1}: {change}", flush=True)
    print(f"{area}: {count - unseen - equal} of {count - equal} changes seen, and {equal} that no test can see")
    return unseen


def _named(folder: Path, tests: Sequence[str], name: str) -> Iterator[Path]:
    """Yields the test files among `tests` that have the name of the changed file: most changes end there."""
    for test in tests:
        path = folder / test
        yield from [path] if path.stem == f"test_{name}" else sorted(path.rglob(f"test_{name}.py"))


def _pass(folder: Path, tests: Sequence[str], kind: str) -> bool:
    return not tests or ((end := _run(folder, tests, kind)) is not None and end.returncode in _FINE)


def _run(folder: Path, tests: Sequence[str], kind: str) -> subprocess.CompletedProcess[str] | None:
    """Runs tests in the copy, of which processes that they start import, too; None where they do not end."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-p", "no:randomly"]
    try:
        return subprocess.run(
            [*command, "-m", kind, *tests],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(folder)},
            capture_output=True,
            text=True,
            timeout=1800,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return None


if __name__ == "__main__":
    main(prog_name="python -m tests.areas")
