"""Loops of mocks for tests of margins: a linear plant, and a law that feeds its outputs back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from orchestration import load
from orchestration.margins.inject import Rig
from orchestration.margins.site import site
from orchestration.session.plan import plan
from orchestration.session.session import Session
from tests.orchestration.mocks import Mock, Mocked, model, real

Law = Callable[[np.ndarray], np.ndarray]
STEP = 0.1


def linear(A, B, C, kick: float = 1.0) -> Mock:
    """x+ = A x + B u, y = C x; x begins at `kick`."""
    A, B, C = (np.atleast_2d(np.asarray(M, float)) for M in (A, B, C))
    shapes = [(M,) if M > 1 else () for M in (B.shape[1], C.shape[0])]

    def evaluate(block: Mock) -> None:
        block.values.update(zip(block.model.variables["y"].elements, C @ block.state, strict=True))

    def advance(block: Mock, time: float, step: float) -> None:
        block.state = A @ block.state + B @ block.vector("u")

    kind = model("plant", real("u", "input", shape=shapes[0]), real("y", "output", shape=shapes[1]))
    return Mock("plant", kind, evaluate, advance, np.full(len(A), kick))


def law(function: Law, inputs: int = 1, outputs: int = 1) -> Mock:
    """y = function(u), direct."""

    def evaluate(block: Mock) -> None:
        if block.state is None:
            advance(block, 0.0, 0.0)

    def advance(block: Mock, time: float, step: float) -> None:
        block.state = np.atleast_1d(function(block.vector("u")))
        block.values.update(zip(block.model.variables["y"].elements, block.state.tolist(), strict=True))

    shapes = [(n,) if n > 1 else () for n in (inputs, outputs)]
    kind = model(
        "law", real("u", "input", shape=shapes[0]), real("y", "output", shape=shapes[1]), feedthrough={"y": ["u"]}
    )
    return Mock("law", kind, evaluate, advance, None)


class Flights(Session):
    """A session whose blocks are mocks, new for each flight."""

    def __init__(self, make: Callable[[], list[Mock]], **more: Any) -> None:
        blocks = make()
        entries = {block.name: {"fmu": "mock", **more.get(block.name, {})} for block in blocks}
        links = ["plant.y -> law.u", "law.y -> plant.u"]
        scenario = load({"name": "loop", "step": STEP, "duration": 1, "blocks": entries, "connections": links})
        super().__init__(Mocked(plan(scenario, {block.name: block.model for block in blocks})))
        self._make = make

    def fly(self, *args: Any, **options: Any) -> Any:
        around = options.pop("around")
        return super().fly(*args, **options, around=lambda _: around({block.name: block for block in self._make()}))


def rig(make: Callable[[], list[Mock]], *ports: str, first: int = 50, **more: Any) -> Rig:
    session = Flights(make, **more)
    return Rig(session, site(session.opened.plan, ports or ("plant.u",)), first)
