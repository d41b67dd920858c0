"""What a scenario does to the inputs of its blocks, as FMUs that other tools step: faults, delays, the timeline.

A block whose inputs are changed on their way gets an FMU of fmus/changes before it, `allocator_changes`, through which
they go. A tunable parameter that is set during a run is an input in the exported copy of its FMU.
"""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from xml.etree import ElementTree as ET

from fmus.changes import KINDS, Channel, Operation

from ..errors import InputError
from ..fmu.archive import Fmu
from ..fmu.model import Element, Variable
from ..master.injection import at_start
from ..scenario.scenario import Scenario
from ..session.plan import Plan
from ..system.disturbances import Disturbance
from ..system.faults import Setting
from ..system.wiring import Link, Node

_KINDS = dict(zip(("cut", "bias", "freeze"), KINDS, strict=True))
KEPT = "with --ssp, --for-orchestrate keeps it in an annotation, which no other tool reads"


@dataclass
class Changed:
    """The changes before one block."""

    name: str
    """Of the component."""
    channels: dict[Node, Channel] = field(default_factory=dict)
    """By the input of the block, or its parameter."""


@dataclass(frozen=True)
class Values:
    """Values at the elements of a loop at t = 0: start values and the outputs."""

    start: Callable[[Node], float]
    initial: Mapping[Node, float | int | bool | str]

    def of(self, link: Link, source: Node) -> float:
        value = float(self.initial[source])
        return value if (link.factor, link.offset) == (1.0, 0.0) else link.factor * value + link.offset


def changes(
    scenario: Scenario, plan: Plan, names: Mapping[Node, str], variable: Callable[[Node], Variable], values: Values
) -> dict[str, Changed]:
    """Returns the changes by block. Raises InputError for what no FMU before a block does."""
    places = {name: i for i, name in enumerate(plan.order.blocks)}
    ends = {t: (link, s) for link in plan.wiring.links for s, t in zip(link.source, link.target, strict=True)}
    step = Fraction(repr(scenario.step))
    made: dict[str, Changed] = {}

    def add(node: Node, **more: object) -> None:
        about = variable(node)
        unit = None if about.unit is None else (about.unit.name, about.unit.base_unit)
        unit = unit if about.type == "real" else None
        channel = Channel(names[node], about.type, unit=unit, items=about.items, **more)  # type: ignore[arg-type]
        made.setdefault(node.block, Changed(_free(f"{node.block}_changes", places))).channels[node] = channel

    for node, (link, source) in ends.items():
        faults = [d for d in plan.faults.disturbances if d.target == node]
        delayed = link.delayed and places[source.block] < places[node.block]
        if faults or delayed:
            given = values.of(link, source) if delayed or not link.delayed else values.start(node)
            start = values.start(node) if link.delayed else at_start(plan.faults, node, given)
            rows = tuple(_of_signal(d, places, scenario.blocks[node.block].every, step) for d in faults)
            add(node, start=start, operations=rows, fed=True, delayed=delayed, given=given)
    for node, settings in _by_node(plan.faults.settings).items():
        if variable(node).type == "string":
            raise InputError(f"{settings[0][0].name}: text is set during the run, and no FMU passes text on; {KEPT}")
        rows = tuple(_of_value(s, value, scenario.blocks[node.block].every, step) for s, value in settings)
        add(node, start=values.start(node), operations=rows)
    delayed = any(link.delayed for link in plan.wiring.links)
    if (made or delayed) and scenario.exchange != "sequential":
        key = ("delays",) if scenario.delays else ("faults",) if scenario.faults else ("timeline",)
        message = "a parallel exchange delays what goes through an FMU by one more step"
        raise InputError(scenario.error(key, f"{message}; remedy: exchange: sequential; {KEPT}"))
    return made


def _free(name: str, taken: Mapping[str, int]) -> str:
    return name if name not in taken else _free(f"{name}_", taken)


def _by_node(settings: list[Setting]) -> dict[Node, list[tuple[Setting, float]]]:
    """The values of each element: those of the timeline, and over them those of faults, in the order of their times."""
    found: dict[Node, list[tuple[Setting, float]]] = {}
    for setting in sorted(settings, key=lambda s: (s.of_fault, s.span[0])):
        for element, value in setting.values:
            number = 0.0 if isinstance(value, str) else float(value)
            found.setdefault(Node(setting.block, element), []).append((setting, number))
    return found


def _of_signal(fault: Disturbance, places: Mapping[str, int], every: int, step: Fraction) -> Operation:
    """A fault as it acts at each base step; it begins where the receiver first sees it."""
    behind = fault.behind(False, places)
    first = -(-(fault.span[0] + behind) // every) * every - behind
    return Operation(
        _KINDS[fault.kind],
        float(first * step),
        _time(fault.span[1], step),
        fault.value,
        before=bool(behind),
        at_start=fault.span[0] == 0 and not fault.delayed,
    )


def _of_value(setting: Setting, value: float, every: int, step: Fraction) -> Operation:
    """A value that is set between two steps of the block."""
    first, until = (math.ceil(c / every) * every if c < math.inf else c for c in setting.span)
    return Operation("replace", _time(first, step), _time(until, step), value, before=True)


def _time(count: float, step: Fraction) -> float:
    return float(int(count) * step) if count < math.inf else math.inf


def with_inputs(fmu: Fmu, names: frozenset[str], numbers: bool) -> bytes:
    """Returns the FMU with these parameters declared as inputs, and enumerations as integers where `numbers`.

    Its code, which sets both alike, is untouched.
    """
    if not (names or numbers):
        return fmu.path.read_bytes()
    buffer = io.BytesIO()
    with zipfile.ZipFile(fmu.path) as source, zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as target:
        for entry in source.infolist():
            data = source.read(entry)
            here = entry.filename == "modelDescription.xml"
            target.writestr(entry, _declared(data, names, numbers) if here else data)
    return buffer.getvalue()


def _declared(xml: bytes, names: frozenset[str], numbers: bool) -> bytes:
    root = ET.fromstring(xml)
    for entry in root.iter("ScalarVariable"):
        if entry.get("name") in names:
            real = entry.find("Real") is not None
            entry.attrib.pop("initial", None)
            entry.attrib |= {"causality": "input", "variability": "continuous" if real else "discrete"}
        if numbers and (kind := entry.find("Enumeration")) is not None:
            kind.tag = "Integer"
            kind.attrib.pop("declaredType", None)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True)


def delays_by_order(plan: Plan, changed: Mapping[str, Changed]) -> list[str]:
    """The inputs whose delay the order of the steps makes, as the archive's annotation names them.

    What a later block gives to an FMU of changes is among them: that FMU hands through what it gets, and plans of ours
    would step it behind the other.
    """
    places = {name: i for i, name in enumerate(plan.order.blocks)}
    delays = []
    for link in plan.wiring.links:
        for source, node in zip(link.source, link.target, strict=True):
            before = changed.get(node.block)
            channel = before.channels.get(node) if before else None
            if before is None or channel is None:
                variable = plan.models[node.block].variables[node.element.variable]
                delays += [f"{node.block}.{variable.label(node.element.position)}"] * link.delayed
            elif not channel.delayed and places[source.block] >= places[node.block]:
                delays.append(f"{before.name}.{channel.inner.replace(',', '][')}")
    return delays


def start_of(plan: Plan, own: Mapping[str, Mapping[Element, float | int | bool | str]]) -> Callable[[Node], float]:
    """The start value of an element: the scenario's, or else that of its FMU."""
    given = {Node(block, start.element): start.value for block, starts in plan.starts.items() for start in starts}

    def start(node: Node) -> float:
        value = given.get(node, own[node.block].get(node.element, 0.0))
        return 0.0 if isinstance(value, str) else float(value)

    return start
