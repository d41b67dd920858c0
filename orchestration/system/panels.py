"""The panels of a scenario's figures, held against its blocks: which elements they need, and in which unit."""

from __future__ import annotations

from collections.abc import Mapping

from ..errors import Problems
from ..fmu.model import Model, Variable
from ..quantities import ONE, QuantityError, Unit, parse_unit, value_in
from ..scenario.figures import Panel
from ..scenario.scenario import Scenario
from ..scenario.source import Key
from . import signals
from .wiring import Node


def check(scenario: Scenario, models: Mapping[str, Model]) -> list[Node]:
    """The elements of the signals that the figures need. Raises InputError, which names the place in the scenario."""
    needed: dict[Node, None] = {}
    first: dict[str, int] = {}
    with Problems() as problems:
        for i, entry in enumerate(scenario.figures):
            if (same := first.setdefault(entry.name, i)) != i:
                text = f"is that of figures[{same + 1}], too; expected another, since it names the file"
                problems.append(scenario.error(("figures", i, "name"), text))
            if entry.window and not 0.0 <= entry.window[0] < entry.window[1]:
                expected = "two times, the second after the first"
                problems.append(scenario.error(("figures", i, "window"), expected=expected))
            marks = [(("figures", i, key), getattr(entry, key)) for key in ("shade", "mark") if getattr(entry, key)]
            for key, name in marks:
                with problems.gathered():
                    needed.update(dict.fromkeys(signals.find(scenario, key, name, models)[1]))
            for j, panel in enumerate(entry.panels):
                place: Key = ("figures", i, "panels", j)
                variables = []
                for k, name in enumerate(panel.signals):
                    with problems.gathered():
                        variable, nodes = signals.find(scenario, (*place, "signals", k), name, models)
                        needed.update(dict.fromkeys(nodes))
                        variables.append(variable)
                if len(variables) == len(panel.signals):
                    with problems.gathered(), scenario.naming(place):
                        unit = unit_of(panel, variables[0])
                        for line in panel.lines:
                            value_in(line, unit)
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
