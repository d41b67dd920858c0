"""OMSimulator's exchange, imitated with FMPy: all blocks are stepped with what was set at t, then values are passed on.

They are passed on in the order of the declared dependencies, each Get after the Sets before it. This is what its
co-simulation master does with an SSP archive; all blocks have one rate.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Slave
from numpy.typing import NDArray

from orchestration import Scenario, load
from orchestration.export.system import Component, flat

_LEFT_OUT = ("expect", "figures", "holds", "faults", "cycle", "record")


def plain(path: Path, step: float, duration: float) -> Scenario:
    """A scenario without rates and faults, as other tools have it."""
    source = load(path).source.without([(key,) for key in _LEFT_OUT])
    for block in source.data["blocks"]:
        source = source.with_entry(("blocks", block, "every"), None)
    return load(source.with_value("step", step, "").with_value("duration", duration, ""))


class _Instance:
    def __init__(self, component: Component, folder: Path) -> None:
        description = component.fmu.description
        component.fmu.extract(folder)
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=component.name,
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self._variables = {
            v.name: (v.valueReference, v.type.replace("Enumeration", "Integer")) for v in description.modelVariables
        }

    def set(self, name: str, value: Any) -> None:
        reference, kind = self._variables[name]
        getattr(self.fmu, f"set{kind}")([reference], [value])

    def get(self, name: str) -> Any:
        reference, kind = self._variables[name]
        return getattr(self.fmu, f"get{kind}")([reference])[0]


def imitated(scenario: Scenario, signal: str, folder: Path, late: str = "") -> NDArray[np.float64]:
    """A scalar signal at every step. Values for inputs that begin with `late` are passed on a sample later."""
    system = flat(scenario)
    block, _, name = signal.partition(".")
    instances = {c.name: _Instance(c, folder / c.name) for c in system.components}
    for component in system.components:
        for value in component.values:
            instances[component.name].set(value.name, value.value)
        instances[component.name].fmu.enterInitializationMode()
    before: dict[Any, Any] = {}

    def pass_on() -> None:
        for wire in (wire for one in system.order for wire in system.wires if wire.source[0] == one):
            value = instances[wire.source[0]].get(wire.source[1])
            assert (wire.factor, wire.offset) == (1.0, 0.0)
            if late and wire.target[1].startswith(late):
                value, before[wire] = before.get(wire, value), value
            instances[wire.target[0]].set(wire.target[1], value)

    pass_on()
    for instance in instances.values():
        instance.fmu.exitInitializationMode()
    step = float(scenario.step)
    values = [instances[block].get(name)]
    for i in range(round(scenario.duration / step)):
        for one in system.order:
            instances[one].fmu.doStep(i * step, step)
        pass_on()
        values.append(instances[block].get(name))
    return np.array(values)
