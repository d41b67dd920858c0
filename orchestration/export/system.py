"""A scenario as other tools see it: components, wires between single variables, values, all by FMI's names.

`flat` opens the FMUs and runs one step, since the inputs that are connected get their values of t = 0 as start values:
most tools exchange nothing in initialization mode.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from fmus.interface import SAMPLE_PERIOD

from ..errors import InputError
from ..fmu.archive import Fmu
from ..fmu.model import Model, Variable
from ..fmu.starts import scalars_of, starts_of
from ..scenario.load import load
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..session.open import open_fmus, open_scenario
from ..session.plan import Plan
from ..session.run import whole
from ..system.wiring import Node

Scalar = float | int | bool | str

_ONLY_OURS = ", which only this orchestrator can do; cannot be exported"
_KEPT = "with --ssp, --for-orchestrate keeps it in an annotation, which no other tool reads"
_LEFT_OUT = ("expect", "holds", "consistency", "figures", "faults", "timeline", "phases", "cycle", "record")
"""What the step for the values of t = 0 goes without."""


@dataclass(frozen=True)
class Port:
    """An input or output of a component: one scalar variable of its FMU."""

    name: str
    variable: Variable
    kind: str


@dataclass(frozen=True)
class Value:
    """A start value; an item of an enumeration by its number."""

    name: str
    variable: Variable
    value: Scalar


@dataclass(frozen=True)
class Component:
    """An instance of an FMU with its ports: the inputs that are connected, and all outputs."""

    name: str
    fmu: Fmu
    ports: tuple[Port, ...]
    values: tuple[Value, ...]
    """The scenario's start values, and the values at t = 0 of the inputs that are connected."""
    free: tuple[Port, ...]
    """Its parameters, and the inputs that are not connected."""


@dataclass(frozen=True)
class Wire:
    """target = factor * source + offset."""

    source: tuple[str, str]
    target: tuple[str, str]
    factor: float
    offset: float


@dataclass(frozen=True)
class System:
    scenario: Scenario
    components: tuple[Component, ...]
    wires: tuple[Wire, ...]
    order: tuple[str, ...]
    """The components in the order in which the scenario steps them."""


def check_plain(scenario: Scenario, what: str, remedy: str = "") -> None:
    """Refuses what only this orchestrator does, and what `what` would leave out without a word. Raises InputError."""
    remedies = f"; {remedy}" if remedy else ""
    if scenario.faults:
        raise InputError(scenario.error(("faults",), f"{what} has no faults{remedies}"))
    if any(entry.set for entry in scenario.timeline):
        message = f"{what} has no commands at given times{remedies}"
        raise InputError(scenario.error(("timeline",), message))


def flat(scenario: Scenario, rates_kept: bool = False) -> System:
    """Returns the system of a scenario. Raises InputError where it cannot run or needs more than wires; BlockError.

    A block with `every` has its rate as sample_period. One that lacks this parameter is refused, unless the rates are
    kept for orchestrate.
    """
    opened = open_scenario(scenario, open_fmus(scenario, here=False))
    fmus, prepared, plan = opened.fmus, opened.prepared, opened.plan
    for name in scenario.blocks:
        fit = prepared.fits.get(name)
        if fmus[name].model.prefix != "fmi2":
            message = f"it is an FMU of FMI {fmus[name].model.fmi}; what is exported holds FMUs of FMI 2.0 only"
            raise InputError(scenario.error(("blocks", name, "fmu"), message))
        if substeps := opened.rates.substeps.get(name):
            message = (
                f"its FMU cannot vary its step of {float(substeps.length):.10g} s and is stepped {substeps.count} "
            )
            raise InputError(scenario.error(("blocks", name), f"{message}times in each of the scenario's{_ONLY_OURS}"))
        if fit is not None and not fit.identical:
            message = f"its ports are mapped to those of another interface{_ONLY_OURS}"
            raise InputError(scenario.error(("blocks", name), message))
    if not rates_kept:
        _check_delays(scenario, plan)
    names = {name: _names(name, fmu, prepared.models[name].variables) for name, fmu in fmus.items()}
    initial = _initial(scenario)
    fed: dict[str, dict[Node, Scalar]] = {name: {} for name in fmus}
    wires = []
    for link in plan.wiring.links:
        for source, target in zip(link.source, link.target, strict=True):
            ends = [(node.block, names[node.block][node]) for node in (source, target)]
            wires.append(Wire(ends[0], ends[1], link.factor, link.offset))
            given = [start.value for start in plan.starts[target.block] if start.element == target.element]
            if not link.delayed:
                given = [_converted(initial[source], link.factor, link.offset)]
            fed[target.block].update(dict.fromkeys([target], *given) if given else {})
    targets = {wire.target for wire in wires}
    components = []
    for name, fmu in fmus.items():
        model = prepared.models[name]
        nodes = [(n, v, kind) for kind in ("input", "output") for v in model.of(kind) for n in _nodes(name, v)]
        ports = [
            Port(names[name][n], v.at([n.element.position]), kind)
            for n, v, kind in nodes
            if kind == "output" or (name, names[name][n]) in targets
        ]
        values = {Node(name, start.element): start.value for start in plan.starts[name]} | fed[name]
        if (every := scenario.blocks[name].every) > 1 and (SAMPLE_PERIOD in model.variables or not rates_kept):
            values[_sampling(scenario, name, model)] = float(every * Fraction(repr(scenario.step)))
        own = starts_of(fmu.description, model)
        exported = [
            Value(names[name][n], model.variables[n.element.variable].at([n.element.position]), value)
            for n, value in values.items()
            if _worth(model.variables[n.element.variable], value, own.get(n.element))
        ]
        others = [(n, v, kind) for kind in ("input", "parameter") for v in model.of(kind) for n in _nodes(name, v)]
        free = [
            Port(names[name][n], v.at([n.element.position]), kind)
            for n, v, kind in others
            if (name, names[name][n]) not in targets
        ]
        components.append(Component(name, fmu, tuple(ports), tuple(exported), tuple(free)))
    return System(scenario, tuple(components), tuple(wires), tuple(plan.order.blocks))


def _check_delays(scenario: Scenario, plan: Plan) -> None:
    """Refuses delays that the order of the steps does not make by itself. Raises InputError.

    A host that steps one block after the other gives a block what those behind it had at the step before.
    """
    place = {name: i for i, name in enumerate(plan.order.blocks)}
    for link in (link for link in plan.wiring.links if link.delayed):
        source, target = link.source[0].block, link.target[0].block
        if scenario.exchange != "sequential" or place[source] < place[target]:
            message = f"{target} is stepped after {source}, so no order of the steps delays this connection"
            if scenario.exchange != "sequential":
                message = (
                    f"{source} -> {target}: a parallel exchange delays every connection by a step, and this by two"
                )
            raise InputError(scenario.error(("delays",), f"{message}; {_KEPT}"))


def _sampling(scenario: Scenario, block: str, model: Model) -> Node:
    """The parameter by which a block keeps its rate where the host steps all at one. Raises InputError."""
    if (variable := model.variables.get(SAMPLE_PERIOD)) is None:
        message = f"other tools step all blocks at one rate, and its FMU has no parameter {SAMPLE_PERIOD}"
        remedy = "no 'every', and the slowest block's step for all"
        raise InputError(scenario.error(("blocks", block, "every"), f"{message}; remedy: {remedy}; {_KEPT}"))
    if (key := scenario.given(block).get(SAMPLE_PERIOD)) is not None:
        raise InputError(scenario.error(key, "every says it, too; expected one of the two"))
    return Node(block, variable.elements[0])


def _initial(scenario: Scenario) -> dict[Node, Scalar]:
    """Returns every output at t = 0."""
    keys: list[Key] = [(key,) for key in _LEFT_OUT]
    longest = max(entry.every for entry in scenario.blocks.values())
    short = load(scenario.source.without(keys).with_value("duration", longest * scenario.step, "export"))
    result = whole(short)
    if result.failure is not None:
        raise result.failure
    outputs: dict[Node, Scalar] = {}
    for node in result.columns:
        kind = result.models[node.block].variables[node.element.variable].type
        value = float(result.column(node)[0])
        outputs[node] = bool(value) if kind == "boolean" else value if kind == "real" else round(value)
    return outputs


def _converted(value: Scalar, factor: float, offset: float) -> Scalar:
    return value if (factor, offset) == (1.0, 0.0) else factor * float(value) + offset


def _worth(variable: Variable, value: Scalar, own: object) -> bool:
    """Whether a value is written. Several tools cannot set text and items, so those that are the FMU's own are not."""
    return variable.type not in ("string", "enumeration") or value != own


def _nodes(block: str, variable: Variable) -> list[Node]:
    return [Node(block, element) for element in variable.elements]


def _names(block: str, fmu: Fmu, variables: Mapping[str, Variable]) -> dict[Node, str]:
    """FMI's name of each element: `R_NB[2,3]` where the label is `R_NB[2][3]`."""
    return {Node(block, e): name for name, _, e in scalars_of(fmu.description, fmu.model) if e.variable in variables}
