"""docs/evidence/verification.md from docs/evidence/verification.csv, which the tests' authorities write.
Tests: tests/evidence/verification/test_cost.py."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .. import files, markdown
from ..paper import ROOT
from ..plots import save
from . import cost

FILE = ROOT / "docs" / "evidence" / "verification.csv"


@dataclass(frozen=True)
class Line:
    """One comparison: found must lie within the tolerance of expected."""

    subject: str
    what: str
    unit: str
    expected: float
    found: float
    tolerance: float
    source: str
    function: str

    @property
    def share(self) -> float:
        """The difference over its tolerance."""
        return abs(self.found - self.expected) / self.tolerance


def row(subject: str, lines: Sequence[Line]) -> list[str]:
    """A subject as the page shows it."""
    return [subject, f"{len(lines)}", f"{max(line.share for line in lines):.2f}"]


def write() -> Path:
    """Writes the page and its figure, for which it flies the plant and RK4 for some minutes; returns the page."""
    lines = files.load(Line, FILE, "python -m tests.authorities")
    errors, structure = cost.errors_after_an_orbit(), cost.structure_over_ten_orbits()
    save({"integrator_cost": cost.figure(errors, structure)}, ROOT / "docs" / "figures")
    at = {order: cost.at(points, cost.COST) for order, points in errors.items()}
    subjects = dict.fromkeys(line.subject for line in lines)
    target = FILE.with_suffix(".md")
    text = markdown.render(
        Path(__file__).parent,
        count=len(lines),
        within=sum(line.share <= 1.0 for line in lines),
        subjects=[row(subject, [line for line in lines if line.subject == subject]) for subject in subjects],
        methods=cost.table(errors, structure),
        better=[f"{at[order] / at[0]:.3g}" for order in (2, 4)],
    )
    target.write_text(text, "utf-8")
    return target
