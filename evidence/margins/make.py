"""Measures margins along the orbit, the equilibria of the paper's law and the changes that lose V.B, for
docs/evidence/margins.md.

Tests: tests/evidence/margins/test_make.py.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any

import numpy as np

from orchestration.fmu.model import Element
from orchestration.margins.inject import Altered, Rig
from orchestration.margins.search import Change, lost, pulse_dies_out
from orchestration.system.wiring import Node

from ..paper import ROOT
from .cases import (
    CASES,
    PLANNED,
    USUAL,
    along_orbit,
    at_place,
    equilibrium,
    multiplied,
    multipliers,
    opened,
    whole_orbit,
)

KEPT = ROOT / "docs" / "evidence" / "margins.json"
LONG, DELAYS = 2000, (7.0, 8.0, 10.0)
"""Samples of 0.5 s that the planned hold flies with a delay, and delays, s."""
GAINS = ("plant.J_B", "controller.bandwidth")
"""Parameters whose effect on the largest multiplier of an orbit is measured."""
TURNS = (1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)
CHANGES = ("delay=0..20", "gain=1..0.02", "plant.J_B=1..30", "plant.rod_gain=1..0.05")


def searched() -> list[dict[str, Any]]:
    """Returns what loses the hold of V.B."""
    session, rig = opened(CASES["V.B, paper's law"], 0)
    with session:
        made = [lost(rig, Change.of(text), pulse_dies_out(rig, 6000)) for text in CHANGES]
    return [one.data() for one in made]


def lost_by_delay(place: int = 0) -> dict[str, Any]:
    """Returns between which delays, s, the planned hold is lost in flights, and the multipliers with these delays."""
    session, rig = opened(CASES[PLANNED], place)
    with session:
        found = {d: multipliers(multiplied(rig, delay=d)) for d in DELAYS}
        flown = {d: _worst_error(rig, d) for d in DELAYS}
    return {"delays": list(DELAYS), "multipliers": list(found.values()), "errors": list(flown.values())}


def _worst_error(rig: Rig, delay: float) -> float:
    """Returns the largest attitude error, deg, with a delay at the actuators."""
    plan = rig.session.opened.plan
    node = Node("judge", Element("attitude_error", 0))
    peak = _Peak(node)
    still = np.zeros((LONG, len(rig.site.channels)))
    rig.fly(still, Altered(delay=round(delay / plan.clock.step)), [peak], [node])
    return math.degrees(peak.largest)


class _Peak:
    """An observer that keeps the largest value of a node."""

    def __init__(self, node: Node) -> None:
        self._node, self.largest = node, 0.0

    def see(self, time: Any, values: Mapping[Node, Any]) -> None:
        self.largest = max(self.largest, float(np.max(values[self._node])))


def make(jobs: int, cases: Sequence[str], places: Sequence[int]) -> None:
    """Measures these cases and keeps them beside those that are kept already, each as soon as it is measured."""
    kept = json.loads(KEPT.read_text("utf-8")) if KEPT.exists() else {"places": []}
    rows = {(row["case"], row["place"]): row for row in kept["places"] if row["case"] in CASES}
    with ProcessPoolExecutor(jobs) as pool:
        waits: dict[Any, Any] = {pool.submit(along_orbit, name): None for name in cases if CASES[name].reason}
        once = [name for name in cases if not CASES[name].reason]
        waits |= {pool.submit(at_place, name, place): None for name in once for place in places}
        if set(cases) == set(CASES):
            waits |= {pool.submit(equilibrium, turn, place): "equilibria" for turn in TURNS for place in places[::2]}
            waits |= {pool.submit(searched): "changes", pool.submit(lost_by_delay): "delay"}
            waits |= {pool.submit(whole_orbit, PLANNED): "orbits", pool.submit(whole_orbit, USUAL, GAINS): "orbits"}
            kept |= {"equilibria": [], "orbits": []}
        for done in as_completed(waits):
            key, result = waits[done], done.result()
            if key is None:
                rows |= {(row["case"], row["place"]): row for row in result}
                kept["places"] = [rows[at] for at in sorted(rows)]
            elif isinstance(kept.get(key), list) and key != "changes":
                kept[key].append(result)
            else:
                kept[key] = result
            KEPT.write_text(json.dumps(kept, indent=1) + "\n", "utf-8")
