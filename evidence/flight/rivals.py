"""The planned controller, the paper's law and a law from the literature on the same nominal tumbles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .. import markdown
from ..crew import crew
from ..paper import FOLDER
from .cases import SEEDS, tumbles
from .kept import Flights, angle, lines, quantile

NAMES = {
    "planned": "`controller_planned`",
    "tuned": "law [8], tuned",
    "literature": "non-monotonic detumbling, then a proportional-derivative law",
}


def compare(cases: int, jobs: int) -> Iterator[str]:
    """A table in Markdown: a line for each scheme. Flights of three orbits, judged as in docs/evidence/flight.md."""
    rows = []
    with crew(jobs) as hands:
        for scheme, name in NAMES.items():
            group = tumbles(f"rival {scheme}", SEEDS["nominal"], cases, scheme=scheme)
            flown = hands.fly(group.case, FOLDER / "flight")
            flights = Flights(tuple(lines(group, flown, [None] * len(flown))))
            times = flights.times(group.name)
            shown = [markdown.orbits(quantile(times, q)) for q in (0.5, 1.0)]
            rows.append([name, markdown.finite(times), *shown, angle(flights.hold_errors(group.name), np.median)])
    yield markdown.table(rows, "controller|settled|half by, orbits|all by|hold rms, median")
