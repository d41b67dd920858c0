"""Claims and outcomes of runs, and of made-up figures."""

import math
from dataclasses import fields

import numpy as np
import pytest

from evidence.paper import node
from evidence.reproduction.claims import CLAIMS, HOLDS, OUTCOMES, all_hold, hold_outcome, outcome
from evidence.reproduction.runs import run
from evidence.reproduction.seen import Seen
from evidence.reproduction.sweep import ONE_BY_ONE, interval
from orchestration.expectations.holds import LATCHED, NEVER, RELEASED


@pytest.mark.parametrize(
    ("which", "longitude", "claims", "hold"),
    [
        ("V.B", 158.0, "every claim met", NEVER),
        ("V.C", 158.0, "every claim met", RELEASED),
        ("V.C", 200.0, "latched after a running command", LATCHED),
        ("V.C", 0.0, "settles in time, another claim not met", NEVER),
    ],
)
def test_the_numbers_of_a_run_tell_of_its_hold_what_the_scenario_tells(which, longitude, claims, hold):
    flown = run(which, "a", node(longitude))
    assert OUTCOMES[outcome(which, flown.seen)[0]] == claims
    told = {"never held": NEVER, "a running command held and released": RELEASED}
    assert told.get(HOLDS[hold_outcome(flown.seen)[0]], LATCHED) == hold
    assert hold.split()[-1] in flown.hold


def seen(n=1, **values):
    nothing = {f.name: np.zeros(n) for f in fields(Seen)}
    return Seen(**(nothing | {name: np.atleast_1d(np.array(v, float)) for name, v in values.items()}))


GOOD = {
    "V.B": {"settled": 180.0, "dipole": 14.0, "wheel_momentum": 3e-3, "b_wheel": 0.2},
    "V.C": {
        "settled": 250.0,
        "wheel_momentum": 3e-3,
        "crossings": 1,
        "crossed": 0.2,
        "hold_by_rod": 0.9,
        "held": 0.1,
        "holds": 1,
        "held_command": 14.0,
        "hold_ends": 0.6,
    },
}
BAD = {
    "V.B": {"settled": [193.2, math.nan], "dipole": 15.0, "wheel_momentum": 3.6e-3, "crossings": 1, "holds": 1},
    "V.C": {
        "settled": [290.0, math.nan],
        "wheel_momentum": 4.1e-3,
        "crossings": [0, 2],
        "crossed": [31.0, math.nan],
        "hold_by_rod": 0.7,
        "held_command": [0.0, math.inf],
        "held_at_zero": 1,
        "latched": 1,
        "saturated": 1,
    },
}


@pytest.mark.parametrize("which", CLAIMS)
def test_a_claim_fails_where_its_figure_does_and_alone(which):
    assert all_hold(which, seen(**GOOD[which]))[0]
    failing = set()
    for name, values in BAD[which].items():
        for value in np.atleast_1d(values):
            run_ = seen(**(GOOD[which] | {name: value}))
            lost = {c.text for c in CLAIMS[which] if not c.holds(run_)[0]}
            assert lost, (name, value)
            failing |= lost
    assert failing == {c.text for c in CLAIMS[which]}  # and every claim can fail


def test_outcomes_of_holds_are_told_apart():
    runs = seen(
        5,
        holds=[0, 1, 1, 2, 1],
        held=[math.nan, 0.1, 0.0, 0.1, 0.0],
        held_at_zero=[0, 0, 1, 0, 1],
        latched=[0, 0, 0, 1, 1],
        settled=[100.0, 100.0, 100.0, math.nan, math.nan],
    )
    assert hold_outcome(runs).tolist() == [0, 1, 2, 3, 4]
    assert [OUTCOMES[i] for i in outcome("V.C", runs)[-2:]] == list(OUTCOMES[3:])


@pytest.mark.parametrize(
    ("name", "late", "never", "kept"),
    [
        ("year (10 August)", slice(0, 1), slice(-2, None), (2006.0, 2013.0)),
        (ONE_BY_ONE[0].name, slice(170, 300), slice(0, 0), (300.0, 169.0)),  # a longitude goes round
    ],
)
def test_the_interval_of_a_constant_ends_where_a_claim_is_lost(name, late, never, kept):
    constant = next(c for c in ONE_BY_ONE if c.name == name)
    n = len(constant.values)
    settled = np.full(n, 180.0)
    settled[late], settled[never] = 200.0, math.nan
    runs = seen(n, **{k: np.full(n, v) for k, v in GOOD["V.B"].items()} | {"settled": settled})
    assert interval(constant, "V.B", runs) == kept
