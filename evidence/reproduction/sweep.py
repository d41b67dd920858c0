"""How the claims depend on what the paper leaves open: sweeps of the whole loop in the mass-normalised reading.
Tests: tests/evidence/reproduction/test_claims.py."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from design.loop import read
from plant.orbit import lvlh

from ..crew import Crew
from ..paper import DURATION, INERTIA, MASS, ORBIT, READINGS, SCENARIOS, STEP, Array, constants, node
from ..samples import wrong_inertias
from .claims import all_hold
from .runs import sweep
from .seen import Seen

NODES = np.arange(0.0, 360.0, 5.0)
K_SCALES = np.round(np.arange(0.20, 1.5001, 0.05), 3)


@dataclass(frozen=True)
class Constant:
    """Something that the paper does not give, and what is tried for it."""

    name: str
    taken: str
    unit: str
    nominal: float
    values: Array
    change: Callable[[float], dict[str, Any]]
    """Start values for one of them."""


def _bend(value: float) -> dict[str, Any]:
    return {"controller.phi": "logarithm", "controller.phi_scale": value}


def _scales(low: float, high: float) -> Array:
    return np.round(np.arange(low, high + 0.005, 0.01), 3)


DRAG = 1.0 / MASS
"""The factor on drag that is taken, per unit of mass."""
ONE_BY_ONE = tuple(
    Constant(*row)
    for row in (
        ("node longitude", "158° E (Earth-fixed, at t = 0)", "°", 158.0, np.arange(0.0, 360.0), node),
        (
            "K₀'s scale",
            "0.65 N m (before the division by 50)",
            "N m",
            0.65,
            _scales(0.2, 1.5),
            lambda v: constants(k=v),
        ),
        (
            *("spread of K₀", "K₀ = 0.65 diag(1 − 0.1, 1, 1 + 0.1)", "", 0.1, _scales(0.01, 0.49)),
            lambda v: constants(spread=v),
        ),
        (
            *("L₀'s scale", "0.9 N m s (before the division by 50)", "N m s", 0.9, _scales(0.4, 1.6)),
            lambda v: constants(l=v),
        ),
        ("mass that divides", "50 kg (“about 50 kg”)", "kg", 50.0, np.arange(20.0, 101.0), lambda v: constants(mass=v)),
        (
            *("orbit radius", "6971 km (6371 + 600)", "km", 6971.0, np.arange(6940.0, 7002.0)),
            lambda v: {"plant.orbit_radius": 1e3 * v},
        ),
        (
            *("year (10 August)", "2009", "", 2009.0, np.arange(2005.0, 2016.0)),
            lambda v: {"plant.epoch": f"{int(v)}-08-10T00:00:00Z"},
        ),
        ("bend of Φ", "Φ(x) = x; here s ln(1 + x/s) with s in J", "J", math.inf, np.logspace(-4.0, 0.0, 41), _bend),
        (
            *("factor on drag", "1 (C_d 2.2, F10.7 = 70)", "", 1.0, np.logspace(-1.0, 4.0, 51)),
            lambda v: {"plant.drag_factor": DRAG * v},
        ),
    )
)


def one_by_one(hands: Crew) -> dict[str, list[Seen]]:
    """Each constant swept alone; in the order of ONE_BY_ONE."""
    found: dict[str, list[Seen]] = {w: [] for w in SCENARIOS}
    for i, c in enumerate(ONE_BY_ONE):
        for w, seen in _both(hands, f"constant_{i + 1}", [c.change(float(v)) for v in c.values]).items():
            found[w].append(seen)
    return found


def node_and_gain(hands: Crew) -> dict[str, Seen]:
    """Every node longitude with every scale of K0; rows K_SCALES, columns NODES, flattened."""
    return _both(hands, "node_and_K0", [constants(k=float(k)) | node(x) for k in K_SCALES for x in NODES])


def si_for_an_orbit(hands: Crew) -> dict[str, Seen]:
    """SI units and the real limits, a whole orbit from 24 nodes."""
    changes = [{**READINGS["c"].changes, **node(x)} for x in range(0, 360, 15)]
    return _both(hands, "SI_for_an_orbit", changes, STEP, ORBIT)


def latch(hands: Crew, k: float, l: float) -> Seen:  # noqa: E741
    """V.C at node longitudes 1 deg apart with gains of these scales."""
    return sweep(hands, f"latch_{k:g}_{l:g}", "V.C", [constants(k=k, l=l) | node(x) for x in range(360)])


def _both(
    hands: Crew, name: str, changes: Sequence[Mapping[str, Any]], step: float = STEP, duration: float = DURATION
) -> dict[str, Seen]:
    """Flies both manoeuvres with each of the changes."""
    return {which: sweep(hands, name, which, changes, step, duration) for which in SCENARIOS}


def interval(constant: Constant, which: str, seen: Seen) -> tuple[float, float] | None:
    """Ends of the values around the nominal one for which every claim holds.

    None where the nominal itself does not hold every claim.
    """
    good = all_hold(which, seen)
    at = len(good) - 1 if math.isinf(constant.nominal) else int(np.abs(constant.values - constant.nominal).argmin())
    if not good[at]:
        return None
    n, circle = len(good), constant.unit == "°"

    def end(step: int) -> int:
        i = at
        while (circle or 0 <= i + step < n) and good[(i + step) % n] and abs(i + step - at) < n:
            i += step
        return i

    return float(constant.values[end(-1) % n]), float(constant.values[end(1) % n])


# ---------------------------------------------------------------- robustness

DRAG_FACTORS = np.logspace(-1.0, 4.0, 26)


def drag(hands: Crew) -> dict[str, Seen]:
    """The moment of drag, which the law does not know, times DRAG_FACTORS."""
    return _both(hands, "drag", [{"plant.drag_factor": 0.02 * float(f)} for f in DRAG_FACTORS])


def drag_moments(which: str) -> Array:
    """Norm of that moment at the end of the run in the LVLH attitude, in SI units, N m, for DRAG_FACTORS."""
    p = read(SCENARIOS[which]).loop.plant
    v_N, density = p.air.flow(DURATION)
    one = p.surface.moment(lvlh(*p.orbit.position_velocity(DURATION)).T @ v_N, density)
    return DRAG_FACTORS * float(np.linalg.norm(one)) / p.drag_factor


def inertia_errors(hands: Crew, n: int = 200, seed: int = 2, size: float = 0.1) -> dict[str, Seen]:
    """The body's inertia off what the law knows; the law keeps its own."""
    J = np.diag(INERTIA) / MASS
    changes = [{"plant.J_error_B": (body - J).tolist()} for body in wrong_inertias(J, n, seed, size)]
    return _both(hands, "inertia", changes)
