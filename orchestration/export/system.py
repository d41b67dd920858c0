"""A scenario as other tools see it: components, wires between single variables, values, all by FMI's names.

`flat` opens the FMUs and runs one step, since the inputs that are connected get their values of t = 0 as start values:
most tools exchange nothing in initialization mode.

Longer than 250 lines: `flat` goes over the links once, for wires, values and their order in initialization mode alike.
"""

from __future__ import annotations

import atexit
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from fmus.changes import packed
from fmus.interface import SAMPLE_PERIOD
from fmus.native.toolchain import CompilerError

from .. import temporary
from ..errors import InputError
from ..fmu.archive import Fmu, open_fmu
from ..fmu.model import Model, Variable
from ..fmu.starts import scalars_of, starts_of
from ..scenario.load import load
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from ..session.open import Opened, open_fmus, open_scenario
from ..session.run import whole
from ..system.wiring import Node
from .changes import KEPT, Changed, Values, changes, delays_by_order, start_of, with_inputs

Scalar = float | int | bool | str

_ONLY_OURS = ", which only this orchestrator can do; cannot be exported"
_LEFT_OUT = ("expect", "holds", "consistency", "figures", "timeline", "phases", "live", "cycle", "data", "record")
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
    fed: frozenset[str] = frozenset()
    """Parameters that are inputs in the exported copy of the FMU."""

    def content(self, numbers: bool = False) -> bytes:
        """Returns the bytes of the exported FMU, whose enumerations are integers where `numbers`."""
        return with_inputs(self.fmu, self.fed, numbers)


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
    initial: tuple[Wire, ...]
    """Those that pass values on in initialization mode, in the order in which outputs depend on each other."""
    delays: tuple[str, ...] | None = None
    """The inputs whose delay this order makes; None where the annotation keeps rates, faults and delays."""


def flat(scenario: Scenario, kept: bool = False) -> System:
    """Returns the system of a scenario. Raises InputError where it cannot run or needs more than wires; BlockError.

    A block with `every` has its rate as sample_period; faults, delays and the timeline are FMUs before the blocks to
    which they happen. With `kept` all this stays in the annotation of an archive, for orchestrate.
    """
    for name, entry in scenario.blocks.items():
        if entry.python is not None:
            text = f"{entry.python} is a law in Python; archives and containers hold FMUs only"
            made = f"orchestrate new {entry.interface or name} FOLDER --from {entry.python} makes one of it"
            raise InputError(scenario.error(("blocks", name, "python"), text, remedy=made))
    opened = open_scenario(scenario, open_fmus(scenario, here=False))
    fmus, prepared, plan = opened.fmus, opened.prepared, opened.plan
    _check(scenario, opened)
    names: dict[Node, str] = {}
    for name, fmu in fmus.items():
        names |= _names(name, fmu, prepared.models[name].variables)
    owns = {name: starts_of(fmu.description, prepared.models[name]) for name, fmu in fmus.items()}
    initial = _initial(scenario)
    values = Values(start_of(plan, owns), initial)

    def variable(node: Node) -> Variable:
        return prepared.models[node.block].variables[node.element.variable].at([node.element.position])

    changed = {} if kept else changes(scenario, plan, names, variable, values)
    channels = {node: (c.name, channel) for c in changed.values() for node, channel in c.channels.items()}
    fed: dict[str, dict[Node, Scalar]] = {name: {} for name in fmus}
    levels = {node: level for level, nodes in enumerate(plan.order.levels) for node in nodes}
    at_level: dict[Wire, int] = {}
    wires = []
    for link in plan.wiring.links:
        for source, target in zip(link.source, link.target, strict=True):
            before = channels.get(target)
            end = (target.block, names[target]) if before is None else (before[0], before[1].inner)
            wires.append(Wire((source.block, names[source]), end, link.factor, link.offset))
            if not link.delayed or (before is not None and changed[target.block].channels[target].delayed):
                at_level[wires[-1]] = levels.get(source, len(plan.order.levels))  # what only a delay takes comes last
            given = [start.value for start in plan.starts[target.block] if start.element == target.element]
            if before is None and not link.delayed:
                given = [_converted(initial[source], link.factor, link.offset)]
            fed[target.block].update(dict.fromkeys([target], *given) if given else {})
    for node, (name, channel) in channels.items():
        wires.append(Wire((name, channel.name), (node.block, names[node]), 1.0, 0.0))
        incoming = next((level for wire, level in at_level.items() if wire.target == (name, channel.inner)), -1)
        at_level[wires[-1]] = -1 if channel.delayed else incoming
        fed[node.block][node] = _typed(channel.start, variable(node).type)
    components = []
    targets = {wire.target for wire in wires}
    for name, fmu in fmus.items():
        model = prepared.models[name]
        nodes = [
            (n, kind) for kind in ("input", "output", "parameter") for v in model.of(kind) for n in _nodes(name, v)
        ]
        ports = [
            Port(names[n], variable(n), "output" if kind == "output" else "input")
            for n, kind in nodes
            if kind == "output" or (name, names[n]) in targets
        ]
        values_of = {Node(name, start.element): start.value for start in plan.starts[name]} | fed[name]
        if (every := scenario.blocks[name].every) > 1 and (SAMPLE_PERIOD in model.variables or not kept):
            values_of[_sampling(scenario, name, model)] = float(every * Fraction(repr(scenario.step)))
        exported = [
            Value(names[n], variable(n), value)
            for n, value in values_of.items()
            if _worth(variable(n), value, owns[name].get(n.element))
        ]
        others = [(n, k) for k in ("input", "parameter") for n, kind in nodes if kind == k]
        free = [Port(names[n], variable(n), kind) for n, kind in others if (name, names[n]) not in targets]
        during = {n.element.variable for n, kind in nodes if kind == "parameter" and (name, names[n]) in targets}
        set_ = frozenset(names[n] for n, _ in nodes if n.element.variable in during)
        components.append(Component(name, fmu, tuple(ports), tuple(exported), tuple(free), set_))
    components += [_inserted(scenario, block, c, variable) for block, c in changed.items()]
    order = [n for block in plan.order.blocks for n in ([changed[block].name] if block in changed else []) + [block]]
    delays = None if kept else tuple(delays_by_order(plan, changed))
    passing = sorted(at_level, key=at_level.__getitem__)
    return System(scenario, tuple(components), tuple(wires), tuple(order), tuple(passing), delays)


def _check(scenario: Scenario, opened: Opened) -> None:
    """Refuses FMUs that no other tool could run as we do. Raises InputError."""
    for name in scenario.blocks:
        fit = opened.prepared.fits.get(name)
        if opened.fmus[name].model.prefix != "fmi2":
            message = f"it is an FMU of FMI {opened.fmus[name].model.fmi}; what is exported holds FMUs of FMI 2.0 only"
            raise InputError(scenario.error(("blocks", name, "fmu"), message))
        if substeps := opened.rates.substeps.get(name):
            message = (
                f"its FMU cannot vary its step of {float(substeps.length):.10g} s and is stepped {substeps.count} "
            )
            raise InputError(scenario.error(("blocks", name), f"{message}times in each of the scenario's{_ONLY_OURS}"))
        if fit is not None and not fit.identical:
            message = f"its ports are mapped to those of another interface{_ONLY_OURS}"
            raise InputError(scenario.error(("blocks", name), message))


def _inserted(scenario: Scenario, block: str, changed: Changed, variable: Callable[[Node], Variable]) -> Component:
    """The component before a block, whose FMU stands in a folder that goes when the process ends. Raises InputError."""
    about = f"Faults, delays and set values before {block} in {scenario.name}"
    try:
        fmu = packed(list(changed.channels.values()), about, float(scenario.duration), float(scenario.step))
    except (CompilerError, ValueError) as error:
        raise InputError(f"the FMU before {block} cannot be made: {error}") from None
    folder = temporary.make("orchestrate-changes-")
    atexit.register(temporary.remove, folder)
    path = folder / f"{changed.name}.fmu"
    path.write_bytes(fmu)
    ports, values = [], []
    for node, channel in changed.channels.items():
        about_it = variable(node)
        ports.append(Port(channel.name, about_it, "output"))
        if channel.fed:
            ports.append(Port(channel.inner, about_it, "input"))
            values.append(Value(channel.inner, about_it, _typed(channel.given, about_it.type)))
    return Component(changed.name, open_fmu(path), tuple(ports), tuple(values), ())


def _typed(value: float, kind: str) -> Scalar:
    return bool(value) if kind == "boolean" else value if kind == "real" else round(value)


def _sampling(scenario: Scenario, block: str, model: Model) -> Node:
    """The parameter by which a block keeps its rate where the host steps all at one. Raises InputError."""
    if (variable := model.variables.get(SAMPLE_PERIOD)) is None:
        message = f"other tools step all blocks at one rate, and its FMU has no parameter {SAMPLE_PERIOD}"
        remedy = "no 'every', and the slowest block's step for all"
        raise InputError(scenario.error(("blocks", block, "every"), f"{message}; remedy: {remedy}; {KEPT}"))
    if (key := scenario.given(block).get(SAMPLE_PERIOD)) is not None:
        raise InputError(scenario.error(key, "every says it, too; expected one of the two"))
    return Node(block, variable.elements[0])


def _initial(scenario: Scenario) -> dict[Node, Scalar]:
    """Returns every output at t = 0."""
    keys: list[Key] = [(key,) for key in _LEFT_OUT]
    longest = max(entry.every for entry in scenario.blocks.values())
    source = scenario.source.without(keys).with_value("duration", longest * scenario.step, "export")
    at_once = [scenario.source.data["faults"][i] for i, fault in enumerate(scenario.faults) if fault.at == 0.0]
    short = load(source.with_value("faults", at_once, "export") if scenario.faults else source)
    result = whole(short)
    if result.failure is not None:
        raise result.failure
    outputs: dict[Node, Scalar] = {}
    for node in result.columns:
        kind = result.models[node.block].variables[node.element.variable].type
        outputs[node] = _typed(float(result.column(node)[0]), kind)
    return outputs


def _converted(value: Scalar, factor: float, offset: float) -> Scalar:
    return value if (factor, offset) == (1.0, 0.0) else factor * float(value) + offset


def _worth(variable: Variable, value: Scalar, own: object) -> bool:
    """Returns whether a value is written. Several tools cannot set text and items, so those that are the FMU's own are
    not.
    """
    return variable.type not in ("string", "enumeration") or value != own


def _nodes(block: str, variable: Variable) -> list[Node]:
    return [Node(block, element) for element in variable.elements]


def _names(block: str, fmu: Fmu, variables: Mapping[str, Variable]) -> dict[Node, str]:
    """FMI's name of each element: `R_NB[2,3]` where the label is `R_NB[2][3]`."""
    return {Node(block, e): name for name, _, e in scalars_of(fmu.description, fmu.model) if e.variable in variables}
