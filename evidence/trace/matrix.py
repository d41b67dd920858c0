"""The matrix of requirements: which code, tests, scenarios and proofs name each, as a page, a table and ReqIF.

Code says `Requirement: CT-1.`, evidence `Shows CT-1.`: in a docstring, or in the comment at the head of C and YAML.
Any other mention counts for nothing. `make trace` runs the tests that say so: what does not pass, or is skipped, is no
evidence, nor is a module where one of its tests is such. That of a proof counts where the proofs' make.py imports it,
that of C where there is a function or a value. A requirement on what flies needs C, and a proof or a test that runs C.
"""

from __future__ import annotations

import ast
import csv
import html
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from orchestration import InputError

from ..paper import ROOT
from ..tools import without_comments
from . import reqif
from .ran import Passed, passed, reached, runs_c

FILE = Path(__file__).with_name("requirements.yaml")
OUT = ROOT / "out" / "trace"
_FLIGHT = ("allocator", "controller", "estimator", "supervisor", "fmus/native", "fmus/link/native")
KINDS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "code in C": (_FLIGHT, ("*.c", "*.h")),
    "code in Python": ((*_FLIGHT[:5], "orchestration/instances/record", "design/review"), ("*.py",)),
    "tests": (("tests",), ("test_*.py",)),
    "scenarios": (("scenarios",), ("*.yaml",)),
    "proofs": (("evidence/proofs",), ("*.py",)),
}
"""Folders and files in which an id is evidence of this kind."""
_CODE = {"c": "code in C", "python": "code in Python"}
_IDS = r"[A-Z]{2}-\d+(?:, [A-Z]{2}-\d+)*"


@dataclass
class Requirement:
    """A requirement, its source, and the files that name it, by kind of evidence."""

    id: str
    text: str
    source: str
    code: str = "c"
    """What has to name it: `c`, `python`, or `all` the flight code, which names it nowhere."""
    evidence: dict[str, list[str]] = field(default_factory=lambda: {kind: [] for kind in KINDS})
    of_c: bool = False
    """Whether one of the tests runs C."""

    @property
    def lacks(self) -> str:
        """Names of what is missing."""
        if self.code != "all" and not self.evidence[_CODE[self.code]]:
            return _CODE[self.code]
        if not (self.evidence["tests"] or self.evidence["proofs"]):
            return "a test or a proof"
        return "" if self.code != "c" or self.of_c or self.evidence["proofs"] else "a test that runs C"


def requirements(file: Path = FILE) -> dict[str, Requirement]:
    """Those of the file, by id. Raises InputError where two have one id."""
    entries = yaml.safe_load(file.read_text("utf-8"))
    known = {e["id"]: Requirement(**e) for e in entries}
    if len(known) < len(entries):
        raise InputError(f"{file.name}: an id stands twice")
    return known


def matrix(
    known: dict[str, Requirement], root: Path = ROOT, good: Passed | None = None
) -> tuple[list[Requirement], list[str]]:
    """The requirements with their evidence, and `file: id` of each id that is no requirement's.

    `good`: the tests that passed; None: all that there are.
    """
    strangers = []
    for kind, (folders, names) in KINDS.items():
        for path in _files(root, folders, names):
            name = path.relative_to(root).as_posix()
            named = _named(kind, path, None if good is None else good.get(name, set()))
            of_c = kind == "tests" and bool(named) and runs_c(path, root)
            for id_ in sorted(named):
                if id_ in known:
                    known[id_].evidence[kind].append(name)
                    known[id_].of_c |= of_c
                else:
                    strangers.append(f"{name}: {id_}")
    return list(known.values()), strangers


def _files(root: Path, folders: Sequence[str], names: Sequence[str]) -> Iterator[Path]:
    found = {path for folder in folders for name in names for path in (root / folder).rglob(name)}
    if folders == KINDS["proofs"][0]:
        found &= {file for file, _ in reached(root / folders[0] / "make.py", root)}
    yield from sorted(path for path in found if "trace" not in path.parts)


def _named(kind: str, path: Path, good: set[str] | None) -> set[str]:
    """The ids that a file says it fulfils or shows."""
    word = r"Requirements?:" if kind.startswith("code") else "Shows"
    texts = _docstrings(path, good) if path.suffix == ".py" else _head(path)
    said = re.compile(rf"(?:^|[ *]){word} ({_IDS})\.(?:\s|$)", re.MULTILINE)
    return {id_ for text in texts for ids in said.findall(text) for id_ in ids.split(", ")}


def _head(path: Path) -> Iterator[str]:
    """The comment at the head of a file of C that has more, or the comment before a scenario's first key."""
    text = path.read_text("utf-8")
    is_c = path.suffix in (".c", ".h")
    if is_c and not re.search(r"[;}]", re.sub(r"#[^\n]*", "", without_comments(path))):
        return
    if found := re.match(r"/\*.*?\*/" if is_c else r"(?:#[^\n]*\n)+", text, re.DOTALL):
        yield found[0].replace("*/", "\n")


def _docstrings(path: Path, good: set[str] | None) -> Iterator[str]:
    """Of the module, its classes and functions; in a file of tests of those that passed, and of the module where all
    did."""
    tree = ast.parse(path.read_text("utf-8"))
    parts = [node for node in ast.walk(tree) if isinstance(node, (ast.ClassDef, ast.FunctionDef))]
    if path.name.startswith("test_"):
        tests = [n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name.startswith("test_")]
        parts = [node for node in tests if good is None or node.name in good]
        if not parts or len(parts) < len(tests):
            tree.body = tree.body[1:]  # without its docstring
    yield from (text for node in (tree, *parts) if (text := ast.get_docstring(node)))


def write(rows: Sequence[Requirement], folder: Path = OUT) -> Path:
    """trace.csv, trace.html and trace.reqif in the folder; returns the page."""
    folder.mkdir(parents=True, exist_ok=True)
    head = ["id", "text", "source", *KINDS, "lacks"]
    cells = [[r.id, r.text, r.source, *("; ".join(r.evidence[kind]) for kind in KINDS), r.lacks] for r in rows]
    with (folder / "trace.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([head, *cells])
    reqif.write(head, cells, folder / "trace.reqif")
    body = "\n".join("<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in row) + "</tr>" for row in cells)
    page = folder / "trace.html"
    page.write_text(
        "<!doctype html><html lang='en'><meta charset='utf-8'><title>Requirements</title>"
        "<style>body{font:14px sans-serif}td,th{border:1px solid "
        "#bbb;padding:4px;vertical-align:top}table{border-collapse:collapse}</style>"
        f"<h1>Requirements and their "
        f"evidence</h1><table><tr>{''.join(f'<th>{h}</th>' for h in head)}</tr>{body}</table></html>\n",
        "utf-8",
    )
    return page


def make() -> Path:
    """Writes the matrix. Raises InputError where a requirement lacks evidence, or evidence a requirement."""
    written, _ = matrix(requirements())
    rows, strangers = matrix(requirements(), good=passed({file for r in written for file in r.evidence["tests"]}, ROOT))
    page = write(rows)
    wrong = [f"{r.id}: {r.text} lacks {r.lacks}" for r in rows if r.lacks]
    wrong += [f"{stranger}: no such requirement in {FILE.name}" for stranger in strangers]
    if wrong:
        raise InputError("\n".join(wrong))
    return page
