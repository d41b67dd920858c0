"""Expressions of signals and the consistency checks made of them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestration.errors import InputError
from orchestration.expectations.consistency import ConsistencyObserver, prepare
from orchestration.expectations.expressions import parse
from orchestration.expectations.functions import Samples
from orchestration.expressions import ExpressionError
from orchestration.fmu.model import Element, Model, Variable
from orchestration.quantities import parse_unit
from orchestration.scenario.load import load
from orchestration.system.wiring import Node

N = 40
TIME = 0.1 * np.arange(N)


def variable(name, unit="1", shape=(), kind="real"):
    size = int(np.prod(shape)) if shape else 1
    return Variable(name, "output", kind, shape, tuple(range(size)), unit=parse_unit(unit))


KIND = Model(
    "body",
    {
        v.name: v
        for v in (
            variable("R", shape=(3, 3)),
            variable("w", "rad/s", (3,)),
            variable("b", "nT", (3,)),
            variable("h", "mN.m.s"),
            variable("t", "N.m"),
            variable("on", kind="boolean"),
        )
    },
)


def find(reference):
    v, positions = KIND.find("a", reference.variable, reference.indices)
    return v.at(positions), [Node("a", Element(v.name, p)) for p in positions]


def samples(**values):
    columns = {}
    for name, array in values.items():
        flat = np.asarray(array, float).reshape(N, -1)
        columns |= {Node("a", Element(name, i)): flat[:, i] for i in range(flat.shape[1])}
    return Samples(TIME, columns)


def test_the_rate_of_turning_of_an_attitude_is_that_of_scipy():
    rate = np.array([0.3, -0.2, 0.5])
    R = Rotation.from_euler("ZYX", [0.4, 0.1, -2.0]) * Rotation.from_rotvec(TIME[:, None] * rate)
    found = parse("turn_rate(a.R)", find).value(samples(R=R.as_matrix()))
    assert np.isnan(found[0]).all()
    assert np.allclose(found[1:], rate, rtol=1e-9)


def test_an_expression_has_the_values_of_numpy_in_si_units():
    rng = np.random.default_rng(5)
    R, w, b, h = rng.normal(size=(N, 3, 3)), rng.normal(size=(N, 3)), rng.normal(size=(N, 3)), rng.normal(size=N)
    given = samples(R=R, w=w, b=b, h=h)

    def value(text):
        return parse(text, find).value(given)

    assert np.allclose(value("transpose(a.R) @ a.R"), np.einsum("nji,njk->nik", R, R))
    assert np.allclose(value("cross(a.w, [a.h, 0, 0])"), np.cross(w, np.stack([1e-3 * h, 0 * h, 0 * h], axis=1)))
    assert np.allclose(value("a.b[2] / norm(a.b)"), b[:, 1] / np.linalg.norm(b, axis=1))
    assert np.allclose(value("norm(a.b)"), 1e-9 * np.linalg.norm(b, axis=1))
    assert np.allclose(value("det(a.R)"), np.linalg.det(R))
    assert np.allclose(value("-minimum(a.w, 0) + maximum(a.w, 0)"), value("abs(a.w)"))
    assert np.allclose(value("rate(a.h)")[1:], 1e-3 * np.diff(h) / 0.1)
    assert np.allclose(value("mean(a.h) * 2 - previous(a.h)")[1:], 1e-3 * h[1:])
    assert np.allclose(value("dot(a.w, a.w)"), (w**2).sum(axis=1))
    assert np.allclose(value("a.h ** 2 / 3 - 0"), 1e-6 * h**2 / 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a.h +", "expected an expression"),
        ("a.h + a.w[1]", "different units: kg.m2.s-1 and s-1"),
        ("a.h + 1", "different units"),
        ("cross(a.w, a.h)", "cross takes [3], found a scalar"),
        ("a.R @ a.h", "no matrix product of [3, 3] and []"),
        ("a.R * a.w", "the shapes differ: [3, 3] and [3]"),
        ("size(a.w)", "there is no function 'size'"),
        ("norm(a.w, a.w)", "norm takes 1 value, found 2"),
        ("a.on", "a.on is a boolean scalar; expected a number"),
        ("a.h ** 99", "a whole exponent of 1 to 9"),
        ("(lambda: 1)()", "expected an expression of signals, numbers, lists"),
        ("__import__('os')", "there is no function"),
        ("[a.h, a.w]", "items of one shape"),
        ("1e999 * a.h", "a finite number"),
    ],
)
def test_what_is_no_expression_is_refused_in_words(text, message):
    with pytest.raises(ExpressionError) as error:
        parse(text, find)
    assert message in str(error.value)


def scenario(**check):
    blocks = {"a": {"fmu": "a.fmu"}}
    return load({"name": "x", "step": 0.1, "duration": 4, "blocks": blocks, "consistency": {"c": check}})


def test_a_check_finds_the_first_sample_that_breaks_it_however_the_samples_are_cut():
    """h is the sum of t, but for one sample, and the difference to the one before is needed at every cut."""
    torque = np.sin(TIME)
    h = 1e3 * np.concatenate(([0.0], np.cumsum(torque[1:] * 0.1)))
    bent = h.copy()
    bent[23:] += 1.0
    (relation,) = prepare(scenario(left="rate(a.h)", right="a.t", within="1 mN.m"), {"a": KIND})
    for cuts in ([], [23], [1, 2, 3, 24], range(1, N)):
        for course, broken in ((h, None), (bent, 2.3)):
            observer, shown = ConsistencyObserver(relation), samples(h=course, t=torque)
            ends = [0, *cuts, N]
            for first, last in pairwise(ends):
                buffer = {node: values[first:last].copy() for node, values in shown.columns.items()}
                observer.see(TIME[first:last].copy(), buffer)
                for values in buffer.values():
                    values[:] = np.inf  # the master hands the next samples over in the same array
            assert (observer.broken.time if observer.broken else None) == (pytest.approx(broken) if broken else None)


def test_a_check_looks_only_where_and_as_closely_as_it_is_told():
    h = np.where(TIME < 2.0, 0.0, 1.0)
    on = np.where(TIME < 2.95, 0.0, 1.0)

    def broken(**more):
        (relation,) = prepare(scenario(left="a.h", right=0, **{"within": "0.5 mN.m.s", **more}), {"a": KIND})
        observer = ConsistencyObserver(relation)
        observer.see(TIME, samples(h=h, on=on).columns)
        return observer.broken and observer.broken.time

    assert broken() == pytest.approx(2.0)
    assert broken(within="1.5 mN.m.s") is None
    assert broken(share=0.6) is None
    assert broken(before=1.5) is None
    assert broken(after="2.5 s") == pytest.approx(2.5)
    assert broken(when="a.on") == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("check", "message"),
    [
        ({"left": ["a.y"], "right": 0, "within": 1}, "consistency.c.left: expected text"),
        ({"left": "a.x", "right": 0, "within": 1}, "consistency.c.left: a has no variable 'x'"),
        ({"left": "a.h", "right": "a.t", "within": 1}, "the units differ"),
        ({"left": "a.w", "right": "a.t", "within": 1}, "the shapes differ"),
        ({"left": "a.h", "right": 0, "within": "1 m"}, "within: the unit 'm' does not fit"),
        ({"left": "a.h", "right": 0, "within": -1}, "expected zero or more"),
        ({"left": "a.h", "right": 0, "within": 1, "when": "a.t"}, "expected one boolean"),
        ({"left": 1, "right": 1, "within": 1}, "expected a signal"),
    ],
)
def test_a_check_that_does_not_fit_the_blocks_is_refused_with_its_place(check, message):
    with pytest.raises(InputError) as error:
        prepare(scenario(**check), {"a": KIND})
    assert message in str(error.value)
