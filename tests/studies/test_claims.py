"""Claims and outcomes: of runs through FMUs, of the same loops flown together, and of made-up figures."""

import math
from dataclasses import fields

import numpy as np
import pytest

from orchestration.expectations.holds import LATCHED, NEVER, RELEASED
from studies.claims import CLAIMS, DURATION, HOLDS, OUTCOMES, all_hold, hold_outcome, outcome
from studies.reproduction import run
from studies.setup import read
from studies.sweep import ONE_BY_ONE, interval
from studies.watch import Seen, fly

NODES = {"V.C": (158.0, 200.0, 0.0), "V.B": (158.0,)}


@pytest.mark.parametrize(("which", "node"), [(w, x) for w, nodes in NODES.items() for x in nodes])
def test_a_run_through_the_fmus_and_a_loop_of_many_are_seen_alike(which, node):
    changes = {"plant.node_longitude": math.radians(node), "plant.integrator_order": 2}
    through_fmus = run(which, "a", changes)
    name = {"V.B": "no_singularity", "V.C": "singularity"}[which]
    together = fly([read(f"scenarios/paper_{name}.yaml").loop.change(changes)], 0.1, DURATION)
    for f in fields(Seen):
        found, expected = getattr(through_fmus.seen, f.name), getattr(together, f.name)
        if f.name in (
            "saturated",
            "wheel_at_limit_since",
            "dipole",
        ):  # seen a sample earlier before the command is flown
            np.testing.assert_allclose(found, expected, atol=0.11, err_msg=f.name)
        else:
            np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-7, err_msg=f.name)
    assert outcome(which, through_fmus.seen)[0] == outcome(which, together)[0]
    told = {"never held": NEVER, "a running command held and released": RELEASED}
    expected_text = told.get(HOLDS[hold_outcome(together)[0]], LATCHED)
    assert expected_text.split()[-1] in through_fmus.hold


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


def test_the_interval_of_a_constant_ends_where_a_claim_is_lost():
    constant = next(c for c in ONE_BY_ONE if c.name == "year (10 August)")
    n = len(constant.values)
    settled = np.full(n, 180.0)
    settled[0], settled[-2:] = 200.0, math.nan
    runs = seen(n, **{k: np.full(n, v) for k, v in GOOD["V.B"].items()} | {"settled": settled})
    assert interval(constant, "V.B", runs) == (2006.0, 2013.0, "settling", "settling")


def test_the_interval_of_a_longitude_goes_round_and_a_latch_is_named():
    constant = ONE_BY_ONE[0]
    n = len(constant.values)
    settled = np.full(n, 180.0)
    settled[170:300] = 200.0
    latched = np.zeros(n)
    latched[299] = 1.0
    runs = seen(n, **{k: np.full(n, v) for k, v in GOOD["V.B"].items()} | {"settled": settled, "latched": latched})
    assert interval(constant, "V.B", runs) == (300.0, 169.0, "the hold latches", "settling")
