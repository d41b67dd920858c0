"""An FMU's library: loaded by FMPy, and an instance of it, in either version of FMI; slave.py does the rest."""

from __future__ import annotations

import atexit
import ctypes as c
import os
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave, fmi3IntermediateUpdateCallback, fmi3LogMessageCallback

from .log import Log

Calls = Iterator[tuple[str, tuple[Any, ...]]]
"""Functions of FMI by their names, with what they take behind the instance."""

_libraries: dict[Path, Any] = {}
"""Libraries that instances share, by the folder of their FMU. Reading the signatures of FMPy's functions takes 2 ms each."""


_NEEDED_3 = (
    *("fmi3InstantiateCoSimulation", "fmi3FreeInstance", "fmi3EnterInitializationMode"),
    *("fmi3ExitInitializationMode", "fmi3DoStep", "fmi3Terminate"),
)


class _Library3(FMU3Slave):
    """Loads a library that lacks functions which are not called here, such as those of model exchange."""

    def _loadFunctions(self) -> None:
        """FMPy would look for every function of FMI 3.0. Raises AttributeError."""
        for name in _NEEDED_3:
            getattr(self.dll, name)

    def instantiate(self, log: Log) -> None:
        self.callbacks = fmi3LogMessageCallback(log.receive)
        function = self.dll["fmi3InstantiateCoSimulation"]
        function.restype = c.c_void_p
        texts = self.instanceName, self.guid, os.path.join(self.unzipDirectory, "resources", "")
        visible, event_mode, early_return, logging = c.c_bool(), c.c_bool(), c.c_bool(), c.c_bool(True)
        no_intermediate_variables = None, c.c_size_t(0)
        self.component = function(
            *(text.encode() for text in texts),
            *(visible, logging, event_mode, early_return, *no_intermediate_variables),
            *(None, self.callbacks, fmi3IntermediateUpdateCallback()),
        )

    def freeInstance(self) -> None:
        function = self.dll["fmi3FreeInstance"]
        function.restype = None
        function(c.c_void_p(self.component))
        self.freeLibrary()


def _initialize_2(stop: float) -> Calls:
    yield "fmi2SetupExperiment", (0, c.c_double(0.0), c.c_double(0.0), 1, c.c_double(stop))
    yield "fmi2EnterInitializationMode", ()


def _initialize_3(stop: float) -> Calls:
    no_tolerance, start = (c.c_bool(False), c.c_double(0.0)), c.c_double(0.0)
    yield "fmi3EnterInitializationMode", (*no_tolerance, start, c.c_bool(True), c.c_double(stop))


@dataclass(frozen=True)
class Version:
    """What differs between the versions of FMI."""

    library: Any
    """FMPy's class."""
    instantiate: str
    token: str
    """What says that a description belongs to its binary."""
    create: Callable[[Any, Log], None]
    initialize: Callable[[float], Calls]
    """What takes an instance into initialization mode, for a run from 0 to the given end."""
    three: bool
    """Whether a Get or Set is told the number of values, besides that of references, and whether DoStep has answers."""


VERSIONS = {
    "fmi2": Version(
        FMU2Slave,
        "fmi2Instantiate",
        "GUID",
        lambda fmu, log: fmu.instantiate(callbacks=log.callbacks, loggingOn=True),
        _initialize_2,
        three=False,
    ),
    "fmi3": Version(
        _Library3,
        "fmi3InstantiateCoSimulation",
        "instantiation token",
        lambda fmu, log: fmu.instantiate(log),
        _initialize_3,
        three=True,
    ),
}
"""By what the names of FMI's functions begin with."""


def load(version: Version, name: str, guid: str, identifier: str, folder: Path, shared: bool) -> Any:
    """The library of an FMU that is unpacked in `folder`; raises what FMPy raises.

    `shared`: it is loaded once for all instances, and stays until the process ends.
    """
    if not shared:
        return _loaded(version, name, guid, identifier, folder)
    if folder not in _libraries:
        _libraries[folder] = _loaded(version, name, guid, identifier, folder)
        atexit.register(_libraries[folder].freeLibrary)  # Windows removes no file of a library that is loaded
    library = copy(_libraries[folder])
    library.instanceName = name
    return library


def _loaded(version: Version, name: str, guid: str, identifier: str, folder: Path) -> Any:
    here = os.getcwd()
    try:
        return version.library(guid=guid, modelIdentifier=identifier, unzipDirectory=str(folder), instanceName=name)
    finally:
        os.chdir(here)  # FMPy leaves the folder changed where loading fails
