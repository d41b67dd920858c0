"""The search for what explains a difference, by its steps: on a block of two inputs whose law is a cross product."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestration.acceptance.inputs import theirs_alone
from orchestration.acceptance.polarity.identify import Score
from orchestration.acceptance.polarity.ports import Port
from orchestration.acceptance.polarity.search import Search
from orchestration.acceptance.polarity.wrongs import Wrong, wrongs
from orchestration.fmu.model import Element, Variable
from orchestration.quantities import parse_unit
from orchestration.system.wiring import Link, Node

RNG = np.random.default_rng(7)
VALUES = {
    "R": Rotation.random(6, random_state=7).as_matrix().reshape(6, 9),
    "a": RNG.normal(size=(6, 3)),
    "b": RNG.normal(size=(6, 3)),
}
FRAMES = {"R": "N from B", "a": "B", "b": "N"}


class Cross(Search):
    """Ours and theirs are y = a x b; theirs refuses nothing, ours an input that is larger than it should be."""

    def __init__(self) -> None:
        self.base, self._refused, self._fed, self._alone = {}, set(), {"a", "b"}, set()
        self.whole = self.few = VALUES
        self.inputs = VALUES
        self.rows = np.arange(6)
        self.reference = {"y": np.cross(VALUES["a"], VALUES["b"])}
        self.given = self.reference
        self.quaternions, self.turned, self.handed = {}, set(), {}
        kinds = {"R": "rotation", "a": "vector", "b": "vector"}
        self.ports = {
            n: Port("law", n, "input", tuple(range(v.shape[1])), kinds[n], parse_unit("N.m"), v.shape[1])
            for n, v in VALUES.items()
        }
        variables = {n: Variable(n, "input", shape=(3, 3) if n == "R" else (3,), frame=f) for n, f in FRAMES.items()}
        self._ours = SimpleNamespace(play=self._cross)
        self._theirs = SimpleNamespace(play=self._keep, model=SimpleNamespace(variables=variables))

    def _cross(self, inputs):
        if np.abs(inputs["a"]).max() > 10.0:
            return None
        return {"y": np.cross(inputs["a"], inputs["b"])}

    def _keep(self, inputs):
        self.handed = inputs
        return self._cross(inputs)


def of(search: Search, name: str, words: str) -> Wrong:
    return next(w for w in wrongs(search.ports[name], True) if w.name == words)


def test_two_inputs_with_the_opposite_sign_cannot_be_told_from_none_where_only_their_product_counts():
    search = Cross()
    (other,) = search._countered({"a": of(search, "a", "-y +x +z")})
    assert {name: wrong.name for name, wrong in other.items()} == {"a": "+y -x -z", "b": "-x -y -z"}


@pytest.mark.parametrize("inverse", [False, True])
def test_what_is_handed_over_is_read_as_it_should_be_along_other_axes_too(inverse):
    search = Cross()
    changes = {
        "a": Wrong("along the other side", "frame", along=("R", inverse)),
        "b": of(search, "b", "+y +z +x"),
    }
    search.theirs_on(VALUES, changes)
    assert np.abs(search.handed["a"] - VALUES["a"]).max() > 0.1
    read = search.misread(search.handed, changes)
    for name, values in VALUES.items():
        assert read[name] == pytest.approx(values), name


def test_a_vector_is_tried_along_the_axes_of_the_other_side_of_the_rotation_that_ends_in_its_frame():
    assert [Cross()._matrix_of(name) for name in ("a", "b")] == ["R", None]


def test_a_wiring_that_ours_refuses_alone_is_not_tried_again():
    """With another one beside it either could be what it refuses."""
    search = Cross()
    large, turned = of(search, "a", "given in uN.m"), of(search, "b", "+y +z +x")

    def tried(name):
        return {w.name for w in search.candidates(name)}

    assert search.error({"a": large, "b": turned}).cost == np.inf
    assert large.name in tried("a")
    assert search.error({"a": large}).cost == np.inf
    assert large.name not in tried("a")
    assert turned.name in tried("b")


def test_an_input_with_other_axes_is_tried_in_other_units_too_and_the_other_way_round():
    search = Cross()
    turn, unit = of(search, "a", "+y +z +x"), of(search, "a", "read in mN.m")
    both = unit.matrix @ turn.matrix
    for now in (turn, unit):
        assert any(w.matrix is not None and np.allclose(w.matrix, both) for w in search._near("a", now))
    assert len(search._near("a", None)) == len(search.candidates("a"))


@pytest.mark.parametrize("degrees", [-17.3, -2.6, 0.1, 9.9, 21.0])
def test_an_angle_near_one_of_a_grid_is_found_on_either_side(degrees):
    search, best = Cross(), np.radians(degrees)
    search._read_so = lambda reading, changes, unknowns: Score(0.0, abs(unknowns[0] - best))
    grid = SimpleNamespace(starts=((0.0,), (1.0,)))
    assert search._finer(grid, Score(0.0, abs(best)), {}, (0.0,)).cost < np.radians(0.4)
    for other, start in ((SimpleNamespace(starts=((0.0,),)), (0.0,)), (grid, (0.0, 0.0, 0.0))):
        assert search._finer(other, Score(0.0, 5.0), {}, start).cost == 5.0


def test_an_input_of_another_block_with_the_name_of_one_that_only_theirs_has_is_not_taken_for_it():
    ends = [(Node("a", Element("rate", 0)), Node(block, Element("extra", 0))) for block in ("law", "plant")]
    links = [Link("x", (source,), (target,)) for source, target in ends]
    fits = {"law": SimpleNamespace(feeding={"extra": 1})}
    swapped = SimpleNamespace(
        prepared=SimpleNamespace(fits=fits), plan=SimpleNamespace(wiring=SimpleNamespace(links=links))
    )
    assert theirs_alone(swapped, "law") == links[:1]
