"""Measures margins along the orbit, the equilibria of the paper's law and the changes that lose V.B, for
docs/evidence/margins.md.

Tests: tests/evidence/margins/test_make.py.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any

from orchestration.margins.search import Change, lost, pulse_dies_out

from ..paper import ROOT
from .cases import CASES, VB, along_orbit, at_place, delayed, equilibrium, opened

KEPT = ROOT / "docs" / "evidence" / "margins.json"
WATCH, IDENTIFY = "controller.find_failures", "controller.identify"
DELAYS = {
    "as it is": ({}, (7.0, 7.4)),
    "no watch for failed rods": ({WATCH: False}, (7.0, 8.0, 8.5)),
    "no watch, no identification": ({WATCH: False, IDENTIFY: False}, (10.0, 14.0)),
}
"""Delays at the actuators of the planned hold, s, as it is and with parts of its controller off."""
TURNS = (1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)
CHANGES = ("delay=0..20", "gain=1..0.02", "plant.J_B=1..30", "plant.rod_gain=1..0.05")


def searched() -> list[dict[str, Any]]:
    """Returns what loses the hold of V.B."""
    session, rig = opened(CASES[VB], 0)
    with session:
        made = [lost(rig, Change.of(text), pulse_dies_out(rig, 6000)) for text in CHANGES]
    return [one.data() for one in made]


def make(jobs: int, cases: Sequence[str], places: Sequence[int], missing: bool = False) -> None:
    """Measures these cases and keeps them beside those that are kept already, each as soon as it is measured.

    With `missing` only what is not kept yet, so that a run that was stopped can go on."""
    kept = json.loads(KEPT.read_text("utf-8")) if KEPT.exists() else {}
    rows = {(row["case"], row["place"]): row for row in kept.get("places", []) if row["case"] in CASES}
    if not missing:
        rows = {at: row for at, row in rows.items() if at[0] not in cases}
        kept = {"places": []} if set(cases) == set(CASES) else kept
    with ProcessPoolExecutor(jobs) as pool:
        waits: dict[Any, Any] = {}
        for name in cases:
            wanted = [place for place in places if (name, place) not in rows]
            if CASES[name].followed:
                waits |= {pool.submit(along_orbit, name): None} if wanted else {}
            else:
                waits |= {pool.submit(at_place, name, place): None for place in wanted}
        if set(cases) == set(CASES):
            done_ = {(row["name"], row["delay"]) for row in kept.setdefault("delays", [])}
            for name, (values, delays) in DELAYS.items():
                for delay in delays:
                    if (name, delay) not in done_:
                        waits[pool.submit(delayed, values, delay)] = "delays", name
            turns = [tuple(one["turn"]) for one in kept.setdefault("equilibria", [])]
            waits |= {pool.submit(equilibrium, turn): ("equilibria", "") for turn in TURNS if turn not in turns}
            waits |= {pool.submit(searched): ("changes", "")} if "changes" not in kept else {}
        for done in as_completed(waits):
            key, result = waits[done], done.result()
            if key is None:
                rows |= {(row["case"], row["place"]): row for row in result}
                kept["places"] = [rows[at] for at in sorted(rows)]
            elif key[0] == "changes":
                kept["changes"] = result
            else:
                kept[key[0]].append({"name": key[1], **result} if key[1] else result)
            KEPT.write_text(json.dumps(kept, indent=1) + "\n", "utf-8")
