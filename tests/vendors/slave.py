"""A vendor's FMU in Python: PythonFMU's slave, whose calls go to what the C one has as its library."""

from ctypes import (
    CDLL,
    CFUNCTYPE,
    POINTER,
    Structure,
    byref,
    c_char_p,
    c_double,
    c_int,
    c_size_t,
    c_uint,
    c_void_p,
    cast,
)
from pathlib import Path

from pythonfmu import Fmi2Slave

_LOGGER = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)


class _Callbacks(Structure):
    _fields_ = (
        ("logger", _LOGGER),
        ("allocate", c_void_p),
        ("free", c_void_p),
        ("finished", c_void_p),
        ("environment", c_void_p),
    )


@_LOGGER
def _silent(*_):
    pass


class Vendor(Fmi2Slave):
    opened = None

    def _call(self, name, *arguments):
        if self.opened is None:  # PythonFMU instantiates the class without the files, to pack it
            resources = str(self.resources).removeprefix("file://")
            library = CDLL(str(Path(resources) / "vendor"))
            library.fmi2Instantiate.restype = c_void_p
            library.fmi2DoStep.argtypes = (c_void_p, c_double, c_double, c_int)
            library.fmi2SetupExperiment.argtypes = (c_void_p, c_int, c_double, c_double, c_int, c_double)
            for call in (library.fmi2SetReal, library.fmi2GetReal):
                call.argtypes = (c_void_p, POINTER(c_uint), c_size_t, POINTER(c_double))
            allocate, free = (cast(getattr(CDLL(None), name), c_void_p) for name in ("calloc", "free"))
            self.callbacks = byref(_Callbacks(_silent, allocate, free))
            made = library.fmi2Instantiate(b"flight_sw", 1, b"vendor", resources.encode(), self.callbacks, 0, 0)
            self.opened = library, c_void_p(made)
        library, instance = self.opened
        if getattr(library, name)(instance, *arguments) > 1:
            raise RuntimeError(f"{name} failed")

    def setup_experiment(self, start_time, stop_time=None, tolerance=None):
        self._call("fmi2SetupExperiment", 0, 0.0, start_time, int(stop_time is not None), stop_time or 0.0)

    def enter_initialization_mode(self):
        self._call("fmi2EnterInitializationMode")

    def exit_initialization_mode(self):
        self._call("fmi2ExitInitializationMode")

    def set_real(self, references, values):
        n = len(references)
        self._call("fmi2SetReal", (c_uint * n)(*references), n, (c_double * n)(*values))

    def get_real(self, references):
        n = len(references)
        values = (c_double * n)()
        self._call("fmi2GetReal", (c_uint * n)(*references), n, values)
        return list(values)

    def do_step(self, current_time, step_size):
        self._call("fmi2DoStep", current_time, step_size, 1)
        return True

    def terminate(self):
        self._call("fmi2Terminate")
