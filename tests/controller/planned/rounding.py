"""What a step that differs by 1e-15 moves in flights with the planned controller: `python -m
tests.controller.planned.rounding`.

Tumbles under all errors of scenarios/flight_tumble.yaml, and the scenarios' own flights. About a minute of one core.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import orchestration
from orchestration.results.result import Result

from .core import ROOT

FACTOR = 1.0 + 1e-15
TUMBLES, STEPS = 24, 15000
SETTLED = np.radians(1.0)
_KEPT = ("name", "shared", "blocks", "connections")


@dataclass(frozen=True)
class Apart:
    """Largest differences of two flights over their samples: plan_cost relative to itself, attitude error, rad; and
    whether both are settled at the end."""

    cost: float
    attitude: float
    settled: bool


def flight(scenario: dict[str, Any], step: float, steps: int) -> Result:
    """Blocks and connections of a scenario, flown in other steps, s; a sample of the controller each fifth is
    recorded."""
    kept: dict[str, Any] = {name: scenario[name] for name in _KEPT if name in scenario}
    return orchestration.run({**kept, "step": step, "duration": steps * step, "record": {"interval": 5 * step}})


def apart(a: Result, b: Result) -> Apart:
    n = min(len(a.time), len(b.time))
    cost, other = (np.asarray(r["controller.plan_cost"][:n]) for r in (a, b))
    angle, turned = (np.asarray(r["judge.attitude_error"][:n]) for r in (a, b))
    moved = np.abs(cost - other) / np.maximum(np.abs(cost), 1e-9)
    return Apart(float(moved.max()), float(np.abs(angle - turned).max()), bool(max(angle[-1], turned[-1]) < SETTLED))


def tumble(rng: np.random.Generator, seed: int) -> dict[str, Any]:
    """A tumble of 1.1 to 5.7 deg/s about any axis, anywhere above the Earth, under all errors."""
    scenario: dict[str, Any] = orchestration.load(ROOT / "scenarios" / "flight_tumble.yaml").source.data
    axis = rng.normal(size=3)
    rate = 0.1 * rng.uniform(0.2, 1.0) * axis / np.linalg.norm(axis)
    scenario["blocks"]["plant"]["start"] |= {"omega_B0": rate.tolist(), "node_longitude": float(rng.uniform(0.0, 6.28))}
    scenario["blocks"]["sensors"]["start"]["seed"] = seed
    return scenario


def main() -> None:
    rng = np.random.default_rng(0)
    flights = [
        (name, orchestration.load(ROOT / "scenarios" / f"{name}.yaml").source.data)
        for name in ("flight_tumble", "flight_vb", "flight_vc")
    ]
    flights += [(f"tumble {i}", tumble(rng, i)) for i in range(TUMBLES)]
    print("flight          plan_cost   attitude error, rad   settled")
    for name, scenario in flights:
        moved = apart(flight(scenario, 0.1, STEPS), flight(scenario, 0.1 * FACTOR, STEPS))
        print(f"{name:15} {moved.cost:9.1e} {moved.attitude:21.1e}   {moved.settled}", flush=True)


if __name__ == "__main__":
    main()
