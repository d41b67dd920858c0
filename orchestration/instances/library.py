"""An FMU's library, and an instance of it, in either version of FMI; slave.py does the rest.

FMPy could do it, but takes 60 ms to be imported, and 2 ms for each library to look at the signatures of its own
functions.
"""

from __future__ import annotations

import atexit
import ctypes as c
import os
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .. import temporary
from ..fmu import zipped
from ..fmu.archive import Fmu
from ..interrupt import held
from .log import Log
from .record.recorder import Record, Recorder, recorded

Calls = Iterator[tuple[str, tuple[Any, ...]]]
"""Functions of FMI by their names, with what they take behind the instance."""
Arguments = tuple[Any, ...]

if sys.platform == "win32":
    _unload = c.windll.kernel32.FreeLibrary
else:
    _unload = c.CDLL(None).dlclose
_unload.argtypes = (c.c_void_p,)


def _arguments_2(name: bytes, guid: bytes, folder: Path, log: Log) -> Arguments:
    co_simulation, visible, logging = c.c_int(1), c.c_int(0), c.c_int(1)
    return (
        name,
        co_simulation,
        guid,
        (folder / "resources").as_uri().encode(),
        c.byref(log.callbacks_2),
        visible,
        logging,
    )


def _arguments_3(name: bytes, token: bytes, folder: Path, log: Log) -> Arguments:
    visible, logging, event_mode, early_return = c.c_bool(), c.c_bool(True), c.c_bool(), c.c_bool()
    no_intermediate_variables, no_environment, no_update = (None, c.c_size_t(0)), None, None
    resources = os.path.join(folder, "resources", "").encode()
    flags = visible, logging, event_mode, early_return
    return name, token, resources, *flags, *no_intermediate_variables, no_environment, log.message_3, no_update


def _initialize_2(stop: float) -> Calls:
    yield "fmi2SetupExperiment", (0, c.c_double(0.0), c.c_double(0.0), 1, c.c_double(stop))
    yield "fmi2EnterInitializationMode", ()


def _initialize_3(stop: float) -> Calls:
    no_tolerance, start = (c.c_bool(False), c.c_double(0.0)), c.c_double(0.0)
    yield "fmi3EnterInitializationMode", (*no_tolerance, start, c.c_bool(True), c.c_double(stop))


@dataclass(frozen=True)
class Version:
    """Differences between the versions of FMI."""

    prefix: str
    """What the names of its functions begin with."""
    instantiate: str
    needed: tuple[str, ...]
    """The further functions without which a library is refused, without prefix; it may lack those that are not called
    here."""
    token: str
    """What says that a description belongs to its binary."""
    arguments: Callable[[bytes, bytes, Path, Log], Arguments]
    """Of `instantiate`: of the instance's name, its token, the folder of the FMU and its log."""
    initialize: Callable[[float], Calls]
    """What takes an instance into initialization mode, for a run from 0 to the given end."""
    state: str
    """What its functions of states end with."""
    three: bool
    """Whether a Get or Set is told the number of values, besides that of references, and whether DoStep has answers."""


_NEEDED = "FreeInstance", "EnterInitializationMode", "ExitInitializationMode", "DoStep", "Terminate"
VERSIONS = {
    "fmi2": Version(
        "fmi2",
        "fmi2Instantiate",
        ("SetupExperiment", *_NEEDED),
        "GUID",
        _arguments_2,
        _initialize_2,
        "state",
        three=False,
    ),
    "fmi3": Version(
        "fmi3",
        "fmi3InstantiateCoSimulation",
        _NEEDED,
        "instantiation token",
        _arguments_3,
        _initialize_3,
        "State",
        three=True,
    ),
}
"""By what the names of FMI's functions begin with."""


class Own:
    """The libraries of the project's own native FMUs, each unpacked and loaded once for all instances of this process.

    Such an FMU has no state but that of its instances, needs no file but its library and writes none, which is not
    known of any other FMU. They are unloaded and removed when the process ends, not by one that was forked from it.
    Their functions return soon, so they keep Python's lock, which saves a tenth of a step of the loop in Python.
    """

    def __init__(self) -> None:
        self._process, self._loaded = os.getpid(), dict[str, tuple[c.CDLL, Path]]()
        self._lock = threading.Lock()

    def load(self, fmu: Fmu, version: Version) -> tuple[c.CDLL, Path]:
        """Returns the library and the folder in which its FMU is unpacked. Raises as `Library`, and InputError."""
        with self._lock:
            if fmu.sha256 not in self._loaded:
                with held():
                    folder = temporary.make()
                    atexit.register(self._remove, folder)
                resources = (name for name in zipped.names(fmu.path, "FMU") if name.startswith("resources/"))
                fmu.extract(folder, [fmu.library, *resources])
                self._loaded[fmu.sha256] = _loaded(folder / fmu.library, version, c.PyDLL), folder
                # What is registered later is called earlier, and Windows removes no file of a library that is loaded.
                atexit.register(_unload, self._loaded[fmu.sha256][0]._handle)
        return self._loaded[fmu.sha256]

    def _remove(self, folder: Path) -> None:
        if os.getpid() == self._process:
            with held(firmly=True):
                temporary.remove(folder)


OWN = Own()
_chdir = threading.Lock()
"""Held while a library is loaded from the folder in which it stands, which is one for the whole process."""


class Library:
    """A library that is loaded, and the instance that is made of it."""

    def __init__(self, version: Version, fmu: Fmu, folder: Path | None, record: Record | None = None) -> None:
        """Loads it from the folder in which its FMU is unpacked; None for one that is shared with all instances of it.

        Its calls are recorded where a record is given. Raises OSError where it cannot be loaded, and AttributeError
        where it lacks a function.
        """
        self._version, self._shared = version, folder is None
        self.component: int | None = None
        self.dll: c.CDLL | Recorder
        if folder is None:
            self.dll, self._folder = OWN.load(fmu, version)
        else:
            self.dll, self._folder = _loaded(folder / fmu.library, version), folder
        if record is not None:
            self.dll = recorded(self.dll, record)

    def instantiate(self, name: str, token: str, log: Log) -> None:
        """Leaves the instance in `component`; None where the FMU gives none."""
        function = self.dll[self._version.instantiate]
        function.restype = c.c_void_p
        log.folder = self._folder
        if isinstance(self.dll, Recorder):
            self.dll.next()
        self.component = function(*self._version.arguments(name.encode(), token.encode(), self._folder, log))

    def free(self) -> None:
        """Frees the instance, and unloads the library."""
        function = self.dll[f"{self._version.prefix}FreeInstance"]
        function.restype = None
        function(c.c_void_p(self.component))
        self.unload()

    def unload(self) -> None:
        """Unloads a library that is not shared."""
        if isinstance(self.dll, Recorder):
            self.dll.close()
        if not self._shared:
            _unload(self.dll._handle)


def _loaded(path: Path, version: Version, kind: type[c.CDLL] = c.CDLL) -> c.CDLL:
    with _chdir:
        here = os.getcwd()
        os.chdir(path.parent)  # where some libraries look for others
        try:
            dll = kind(str(path))
        finally:
            os.chdir(here)
    for name in (version.instantiate, *(f"{version.prefix}{name}" for name in version.needed)):
        getattr(dll, name)
    return dll
