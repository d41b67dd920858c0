"""An FMU as a host drives it, through FMPy: values by name, and the log."""

from __future__ import annotations

import itertools
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

_ERROR = 3
_KINDS = {"Enumeration": "Integer"}


class Host:
    """One instance. `set` and `get` take a variable as a whole: `set("rate", [1, 2])`."""

    def __init__(self, path: Path, logging: bool = False, folder: Path | None = None) -> None:
        self.description = fmpy.read_model_description(str(path))
        self.folder = Path(fmpy.extract(str(path), str(folder) if folder else None))
        self.log: list[tuple[int, str, str]] = []
        self._callbacks = fmi2CallbackFunctions(
            logger=fmi2CallbackLoggerTYPE(self._message),
            allocateMemory=defaultCallbacks.allocateMemory,
            freeMemory=defaultCallbacks.freeMemory,
        )
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=str(self.folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="instance",
        )
        self.fmu.instantiate(callbacks=self._callbacks, loggingOn=logging)
        self._variables: dict[str, list[Any]] = {}
        for variable in self.description.modelVariables:
            self._variables.setdefault(variable.name.partition("[")[0], []).append(variable)

    def _message(self, environment: Any, instance: bytes, status: int, category: bytes, message: bytes) -> None:
        self.log.append((status, category.decode(), message.decode()))

    def started(self, **starts: Any) -> Host:
        """Through initialization, with these start values."""
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        for name, value in starts.items():
            self.set(name, value)
        self.fmu.exitInitializationMode()
        return self

    def set(self, name: str, value: Any) -> None:
        variables = self._variables[name]
        values = list(_flat(value))
        kind = _KINDS.get(variables[0].type, variables[0].type)
        getattr(self.fmu, f"set{kind}")([v.valueReference for v in variables], values)

    def get(self, name: str) -> Any:
        variables = self._variables[name]
        kind = _KINDS.get(variables[0].type, variables[0].type)
        values = getattr(self.fmu, f"get{kind}")([v.valueReference for v in variables])
        values = [v.decode() if isinstance(v, bytes) else v for v in values]
        return values if "[" in variables[0].name else values[0]

    def step(self, k: int, h: float = 0.1, count: int = 1) -> None:
        """Steps k, k + 1 ... of length h."""
        for i in range(k, k + count):
            self.fmu.doStep(currentCommunicationPoint=i * h, communicationStepSize=h)

    def outputs(self) -> dict[str, Any]:
        names = {n: v for n, v in self._variables.items() if v[0].causality == "output"}
        return {name: self.get(name) for name in names}

    def refuses(self, call: Callable[[], object]) -> str:
        """Expects fmi2Error, and the one message that tells why though logging is off; returns it."""
        before = len(self.log)
        with pytest.raises(FMICallException) as caught:
            call()
        assert caught.value.status == _ERROR
        ((status, category, message),) = self.log[before:]
        assert (status, category) == (_ERROR, "logStatusError")
        return message

    def serialized(self) -> bytes:
        """The FMU state as bytes; the state itself is freed."""
        state = self.fmu.getFMUstate()
        data = self.fmu.serializeFMUstate(state)
        self.fmu.freeFMUstate(state)
        return bytes(data)

    def restore(self, data: bytes) -> None:
        """Deserializes bytes and goes on from there."""
        state = self.fmu.deSerializeFMUstate(data)
        try:
            self.fmu.setFMUstate(state)
        finally:
            self.fmu.freeFMUstate(state)

    def close(self) -> None:
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self) -> Host:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _flat(value: Any) -> Iterator[Any]:
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        yield from itertools.chain.from_iterable(_flat(item) for item in value)
    else:
        yield value
