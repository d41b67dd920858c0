"""Which tests pass, as pytest says it, and which of them run the C of a block."""

from __future__ import annotations

import ast
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path

Passed = dict[str, set[str]]
"""By file, from the root: the tests of which each case passed, and none was skipped."""


def passed(files: Iterable[str], root: Path) -> Passed:
    """Runs these files of tests."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder, "tests.xml")
        command = [sys.executable, "-m", "pytest", "-q", "-n", "auto", "-p", "no:cacheprovider", f"--junitxml={report}"]
        subprocess.run([*command, *files], cwd=root, check=False, capture_output=True)
        cases = list(ET.parse(report).iter("testcase")) if report.exists() else []
    good, bad = defaultdict[str, set[str]](set), defaultdict[str, set[str]](set)
    for case in cases:
        file = case.get("classname", "").replace(".", "/") + ".py"
        (bad if len(case) and {c.tag for c in case} & {"failure", "error", "skipped"} else good)[file].add(
            case.get("name", "").partition("[")[0]
        )
    return {file: names - bad[file] for file, names in good.items()}


def runs_c(path: Path, root: Path) -> bool:
    """Returns whether the file, or a module here that it imports, calls a library by ctypes or flies FMUs."""
    return any(
        module == "ctypes" or (module == "orchestration" and "run" in names)
        for _, imports in reached(path, root)
        for module, names in imports
    )


def reached(path: Path, root: Path) -> Iterator[tuple[Path, list[tuple[str, list[str]]]]]:
    """The file and those in `root` that it imports, and they in turn; each with its imports: module and names."""
    left, seen = [path], set[Path]()
    while left:
        one = left.pop()
        if one in seen or not one.is_file():
            continue
        seen.add(one)
        imports = list(_imports(one, root))
        yield one, imports
        for module, names in imports:
            at = root.joinpath(*module.split("."))
            left += [at.with_suffix(".py"), *(at / f"{name}.py" for name in names)]


def _imports(path: Path, root: Path) -> Iterator[tuple[str, list[str]]]:
    """Returns for each import the module, in full, and the names taken from it."""
    package = path.relative_to(root).parts[:-1]
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, []) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else ()
            yield ".".join([*above, *([node.module] if node.module else [])]), [a.name for a in node.names]
