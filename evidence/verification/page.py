"""docs/evidence/verification.md from docs/evidence/verification.csv, which the tests' authorities write.
Tests: tests/evidence/verification/test_cost.py."""

from __future__ import annotations

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
    def row(self) -> list[str]:
        """The line as the page shows it."""
        unit = f" {self.unit}" if self.unit else ""
        found = f"{self.found:.7g}{unit}" if self.expected else f"{self.found:.2g}{unit}"
        return [
            self.what,
            f"{self.expected:.7g}{unit}" if self.expected else "",
            found,
            f"{self.tolerance:g}",
            self.source,
        ]


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
        within=sum(abs(line.found - line.expected) <= line.tolerance for line in lines),
        subjects={subject: [line.row for line in lines if line.subject == subject] for subject in subjects},
        methods=cost.table(errors, structure),
        better=[f"{at[order] / at[0]:.3g}" for order in (2, 4)],
    )
    target.write_text(text, "utf-8")
    return target
