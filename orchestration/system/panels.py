"""The panels of a scenario's figures, held against its blocks: which elements they need, and in which unit."""

from __future__ import annotations

from collections.abc import Mapping

from ..errors import InputError, Problem
from ..fmu.model import Model, Variable
from ..quantities import ONE, QuantityError, Unit, parse_unit, value_in
from ..scenario.figures import Panel
from ..scenario.references import Reference
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from . import signals
from .wiring import Node


def check(scenario: Scenario, models: Mapping[str, Model]) -> list[Node]:
    """The elements of the signals that the figures need. Raises InputError, which names the place in the scenario."""
    needed: dict[Node, None] = {}
    errors: list[Problem] = []
    first: dict[str, int] = {}
    for i, entry in enumerate(scenario.figures):
        if (same := first.setdefault(entry.name, i)) != i:
            message = f"is that of figures[{same + 1}], too; expected another, since it names the file"
            errors.append(scenario.error(("figures", i, "name"), message))
        wanted: list[tuple[Key, Reference]] = [
            (("figures", i, key), getattr(entry, key)) for key in ("shade", "mark") if getattr(entry, key)
        ]
        for j, panel in enumerate(entry.panels):
            place = ("figures", i, "panels", j)
            wanted += [((*place, "signals", k), name) for k, name in enumerate(panel.signals)]
            try:
                variable, _ = signals.find(scenario, (*place, "signals", 0), panel.signals[0], models)
                unit = unit_of(panel, variable)
                for line in panel.lines:
                    value_in(line, unit)
            except QuantityError as error:
                errors.append(scenario.error(place, str(error)))
            except InputError:
                pass  # reported below
        if entry.window and not 0.0 <= entry.window[0] < entry.window[1]:
            errors.append(scenario.error(("figures", i, "window"), "expected two times, the second after the first"))
        for key, name in wanted:
            try:
                needed.update(dict.fromkeys(signals.find(scenario, key, name, models)[1]))
            except InputError as error:
                errors += error.problems
    if errors:
        raise InputError(*errors)
    return list(needed)


def unit_of(panel: Panel, variable: Variable) -> Unit:
    """The unit of a panel's axis. Raises QuantityError where it does not fit."""
    own = variable.unit or ONE
    if panel.unit is None:
        return variable.display_unit or own
    unit = parse_unit(panel.unit)
    if not own.fits(unit):
        raise QuantityError(f"the unit {panel.unit!r} does not fit {str(own)!r} of {panel.signals[0]}")
    return unit
