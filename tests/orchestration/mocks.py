"""Blocks in pure Python, for tests of the engine without FMI, and scenarios made of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from orchestration import load
from orchestration.errors import BlockError
from orchestration.fmu.model import Element, Floats, Model, Variable
from orchestration.instances.block import Block
from orchestration.master.master import Options
from orchestration.results.result import Result
from orchestration.session.plan import Plan, plan
from orchestration.session.run import evaluated
from orchestration.session.session import Session

Values = dict[Element, Any]


def model(name: str, *variables: Variable, feedthrough: Mapping[str, Iterable[str] | None] | None = None) -> Model:
    """A model whose outputs depend directly on the inputs named, each on all elements; on none by default."""
    by_name = {v.name: v for v in variables}
    depends: dict[Element, frozenset[Element] | None] = {}
    for output in variables:
        inputs = (feedthrough or {}).get(output.name, ())
        known = None if inputs is None else frozenset(e for i in inputs for e in by_name[i].elements)
        if output.causality == "output":
            depends.update(dict.fromkeys(output.elements, known))
    return Model(name, by_name, feedthrough=depends, initial=dict(depends))


class Mock:
    """A block with a function from its state, inputs and time to its outputs.

    `evaluate(block)` sets outputs from `block.values`; `advance(block, time, step)` changes `block.state`
    before it. `calls` is the list of all calls with the time of the master where there is one.
    """

    def __init__(
        self,
        name: str,
        model: Model,
        evaluate: Callable[[Mock], None],
        advance: Callable[[Mock, float, float], None] = lambda block, time, step: None,
        state: Any = 0.0,
    ) -> None:
        self.name, self.model, self.evaluate, self.advance, self.state = name, model, evaluate, advance, state
        self.values: Values = {e: 0.0 for v in model.variables.values() for e in v.elements}
        self.calls: list[tuple[Any, ...]] = []

    def __getitem__(self, name: str) -> float:
        return self.values[Element(name, 0)]

    def __setitem__(self, name: str, value: float) -> None:
        self.values[Element(name, 0)] = value

    def vector(self, name: str) -> np.ndarray:
        return np.array([self.values[e] for e in self.model.variables[name].elements])

    def fail(self, call: str, status: str = "error") -> BlockError:
        return BlockError(self.name, call, f"gave status {status}", log=["this is why"])

    # ------------------------------------------------------------ Block

    log = ()

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        self.values.update(values)
        self.calls.append(("set",))

    def get(self, elements: Sequence[Element]) -> list[float]:
        self.evaluate(self)
        self.calls.append(("get", *dict.fromkeys(e.variable for e in elements)))
        return [float(self.values[e]) for e in elements]

    def enter(self, stop: float) -> None:
        self.calls.append(("enter", stop))

    def leave(self) -> None:
        self.calls.append(("leave",))

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        self._inputs, self._outputs, self._into, self._live = inputs, outputs, into, live
        self._from = np.zeros(len(inputs))
        return self._from

    def set_inputs(self) -> None:
        self.values.update(zip(self._inputs, self._from.tolist(), strict=True))
        self.calls.append(("set_inputs",))

    def do_step(self, time: float, step: float) -> None:
        self.calls.append(("do_step", time, step))
        self.advance(self, time, step)

    def get_live(self) -> None:
        self.evaluate(self)
        kinds = [self.model.variables[e.variable].type for e in self._outputs]
        left = dict(zip(("real", "integer", "enumeration", "boolean"), self._live, strict=True))
        for place, (element, kind) in enumerate(zip(self._outputs, kinds, strict=True)):
            if left[kind] > 0:
                self._into[place] = self.values[element]
                left[kind] -= 1
        self.calls.append(("get_live",))

    def get_all(self) -> None:
        self.evaluate(self)
        self._into[:] = [self.values[e] for e in self._outputs]
        self.calls.append(("get_all",))

    def close(self) -> None:
        self.calls.append(("close",))


def real(name: str, causality: str, **more: Any) -> Variable:
    shape = more.get("shape", ())
    size = int(np.prod(shape)) if shape else 1
    return Variable(name, causality, references=tuple(range(size)), **more)


def law(name: str, function: Callable[[float], float] = lambda u: u) -> Mock:
    """y = function(u), sampled in doStep: what it gave at the last step stays until the next."""

    def evaluate(block: Mock) -> None:
        if block.state is None:  # in initialization the law of the inputs as they stand
            block["y"] = function(block["u"])

    def advance(block: Mock, time: float, step: float) -> None:
        block.state = block["y"] = function(block["u"])

    kind = model("law", real("u", "input"), real("y", "output"), feedthrough={"y": ["u"]})
    return Mock(name, kind, evaluate, advance, None)


def ramp(name: str) -> Mock:
    """y = t, and `seen`, the input at the last step; no feedthrough."""

    def evaluate(block: Mock) -> None:
        block["y"], block["seen"] = block.state, block.values.get(Element("held", 0), 0.0)

    def advance(block: Mock, time: float, step: float) -> None:
        block.values[Element("held", 0)] = block["u"]
        block.state = round(time + step, 9)

    return Mock(name, model("ramp", real("u", "input"), real("y", "output"), real("seen", "output")), evaluate, advance)


@dataclass
class Mocked:
    """What a session opens in the place of FMUs: none."""

    plan: Plan
    fmus: Mapping[str, Any] = field(default_factory=dict)


def run(blocks: Sequence[Block], scenario: Mapping[str, Any], **options: Any) -> Result:
    """Runs mocks under a scenario, given without its `blocks` and `name`."""
    every, start = options.pop("every", {}), options.pop("start", {})
    entries = {b.name: {"fmu": "mock", "every": every.get(b.name, 1), "start": start.get(b.name, {})} for b in blocks}
    loaded = load({"name": "test", "blocks": entries, **scenario})
    ready = plan(loaded, {b.name: b.model for b in blocks}, options.pop("feedthrough", None))
    observers = options.pop("observers", ((), ()))
    with Session(Mocked(ready)) as session:
        given = {b.name: b for b in blocks}
        return evaluated(session, Options(**{"compiled": False, **options}), observers, lambda _: given)
