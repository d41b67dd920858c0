"""A host of a few lines: steps the components of an unpacked SSP archive one after the other, with FMPy alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp import ssd


class _Instance:
    def __init__(self, component: Any, folder: Path) -> None:
        about = fmpy.read_model_description(str(folder / component.source))
        self._variables = {v.name: v for v in about.modelVariables}
        self.fmu = FMU2Slave(
            guid=about.guid,
            unzipDirectory=fmpy.extract(str(folder / component.source)),
            modelIdentifier=about.coSimulation.modelIdentifier,
            instanceName=component.name,
        )
        self.fmu.instantiate()
        for values in (v for binding in component.parameterBindings for v in binding.parameterValues):
            for parameter in values.parameters:
                self.set(parameter.name, parameter.value)
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, name: str, value: Any) -> None:
        v = self._variables[name]
        if v.type == "Boolean":
            value = value in (True, "true", "1", 1)
        elif v.type in ("Integer", "Enumeration"):
            items = {item.name: int(item.value) for item in v.declaredType.items} if v.type == "Enumeration" else {}
            value = items.get(value, value) if isinstance(value, str) else value
            value = int(value)
        elif v.type == "Real":
            value = float(value)
        kind = {"Enumeration": "Integer"}.get(v.type, v.type)
        getattr(self.fmu, f"set{kind}")([v.valueReference], [value])

    def get(self, name: str) -> Any:
        v = self._variables[name]
        return getattr(self.fmu, f"get{ {'Enumeration': 'Integer'}.get(v.type, v.type) }")([v.valueReference])[0]


def flown(archive: Path, step: float, count: int, signals: list[str], adds_up: bool = False) -> list[list[Any]]:
    """The signals after each of `count` steps of an archive whose units need no conversion."""
    system = ssd.read_ssd(str(archive)).system
    folder = Path(fmpy.extract(str(archive)))
    instances = {component.name: _Instance(component, folder) for component in system.elements}
    wires = [(c.startElement, c.startConnector, c.endElement, c.endConnector) for c in system.connections]
    rows, time = [], 0.0
    for k in range(count):
        begin = time if adds_up else k * step
        for name, instance in instances.items():
            for source, output, target, input_ in wires:
                if target == name:
                    instance.set(input_, instances[source].get(output))
            instance.fmu.doStep(begin, step)
        time += step
        rows.append([instances[s.partition(".")[0]].get(s.partition(".")[2]) for s in signals])
    for instance in instances.values():
        instance.fmu.terminate()
        instance.fmu.freeInstance()
    return rows
