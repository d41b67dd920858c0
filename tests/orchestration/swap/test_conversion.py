"""Another team's quantities behind our interface: units, factors, matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest

from orchestration.fmu.model import Element
from orchestration.quantities import Unit
from orchestration.swap.adapter import Adapter

from .. import mocks
from ..mocks import Mock, real
from .behind import echo, fitted, through, unit


def test_theirs_is_A_ours_plus_c_in_both_directions():
    rng = np.random.default_rng(1)
    A, c = rng.normal(size=(3, 3)), rng.normal(size=3)
    ours = mocks.model("ours", real("u", "input", shape=(3,)), real("y", "output", shape=(3,)))
    theirs = mocks.model("theirs", *(real(f"a{i}", "input") for i in range(3)), real("b", "output", shape=(3,)))

    def evaluate(block: Mock) -> None:
        for i in range(3):
            block.values[Element("b", i)] = block[f"a{i}"]

    entry = {"matrix": A.tolist(), "offset": c.tolist()}
    found = fitted(ours, theirs, ports={"u": {"theirs": ["a0", "a1", "a2"], **entry}, "y": {"theirs": "b", **entry}})
    block = Mock("x", theirs, evaluate)
    u = rng.normal(size=3)
    back = through(found, block, u=u)
    np.testing.assert_allclose([block[f"a{i}"] for i in range(3)], A @ u + c, rtol=1e-14)
    np.testing.assert_allclose([back[f"y[{i}]"] for i in range(3)], u, rtol=1e-12)


@pytest.mark.parametrize(
    ("ours", "theirs", "value", "expected"),
    [
        ("rad/s", "deg/s", math.pi, 180.0),
        ("N.m", "mN.m", 0.25, 250.0),
        ("T", "nT", 3e-5, 3e4),
        ("A.m2", "mA.m2", 1.5, 1500.0),
        ("K", "degC", 300.0, 26.85),
        ("rad/s", "rpm", 2 * math.pi, 60.0),
    ],
)
def test_units_are_converted_without_being_told(ours, theirs, value, expected):
    a = mocks.model("ours", real("u", "input", unit=unit(ours)), real("y", "output", unit=unit(ours)))
    b = mocks.model("theirs", real("u", "input", unit=unit(theirs)), real("y", "output", unit=unit(theirs)))
    block = echo("x", b, {"y": "u"})
    back = through(fitted(a, b), block, u=value)
    assert block["u"] == pytest.approx(expected, rel=1e-13)
    assert back["y[0]"] == pytest.approx(value, rel=1e-13)


def test_a_momentum_becomes_a_speed_by_an_inertia():
    ours = mocks.model("ours", real("h", "input", unit=unit("N.m.s")), real("y", "output", unit=unit("N.m.s")))
    theirs = mocks.model("theirs", real("tach", "input", unit=unit("rpm")), real("y", "output", unit=unit("N.m.s")))
    for entry in ({"divide": "147 g.cm2"}, {"scale": f"{1 / 1.47e-5!r} rad/kg/m2"}):
        found = fitted(ours, theirs, ports={"h": {"theirs": "tach", **entry}})
        block = echo("x", theirs, {"y": "tach"})
        through(found, block, h=0.03)
        assert block["tach"] == pytest.approx(0.03 / 1.47e-5 * 30 / math.pi, rel=1e-12)


def test_a_factor_of_the_wrong_unit_is_refused():
    ours = mocks.model("ours", real("h", "input", unit=unit("N.m.s")))
    theirs = mocks.model("theirs", real("tach", "input", unit=unit("rpm")))
    (error,) = fitted(ours, theirs, ports={"h": {"theirs": "tach", "divide": "147 g"}}).errors
    assert "ours, N.m.s, over 147 g does not come out in rpm" in str(error)


def test_a_factor_beyond_a_double_is_refused():
    ours = mocks.model("ours", real("h", "input"))
    theirs = mocks.model("theirs", real("v", "input"))
    (error,) = fitted(ours, theirs, ports={"h": {"theirs": "v", "divide": 1e-310}}).errors
    assert "the factor 1e-310 is beyond what a double holds" in str(error)


@pytest.mark.parametrize(
    ("matrix", "fits"),
    [([[1e-9, 0], [0, 1e-9]], True), ([[1, 1], [1, 1 + 1e-13]], False), ([[0, 0], [0, 0]], False)],
)
def test_a_matrix_is_turned_back_by_its_condition_whatever_its_size(matrix, fits):
    ours = mocks.model("ours", real("y", "output", shape=(2,)))
    theirs = mocks.model("theirs", real("y", "output", shape=(2,)))
    assert (not fitted(ours, theirs, ports={"y": {"theirs": "y", "matrix": matrix}}).errors) is fits


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        (
            Unit("deg/s", unit("rad/s").exponents),
            "the unit deg/s to be 1 s-1.rad, but usually it is 0.01745329252 s-1.rad",
        ),
        (Unit("rad/s", unit("rad/s").exponents, -1.0), "the unit rad/s to be -1 s-1.rad, but usually it is 1 s-1.rad"),
        (Unit("rpm", unit("rad").exponents, math.pi / 30), "but usually it is 0.1047197551 s-1.rad"),
        (Unit("degC", unit("K").exponents, 1.0, 0.0), "the unit degC to be 1 K, but usually it is 1 K +273.15"),
        (Unit("deg/s", unit("rad/s").exponents, 0.0174533), ""),
        (Unit("knack", unit("rad/s").exponents, 3.0), ""),
    ],
)
def test_a_unit_that_is_declared_to_be_another_is_refused_unless_it_is_stated(declared, message):
    own = unit("K" if declared.name == "degC" else "rad/s")
    ours = mocks.model("ours", real("u", "input", unit=own))
    theirs = mocks.model("theirs", real("u", "input", unit=declared))
    told = "\n".join(map(str, fitted(ours, theirs).errors))
    assert (message in told) if message else not told
    if message:
        assert f"or state what is meant, such as 'unit: {declared}', in the mapping" in told
        assert not fitted(ours, theirs, ports={"u": {"theirs": "u", "unit": declared.name}}).errors


def test_a_stated_unit_stands_for_one_that_is_not_declared():
    ours = mocks.model("ours", real("u", "input", unit=unit("rad/s")), real("y", "output"))
    theirs = mocks.model("theirs", real("u", "input"), real("y", "output"))
    silent = fitted(ours, theirs)
    assert any("theirs has no unit, so it is taken to be in rad/s" in f.text for f in silent.findings)
    found = fitted(ours, theirs, ports={"u": {"theirs": "u", "unit": "deg/s"}})
    assert not [f for f in found.findings if f.level == "warning"]
    block = echo("x", theirs, {"y": "u"})
    through(found, block, u=math.pi)
    assert block["u"] == pytest.approx(180.0)


@pytest.mark.filterwarnings("error")
def test_a_very_large_value_passes_without_a_warning_of_numpy():
    """Its square overflows in the quick look for what is not finite."""
    ours = mocks.model("ours", real("u", "input"), real("y", "output"))
    theirs = mocks.model("theirs", real("u", "input"), real("z", "output"))
    adapter = Adapter(echo("x", theirs, {"z": "u"}), fitted(ours, theirs, ports={"y": "z"}))
    result = mocks.run([adapter], {"step": 1, "duration": 2}, start={"x": {"u": 1e200}})
    assert result["x.y"].tolist() == [1e200] * 3
