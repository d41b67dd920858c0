"""Parts of the search for a wrong wiring, each by itself: names of ports, wirings of each kind, the factor of a
parameter and the time that a search may take."""

from __future__ import annotations

from itertools import pairwise
from time import monotonic, sleep, thread_time
from types import SimpleNamespace

import numpy as np
import pytest

from orchestration.acceptance.polarity.bench import clock
from orchestration.acceptance.polarity.fly import Loop
from orchestration.acceptance.polarity.parameters import _least
from orchestration.acceptance.polarity.ports import Port, kind_of
from orchestration.acceptance.polarity.reasons import Nominal, _peaks
from orchestration.acceptance.polarity.trials import ports_of, run
from orchestration.acceptance.polarity.wrongs import factors, wrongs
from orchestration.fmu.model import Element, Variable
from orchestration.quantities import parse_unit
from orchestration.session.read import read
from orchestration.system.wiring import Node

from ..wrong_inputs import SCENARIO


def port(kind: str, n: int, *positions: int, unit: str = "1") -> Port:
    return Port("a", "x", "input", positions or tuple(range(n)), kind, parse_unit(unit), n)


@pytest.mark.parametrize(("positions", "label"), [((), "x"), ((2,), "x[3]"), ((2, 3), "x[3..4]")])
def test_a_part_of_a_variable_is_named_by_its_first_and_last_element(positions, label):
    assert port("elements", 6, *positions).label == label


@pytest.mark.parametrize(
    ("shape", "kind"), [((), "scalar"), ((3,), "vector"), ((2,), "elements"), ((4,), "elements"), ((9,), "elements")]
)
def test_numbers_are_of_the_kind_that_their_count_tells_where_they_are_no_rotation(shape, kind):
    n = int(np.prod(shape, dtype=int))
    assert kind_of(Variable("x", "input", shape=shape), range(n), np.full((5, n), 2.0)) == kind


def test_a_rotation_is_told_from_a_mirror_and_from_nine_numbers_in_a_row():
    turn = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    for values, shape, kind in ((turn, (3, 3), "rotation"), (-turn, (3, 3), "elements"), (turn, (9,), "elements")):
        assert kind_of(Variable("R", "input", shape=shape), range(9), values.reshape(1, 9)) == kind


def test_the_two_places_of_a_quaternion_s_scalar_are_each_other_s_inverse():
    by_name = {w.name: w.matrix for w in wrongs(port("quaternion", 4))}
    there, back = by_name["scalar first as last"], by_name["scalar last as first"]
    assert np.array_equal(there @ back, np.eye(4))
    assert np.array_equal(back @ [1.0, 2.0, 3.0, 4.0], [2.0, 3.0, 4.0, 1.0])


@pytest.mark.parametrize("n", [2, 5])
def test_each_wiring_of_other_elements_is_there_once_and_none_is_the_right_one(n):
    made = [w.matrix for w in wrongs(port("elements", n))]
    assert len({m.tobytes() for m in made}) == len(made) == 1 + 1 + n + (n - 1) * (n > 2)
    assert all(np.array_equal(m @ m.T, np.eye(n)) and not np.array_equal(m, np.eye(n)) for m in made)
    assert any(np.array_equal(m @ np.arange(n), np.arange(n)[::-1]) for m in made)


def test_units_that_differ_by_one_factor_are_one_wrong_wiring():
    """A thousandth is mN m given in N m, and read in uN m."""
    found = sorted(float(w.matrix[0, 0]) for w in factors(parse_unit("mN.m"), 1, rare=True))
    assert all(b > 1.001 * a for a, b in pairwise(found))
    assert found[0] == pytest.approx(1e-3)
    assert found[-1] == pytest.approx(1e3)
    made = factors(parse_unit("mN.m"), 1, rare=True)
    assert {"given in N.m", "read in N.m"} <= {w.name for w in made}, "the usual unit is named, not the rare one"


@pytest.mark.parametrize("best", [0.47, 1.02, 2.1])
def test_the_factor_that_leaves_least_is_found_above_and_below_one(best):
    factor, left = _least(lambda x: (np.log(x) - np.log(best)) ** 2, best * 1.03, 0.06)
    assert factor == pytest.approx(best, rel=1e-6)
    assert left == pytest.approx(0.0, abs=1e-12)


def test_each_element_is_held_against_the_largest_of_its_variable():
    columns = {Node("a", Element("v", i)): np.array([0.0, -size]) for i, size in enumerate((0.5, 3.0, 2.0))}
    columns[Node("a", Element("w", 0))] = np.array([0.1, 0.0])
    assert list(_peaks(columns).values()) == [3.0, 3.0, 3.0, 0.1]


def test_a_search_counts_what_it_computes_and_a_tenth_of_what_passes():
    begun, passed = clock(), monotonic()
    sleep(0.2)
    assert 0.05 < (clock() - begun) / (monotonic() - passed) < 0.3
    begun, computed = clock(), thread_time()
    while thread_time() < computed + 0.1:
        pass
    assert clock() - begun >= 0.0999


def test_a_change_is_a_share_of_what_is_largest_and_whole_where_there_was_nothing():
    a, b = Node("a", Element("v", 0)), Node("a", Element("w", 0))
    of = SimpleNamespace(values={a: np.array([0.0, 0.2, 0.0]), b: np.zeros(3)}, peaks={a: 0.2, b: 0.0})
    assert Nominal._change(of, a, np.array([0.0, 0.3]), 2) == pytest.approx(0.5)
    assert Nominal._change(of, b, np.array([0.0, 1e-9]), 2) == 1.0
    assert Nominal._change(of, b, np.zeros(2), 2) == 0.0


@pytest.mark.compile
@pytest.mark.parametrize(
    ("expectation", "low", "high"),
    [
        ("{name: a, signal: motor.speed, after: 0.7 s, always: {below: 30 rpm}}", 0.7, 0.7),
        ("{name: a, signal: motor.speed, always: {below: 30 rpm}}", 0.5, 0.5),
        ("{name: a, signal: motor.speed, before: 1.4 s, ever: {below: 1 rad/s}}", 1.4, 2.0),
    ],
)
def test_a_wrong_sign_is_shown_as_soon_as_an_expectation_is_decided(loop, expectation, low, high):
    """2 rad/s times 1.1^n is above 30 rpm, 3.14 rad/s, from n = 5 on."""
    loop.write_text(f"{SCENARIO[: SCENARIO.index('expect:')]}isolation: none\nexpect: [{expectation}]\n")
    flown = Loop(read(loop))
    assert flown.fly()[0] is None
    voltage = next(p for p in ports_of(flown) if p.name == "motor.voltage")
    found, _ = flown.fly(voltage, next(w for w in wrongs(voltage) if w.name == "opposite sign"))
    assert low - 1e-9 <= found.time <= high + 1e-9


@pytest.mark.compile
def test_no_port_that_has_a_wrong_wiring_is_left_out(loop):
    text = loop.read_text("utf-8").replace("connections:", "connections:\n  - motor.hot -> regulator.enabled")
    loop.write_text(text, "utf-8")
    found = ports_of(Loop(read(loop)))
    made = run(read(loop), workers=1)
    assert made.skipped == []
    assert {row.port.name for row in made.rows} == {port.name for port in found}
