"""The sliders of a live page: which start values each changes, and between which ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import Problems, hint
from ..fmu.model import Element, Model, NameUnknown, Variable
from ..quantities import ONE, QuantityError, parse_unit, value_in, with_unit
from ..rotation import about
from ..scenario.live import Slider
from ..scenario.references import Name
from ..scenario.scenario import Scenario
from ..session.plan import Plan
from ..system.starts import taken
from ..system.wiring import Node

_SAME = 1e-9
"""By how much an element of a rotation about an axis may differ from what the scenario has."""


@dataclass(frozen=True)
class Control:
    """A slider as the page has it: positions in its unit, port value = (position - offset)/factor."""

    slider: Slider
    unit: str
    factor: float
    offset: float
    least: float
    most: float
    value: float
    """Where it stands for the scenario's own values."""
    nodes: list[list[Node]]
    """What it changes, for each block that has it: the elements in their order."""


def controls(scenario: Scenario, plan: Plan) -> list[Control]:
    """Returns the sliders of a scenario. Raises InputError with everything that is wrong."""
    made: list[Control] = []
    with Problems() as problems:
        for number, slider in enumerate(scenario.live.sliders if scenario.live else ()):
            try:
                made.append(_control(slider, scenario, plan))
            except (QuantityError, NameUnknown) as error:
                problems.append(scenario.error(("live", "sliders", number), f"{slider.start}: {error}"))
    return made


def start_value(plan: Plan, node: Node) -> Any:
    """Returns what an element starts with: the scenario's value, or its FMU's own."""
    given = {start.element: start.value for start in plan.starts.get(node.block, ())}
    return given.get(node.element, plan.models[node.block].starts.get(node.element, 0.0))


def _control(slider: Slider, scenario: Scenario, plan: Plan) -> Control:
    block, _, text = slider.start.rpartition(".")
    ends = _of_block(block, Name(text), plan.models) if block else _shared(Name(text), scenario, plan.models)
    variable, _ = ends[0][1]
    if variable.type not in ("real", "integer"):
        raise QuantityError(f"is {variable.type}; expected a number")
    own = variable.unit or ONE
    unit = parse_unit(slider.unit) if slider.unit else variable.display_unit or own
    if slider.measure == "rotation" and not slider.unit:
        unit = parse_unit("deg")
    radian = parse_unit("rad")
    base = radian if slider.measure == "rotation" else own
    if not base.fits(unit):
        raise QuantityError(f"the unit {str(unit)!r} does not fit {str(base)!r}")
    factor, offset = base.conversion(unit)
    if slider.measure == "norm" and offset:
        raise QuantityError(f"a norm has no unit such as {str(unit)!r}, whose zero is elsewhere")
    nodes = [[Node(name, Element(v.name, p)) for p in positions] for name, (v, positions) in ends]
    value = _measured(slider, [float(start_value(plan, node)) for node in nodes[0]])
    least, most = (value_in(end, base) for end in (slider.least, slider.most))
    low, high, now = (factor * v + offset for v in (least, most, value))
    shown = [with_unit(v, str(unit)) for v in (low, high, now)]
    if not least < most:
        raise QuantityError(f"expected 'least' below 'most', found {shown[0]} and {shown[1]}")
    if slider.measure == "norm" and least < 0.0:
        raise QuantityError(f"least: expected zero or more, since a norm is never negative; found {shown[0]}")
    if slider.measure == "rotation" and max(-least, most) > 2.0 * math.pi + _SAME:
        raise QuantityError(f"expected angles within one turn, -360 deg to 360 deg; found {shown[0]} and {shown[1]}")
    if not least <= value <= most:
        raise QuantityError(f"expected the scenario's own value, {shown[2]}, between {shown[0]} and {shown[1]}")
    if slider.measure == "element":
        _within(ends, least, most, lambda v: with_unit(factor * v + offset, str(unit)))
    return Control(slider, str(unit), factor, offset, low, high, now, nodes)


def _of_block(block: str, name: Name, models: Mapping[str, Model]) -> list[tuple[str, tuple[Variable, list[int]]]]:
    if block not in models:
        raise NameUnknown(f"there is no block {block!r}{hint(block, models)}")
    if name.variable in models[block].helpers:
        raise QuantityError("is worked out in Python, which the page has not; remedy: a parameter that it stands for")
    return [(block, models[block].find(block, name.variable, name.indices, ("parameter", "input")))]


def _shared(
    name: Name, scenario: Scenario, models: Mapping[str, Model]
) -> list[tuple[str, tuple[Variable, list[int]]]]:
    """Returns the parameter of each block that takes a shared value, but where the block's own start goes before it."""
    found = []
    for block, model in models.items():
        own = taken(model, name)
        if own is not None and own.variable not in {start.variable for start in scenario.blocks[block].start}:
            found += _of_block(block, own, models)
    if not found:
        raise NameUnknown("no block takes such a shared value")
    return found


def _measured(slider: Slider, values: list[float]) -> float:
    """Returns what the slider stands at, in the unit of the port, or rad.

    Raises QuantityError where it can stand nowhere.
    """
    if slider.measure == "element":
        if len(values) > 1:
            raise QuantityError(f"has {len(values)} elements; remedy: one of them, or 'measure: norm'")
        return values[0]
    if slider.measure == "norm":
        norm = math.hypot(*values)
        if norm == 0.0:
            raise QuantityError("is zero in the scenario, so its norm has no direction to grow in")
        return norm
    if len(values) != 9 or slider.axis is None:
        raise QuantityError("expected a rotation matrix of 3 x 3")
    axis = [a / math.hypot(*slider.axis) for a in slider.axis]
    skew = values[7] - values[5], values[2] - values[6], values[3] - values[1]
    sine = sum(a * s for a, s in zip(axis, skew, strict=True)) / 2
    angle = math.atan2(sine, (values[0] + values[4] + values[8] - 1) / 2)
    turned = about(list(slider.axis), angle)
    if any(abs(a - b) > _SAME for a, b in zip(turned, values, strict=True)):
        raise QuantityError("is no rotation about this axis in the scenario, which the slider would have to start from")
    return angle


def _within(
    ends: list[tuple[str, tuple[Variable, list[int]]]], least: float, most: float, text: Callable[[float], str]
) -> None:
    for _, (variable, positions) in ends:
        for position in positions:
            low = variable.minima[position] if variable.minima else -math.inf
            high = variable.maxima[position] if variable.maxima else math.inf
            if least < low or most > high:
                found = f"found {text(least)} and {text(most)}"
                raise QuantityError(f"expected ends within {text(low)} and {text(high)}, which its FMU allows; {found}")
