"""Runs the study on the records of a folder; prints its figures, and draws and writes the page."""

from __future__ import annotations

import csv
import json
from pathlib import Path

from ..markdown import render
from ..paper import ROOT
from ..plots import save
from .page import PART, fields, figure, part
from .told import lines
from .whole import study

FIGURE = "flight-data"


def make(folder: Path, cases: int, jobs: int, page: bool) -> list[str]:
    """Returns the figures in text, and writes picture and JSON to results/flight_data, or page and picture to docs."""
    done = study(folder, cases, jobs, page)
    told = lines(done)
    out = ROOT / "results" / "flight_data"
    if page:
        save({FIGURE: figure(done)}, ROOT / "docs" / "figures")
        text = render(Path(__file__).parent, **fields(done))
        (ROOT / "docs" / "evidence" / "flight_data.md").write_text(text, "utf-8")
        with (ROOT / "docs" / "evidence" / "flight_data.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([PART, *map(part, done.cuts)])
        return [*told, "written: docs/evidence/flight_data.md and flight_data.csv"]
    save({FIGURE: figure(done)}, out)
    (out / "figures.json").write_text(json.dumps(told, indent=1), "utf-8")
    return [*told, f"written: {out}"]
