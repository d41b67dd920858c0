"""Which tests run each line of some files: a plugin of pytest for `python -m tests.areas`.

`begin` runs at the start of each process that the tests start, and gives what it runs to the test that started it.
"""

from __future__ import annotations

import ast
import json
import os
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest
from coverage import Coverage, CoverageData

SETTINGS = """
[run]
include = {files}
data_file = {data}/lines
parallel = true
concurrency = thread,multiprocessing
context = ${{PYTEST_CURRENT_TEST-}}
disable_warnings = no-data-collected,module-not-measured,couldnt-parse
"""
BEGIN = "import coverage\ncoverage.process_startup()\n"
"""A `sitecustomize.py` that begins to measure, with the file of settings that COVERAGE_PROCESS_START names."""
_PHASE = re.compile(r" \((?:setup|call|teardown)\)$")


@dataclass(frozen=True)
class Lines:
    """By line of a file the tests that run it, "" for an import; by test its time, s; and those that failed."""

    tests: Mapping[str, Mapping[int, frozenset[str]]]
    times: Mapping[str, float]
    failed: list[str]

    def of(self, file: Path, text: str, line: int) -> tuple[list[str], list[str]]:
        """The tests that run the statement on a line, and the others that run anything of the file, quickest first.

        A statement that runs at import is run by every test of the file; a file that no test runs by all.
        """
        lines = self.tests.get(str(file), {})
        whole = frozenset().union(*lines.values()) - {""} or frozenset(self.times)
        near = frozenset().union(*(lines.get(n, frozenset()) for n in statement(text, line)))
        near = whole if not near or "" in near else near
        return self._ordered(near), self._ordered(whole - near)

    def _ordered(self, tests: Iterable[str]) -> list[str]:
        return sorted(tests, key=lambda test: (self.times[test], test))


def statement(text: str, line: int) -> range:
    """The lines of the smallest statement that a line is of; of one with a body, those of its head."""
    found = range(line, line + 1)
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.stmt) and node.lineno <= line <= (node.end_lineno or node.lineno):
            body = getattr(node, "body", None)
            found = range(node.lineno, max(line + 1, body[0].lineno if body else (node.end_lineno or line) + 1))
    return found


def read(folder: Path) -> Lines:
    """What a run with this plugin has written into a folder."""
    times: Counter[str] = Counter()
    failed = set()
    for test, outcome, duration in map(json.loads, (folder / "times").read_text("utf-8").splitlines()):
        times[test] += duration
        if outcome == "failed":
            failed.add(test)
    passed = times.keys() - failed
    tests: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
    for part in folder.glob("lines.*"):
        data = CoverageData(str(part))
        data.read()
        for file in data.measured_files():
            for line, contexts in data.contexts_by_lineno(file).items():
                for context in contexts:  # of a test's own process, or of one that it started in one of its phases
                    tests[file][line] |= {_PHASE.sub("", context)} & (passed | {""})
    fixed = {file: {line: frozenset(some) for line, some in lines.items() if some} for file, lines in tests.items()}
    return Lines(fixed, {test: times[test] for test in passed}, sorted(failed))


def pytest_runtest_logstart(nodeid: str) -> None:
    measuring = Coverage.current()
    if measuring is not None and "PYTEST_XDIST_WORKER" in os.environ:
        measuring.switch_context(nodeid)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if "PYTEST_XDIST_WORKER" not in os.environ:
        with (Path(os.environ["COVERED"]) / "times").open("a", encoding="utf-8") as file:
            file.write(json.dumps([report.nodeid, report.outcome, report.duration]) + "\n")


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish() -> None:
    measuring = Coverage.current()
    if measuring is not None:
        measuring.save()
