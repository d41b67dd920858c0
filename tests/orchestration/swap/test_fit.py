"""Which of their ports stand for which of ours: elements, types, what is left over, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from orchestration.fmu.model import Element
from orchestration.swap.adapter import Adapter
from orchestration.swap.findings import unfed

from .. import mocks
from ..mocks import Mock, real
from .behind import echo, fitted, through, unit


def test_elements_that_nothing_feeds_are_refused_unless_they_have_a_start():
    ours = mocks.model("ours", real("u", "input", shape=(2,)))
    theirs = mocks.model("theirs", real("gyro", "input", shape=(4,)))
    ports = {"u": ["gyro[1]", "gyro[3]"]}
    found = fitted(ours, theirs, ports=ports)
    (error,) = found.errors
    assert "inputs gyro[2] gyro[4] are only in their FMU, and nothing feeds them; remedy: " in str(error)
    assert not unfed(error), "no scenario can feed them"
    assert found.findings[0].text == "input u = gyro[1] gyro[3], a real [2]"
    found = fitted(ours, theirs, ports=ports, start={"gyro[2]": 0.1, "gyro[4]": 0.2})
    assert not found.errors
    block = Mock("x", theirs, lambda b: None)
    through(found, block, u=[5.0, 6.0])
    assert block.vector("gyro").tolist() == [5.0, 0.1, 6.0, 0.2]
    (error,) = fitted(ours, theirs, ports=ports, start={"gyro": [1, 2, 3, 4]}).errors[:1]
    assert "gyro[1] gyro[3] stands for our u, whose value it takes" in str(error)


def test_a_start_value_of_the_mapping_that_is_no_number_is_refused_by_name():
    theirs = mocks.model("theirs", real("off_time", "parameter"))
    (error,) = fitted(mocks.model("ours"), theirs, start={"off_time": float("nan")}).errors
    assert "off_time, under start: expected a finite number, found nan" in str(error)


def test_what_is_left_of_outputs_and_parameters_is_told():
    ours = mocks.model("ours", real("y", "output"), real("p", "parameter"))
    theirs = mocks.model("theirs", real("v", "output", shape=(2,)), real("q", "parameter", shape=(2,)))
    told = [f.text for f in fitted(ours, theirs, ports={"y": "v[2]", "p": "q[1]"}).findings]
    assert "elements of outputs that stand for nothing of ours: v[1]" in told
    assert "parameter only in their FMU, at its own values: q[2]" in told


def test_single_elements_are_set_and_the_others_keep_what_they_had():
    ours = mocks.model("ours", real("u", "input", shape=(2,)), real("y", "output", shape=(2,)))
    theirs = mocks.model("theirs", real("v", "input", shape=(2,)), real("y", "output", shape=(2,)))
    found = fitted(ours, theirs, ports={"u": {"theirs": "v", "matrix": [[0, 2], [1, 0]]}})
    block = echo("x", theirs, {"y": "v"})
    adapter = Adapter(block, found)
    adapter.set([(Element("u", 0), 5.0)])
    assert block.vector("v").tolist() == [0.0, 5.0]
    adapter.set([(Element("u", 1), 3.0)])
    assert block.vector("v").tolist() == [6.0, 5.0]
    buffer = adapter.wire([Element("u", 1)], [], [0, 0, 0, 0], np.zeros(0))  # the first one is not connected
    buffer[:] = 7.0
    adapter.set_inputs()
    assert block.vector("v").tolist() == [14.0, 5.0]
    adapter.set([(Element("u", 0), 9.0)])  # in the middle of a run
    adapter.set_inputs()
    assert block.vector("v").tolist() == [14.0, 9.0]


def test_booleans_and_enumerations_pass_as_they_are():
    kinds = {"flag": "boolean", "mode": "enumeration", "count": "integer"}
    items = {"mode": (("low", 1), ("high", 2))}
    ours = mocks.model(
        "ours",
        *(real(n, "input", type=t, items=items.get(n, ())) for n, t in kinds.items()),
        *(real(f"{n}_out", "output", type=t, items=items.get(n, ())) for n, t in kinds.items()),
    )
    theirs = mocks.model(
        "theirs",
        *(real(f"v_{n}", "input", type=t, items=items.get(n, ())) for n, t in kinds.items()),
        *(real(f"v_{n}_out", "output", type=t, items=items.get(n, ())) for n, t in kinds.items()),
    )
    found = fitted(ours, theirs, ports={n: f"v_{n}" for n in ours.variables})
    block = echo("x", theirs, {f"v_{n}_out": f"v_{n}" for n in kinds})
    adapter = Adapter(block, found)
    fed = sorted(
        ours.inputs, key=lambda e: ("integer", "enumeration", "boolean").index(ours.variables[e.variable].type)
    )
    given = [Element(f"{e.variable}_out", 0) for e in fed]
    into = np.zeros(3)
    buffer = adapter.wire(fed, given, [0, 1, 1, 1], into)
    buffer[:] = [7, 2, 1]
    adapter.set_inputs()
    adapter.do_step(0.0, 1.0)
    adapter.get_live()
    assert into.tolist() == [7, 2, 1]


@pytest.mark.parametrize(
    ("mapping", "message"),
    [
        ({"ports": {"w": "v"}}, "the interface ours has no 'w'"),
        ({"ports": {"u": "w"}}, "their FMU has no variable 'w'"),
        ({"ports": {"u": "y"}}, "y is of causality output, expected input"),
        ({"ports": {"u": {"theirs": "v", "matrix": [[1, 0]]}}}, "the matrix is 1 by 2, expected 2 by 2"),
        ({"ports": {"u": ["v[1]"]}}, "ours is a real [2], theirs has 1 value"),
        ({"ports": {"u": "v", "y": {"theirs": "y", "matrix": [[1, 1], [1, 1]]}}}, "the matrix has no inverse"),
        ({"ports": {"u": "v", "p": "v"}}, "v[1] already stands for u"),
        ({"ports": {"u": ["v[1]", "v[1]"]}}, "input u = v[1] v[1]: v[1] is named more than once"),
        ({"ports": {"u": {"theirs": "v", "offset": [1, 2, 3]}}}, "the offset has 3 values, expected 2"),
        (
            {"ports": {"u": {"theirs": "v", "quaternion": "scalar first"}}},
            "a quaternion of 4 stands for a matrix of [3, 3]",
        ),
        ({"ports": {"u": "v"}, "ignore": ["u"]}, "u is both mapped and ignored"),
        ({"ports": {"u": "v"}, "ignore": ["z"]}, "the interface ours has no 'z'"),
        ({"ports": {"u": "v"}, "start": {"z": 1}}, "their FMU has no input or parameter 'z'"),
        ({"ports": {"u": "v"}, "start": {"v": [1, 2]}}, "v stands for our u, whose value it takes"),
        ({}, "input u, a real [2] in m, is missing; by name or unit it may be v"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_name(mapping, message):
    two = {"shape": (2,), "unit": unit("m")}
    ours = mocks.model("ours", real("u", "input", **two), real("y", "output", **two), real("p", "input", **two))
    theirs = mocks.model("theirs", real("v", "input", **two), real("y", "output", **two), real("p", "input", **two))
    assert message in "\n".join(map(str, fitted(ours, theirs, **mapping).errors))
