"""The tables of docs/evidence/failures.md from docs/evidence/failures.csv; page.md.j2 has the words."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from .. import markdown
from ..flight.cases import LOST
from ..flight.kept import angle, quantile
from ..markdown import degrees, finite
from ..paper import ORBIT, Array
from .kept import Flight
from .rows import OTHERS, RODS, ROWS, SENSORS, UNSEARCHED, WHEEL, Row

SOON = 1.5
"""Orbits, by which a flight by rods alone is to be below LOST for good."""
QUICK, LITTLE = 100.0, 0.2
"""s, deg: sensors of which each flight is detected within the one and held within the other share a sentence."""


def text(flights: Sequence[Flight]) -> str:
    """Returns the page."""
    of = {row.name: [f for f in flights if f.row == row.name] for row in ROWS}
    columns = {RODS: _rod, OTHERS: _other, SENSORS: _sensor, WHEEL: _wheel}
    tables = (*columns, UNSEARCHED)
    rows = {table: [(row, of[row.name]) for row in ROWS if row.table == table and of[row.name]] for table in tables}
    soon = [(row, them) for row, them in rows[SENSORS] if _is_soon(them)]
    rows[SENSORS] = [it for it in rows[SENSORS] if it not in soon]
    searched = [f for row in ROWS if row.table != UNSEARCHED for f in of[row.name]]
    failing = [f for row, them in rows[RODS] + rows[OTHERS] for f in them]
    return markdown.render(
        Path(__file__).parent,
        **{
            table: [column(row, them) for row, them in (_joined(rows[table]) if table == RODS else rows[table])]
            for table, column in columns.items()
        },
        unsearched="; ".join(_unsearched(row, them) for row, them in _joined(rows[UNSEARCHED])),
        soon=_soon(soon) if soon else None,
        flown=len(flights),
        found=finite(_column(failing, "found_s")),
        settled=finite(_column(failing, "settled_s")),
        wrong=sum(bool(f.others) for f in searched),
        failed=[f"{f.row}, flight {f.run}: {f.remark}" for f in flights if f.remark],
    )


def _joined(rows: Sequence[tuple[Row, list[Flight]]]) -> list[tuple[Row, list[Flight]]]:
    """Returns the rows with those of the three rods joined."""
    of: dict[tuple[str, float], tuple[Row, list[Flight]]] = {}
    for row, flights in rows:
        text = re.sub(r"^rod \d", "a rod", row.text)
        of.setdefault((text, row.push), (replace(row, text=text), []))[1].extend(flights)
    return list(of.values())


def _under(row: Row) -> str:
    """The failure, with the disturbance under which it is flown."""
    return f"{row.text}, {1e6 * row.push:.3g} µN m" if row.push else row.text


def _column(flights: Sequence[Flight], name: str) -> Array:
    return np.array([getattr(flight, name) for flight in flights])


def _found(times: Array) -> str:
    """Returns how many, the median and the worst of those, s."""
    known = times[np.isfinite(times)]
    return ", ".join([finite(times), *(f"{which(known):.0f} s" for which in (np.median, np.max) if len(known))])


def _hold(flights: Sequence[Flight]) -> str:
    """Returns the rms at the median, and the largest angle."""
    rms, largest = (_column(flights, name) for name in ("hold_rms_deg", "hold_max_deg"))
    known = np.isfinite(rms)
    return f"{angle(rms[known], np.median)}, {angle(largest[known], np.max)}"


def _rod(row: Row, flights: Sequence[Flight]) -> list[str]:
    settled = finite(_column(flights, "settled_s"))
    return [_under(row), _found(_column(flights, "found_s")), settled, _hold(flights)]


def _other(row: Row, flights: Sequence[Flight]) -> list[str]:
    times = _column(flights, "settled_s")
    settled = f"{finite(times)}, {quantile(times, 0.5):,.0f} s"
    return [row.text, _found(_column(flights, "found_s")), settled, _hold(flights)]


def _is_soon(flights: Sequence[Flight]) -> bool:
    found, largest = (_column(flights, name) for name in ("found_s", "hold_max_deg"))
    return bool((found <= QUICK).all() and (largest <= LITTLE).all())


def _soon(rows: Sequence[tuple[Row, list[Flight]]]) -> dict[str, str]:
    """Returns what the sentence says of these rows."""
    flights = [f for _, them in rows for f in them]
    return {
        "latest": f"{max(f.found_s for f in flights):.0f} s",
        "rms": degrees(max(np.median(_column(them, "hold_rms_deg")) for _, them in rows)),
        "largest": degrees(max(f.hold_max_deg for f in flights)),
        "names": "; ".join(row.text for row, _ in rows),
    }


def _sensor(row: Row, flights: Sequence[Flight]) -> list[str]:
    held = (_column(flights, "hold_max_deg") < LOST).sum()
    return [row.text, _found(_column(flights, "found_s")), f"{held} of {len(flights)}", _hold(flights)]


def _unsearched(row: Row, flights: Sequence[Flight]) -> str:
    return f"{_under(row)}: {finite(_column(flights, 'settled_s'))}"


def _wheel(row: Row, flights: Sequence[Flight]) -> list[str]:
    soon = np.where((times := _column(flights, "within_5_s")) <= SOON * ORBIT, times, math.inf)
    found, within = _found(_column(flights, "found_s")), finite(_column(flights, "within_15_s"))
    return [_under(row), found, within, finite(soon), _hold(flights)]
