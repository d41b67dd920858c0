"""Flies the classes and tells what becomes of each."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..crew import crew
from ..paper import FOLDER
from .classes import CLASSES, settled, tumbles


def lines(cases: int, jobs: int) -> Iterator[str]:
    """A table in Markdown: a line for each class, nominal and under all errors."""
    yield "| class | | settled | median, s | worst, s | hold rms, median | worst |"
    yield "|---|---|---|---|---|---|---|"
    with crew(jobs) as hands:
        for name in CLASSES:
            for errors in (False, True):
                rows = hands.fly(tumbles(name, cases, errors).case, FOLDER / "satellites")
                times = settled(rows.numbers("angle_5"), rows.numbers("rate"))
                well = np.isfinite(times)
                hold = np.degrees(rows.numbers("hold_rms")[well])
                figures = (
                    [f"{f(x):.3g}" for x in (times[well], hold) for f in (np.median, np.max)]
                    if well.any()
                    else ["–"] * 4
                )
                kind = "errors" if errors else "nominal"
                yield "| " + " | ".join([name, kind, f"{well.sum()} of {len(times)}", *figures]) + " |"
