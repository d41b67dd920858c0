"""Loops of mocks for tests of margins: a linear plant, and a law that feeds its outputs back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
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


def toy(folder: Path, law_text: str, gain: float = 0.8) -> Path:
    """Writes a scenario of two laws in Python, and returns its path: an integrator of the wheel's torque, and a
    controller with this text; `gain` is a parameter of it."""
    (folder / "toy.py").write_text(
        """\
class Integrator:
    def __init__(self):
        self.rate = 1.0

    def step(self, inputs, parameters, t, h):
        self.rate += h * inputs.wheel_torque_cmd
        return {"omega_B": [self.rate, 0.0, 0.0]}
""",
        "utf-8",
    )
    (folder / "law.py").write_text(f"import numpy as np\n\nPARAMETERS = {{'gain': {gain}}}\n\n\n{law_text}", "utf-8")
    (folder / "toy.yaml").write_text(
        f"""\
name: toy
step: {STEP}
isolation: none
duration: 1
blocks:
  plant: {{python: toy.py, start: {{dipole_cmd: [0, 0, 0]}}}}
  controller:
    python: law.py
    start: {{gain: {gain}, R_NB: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], r_N: [7e6, 0, 0], v_N: [0, 7500, 0]}}
connections: [plant.omega_B -> controller.omega_B, "controller.tau_cmd_B[1] -> plant.wheel_torque_cmd"]
""",
        "utf-8",
    )
    return folder / "toy.yaml"


def static(expression: str) -> str:
    """Returns the text of a law without memory: its torque is this of the rate w and the gain g."""
    return f"""\
def step(inputs, parameters, t, h):
    w, g = inputs.omega_B[0], parameters.gain
    return {{"tau_cmd_B": [float({expression}), 0.0, 0.0]}}
"""
