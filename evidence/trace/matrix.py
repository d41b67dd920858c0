"""The matrix of requirements: which code, tests, scenarios and proofs name each, as a page, a table and ReqIF.

An id stands in a docstring or comment. A requirement needs code, and a test or a proof.
"""

from __future__ import annotations

import csv
import html
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from orchestration import InputError

from ..paper import ROOT
from . import reqif

FILE = Path(__file__).with_name("requirements.yaml")
OUT = ROOT / "out" / "trace"
KINDS = {
    "code": (
        *("allocator", "controller", "estimator", "supervisor", "fmus/native", "evidence/proofs"),
        *("orchestration/instances/record", "design/review"),
    ),
    "tests": ("tests",),
    "scenarios": ("scenarios",),
    "proofs": ("evidence/proofs",),
}
"""Folders in which an id is evidence of this kind."""
_NAMES = {"code": (".py", ".c", ".h"), "tests": (".py",), "scenarios": (".yaml",), "proofs": (".py",)}


@dataclass
class Requirement:
    """A requirement, its source, and the files that name it, by kind of evidence."""

    id: str
    text: str
    source: str
    evidence: dict[str, list[str]] = field(default_factory=lambda: {kind: [] for kind in KINDS})

    @property
    def lacks(self) -> str:
        """What is missing; empty where nothing is."""
        if not self.evidence["code"]:
            return "code"
        return "" if self.evidence["tests"] or self.evidence["proofs"] else "a test or a proof"


def requirements(file: Path = FILE) -> dict[str, Requirement]:
    """Those of the file, by id. Raises InputError where two have one id."""
    entries = yaml.safe_load(file.read_text("utf-8"))
    known = {e["id"]: Requirement(**e) for e in entries}
    if len(known) < len(entries):
        raise InputError(f"{file.name}: an id stands twice")
    return known


def matrix(known: dict[str, Requirement], root: Path = ROOT) -> tuple[list[Requirement], list[str]]:
    """The requirements with their evidence, and `file: id` of each id that is no requirement's."""
    prefixes = "|".join(sorted({id_.partition("-")[0] for id_ in known}))
    named = re.compile(rf"\b(?:{prefixes})-\d+\b")
    strangers = []
    for kind, path in _files(root):
        for id_ in sorted(set(named.findall(path.read_text("utf-8")))):
            name = path.relative_to(root).as_posix()
            if id_ in known:
                known[id_].evidence[kind].append(name)
            elif f"{name}: {id_}" not in strangers:
                strangers.append(f"{name}: {id_}")
    return list(known.values()), strangers


def _files(root: Path) -> Iterator[tuple[str, Path]]:
    for kind, folders in KINDS.items():
        for folder in folders:
            for path in sorted((root / folder).rglob("*")):
                if path.suffix in _NAMES[kind] and "trace" not in path.parts:
                    yield kind, path


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
    rows, strangers = matrix(requirements())
    page = write(rows)
    wrong = [f"{r.id}: {r.text} lacks {r.lacks}" for r in rows if r.lacks]
    wrong += [f"{stranger}: no such requirement in {FILE.name}" for stranger in strangers]
    if wrong:
        raise InputError("\n".join(wrong))
    return page
