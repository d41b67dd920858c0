"""A host of a container for tests, by FMPy, with what the container logs."""

from __future__ import annotations

import shutil
from itertools import pairwise
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave


class Host:
    """An instance of a container, of an archive or of a folder into which one was unpacked."""

    def __init__(self, path: Path, name: str = "one", said: list[str] | None = None) -> None:
        about = fmpy.read_model_description(str(path))
        self.references = {v.name: v.valueReference for v in about.modelVariables}
        self.outputs = [v.valueReference for v in about.modelVariables if v.causality == "output" and v.type == "Real"]
        self.folder = path if path.is_dir() else Path(fmpy.extract(str(path), str(path.parent / f"unpacked {name}")))
        self.said = [] if said is None else said
        self.fmu = FMU2Slave(
            guid=about.guid,
            unzipDirectory=str(self.folder),
            modelIdentifier=about.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.calls = fmpy.fmi2.fmi2CallbackFunctions()
        self.calls.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(lambda *given: self.said.append(given[4].decode()))
        self.calls.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        self.calls.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self.fmu.instantiate(callbacks=self.calls)

    def begin(self, start: float = 0.0, **values: float) -> None:
        self.fmu.setupExperiment(startTime=start)
        for name, value in values.items():
            self.fmu.setReal([self.references[name.replace("__", ".")]], [value])
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def seen(self) -> list[float]:
        """All outputs that are real numbers."""
        return list(self.fmu.getReal(self.outputs))

    def speed(self) -> float:
        return self.fmu.getReal([self.references["motor.speed"]])[0]

    def fly(self, times: list[float]) -> list[float]:
        seen = []
        for begin, end in pairwise(times):
            self.fmu.doStep(begin, end - begin)
            seen.append(self.speed())
        return seen

    def end(self) -> None:
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)
