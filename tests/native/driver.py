"""Drives a native block's library through the C interface, as a host does: no FMU tool between."""

from __future__ import annotations

import ctypes
import tempfile
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fmus import native
from fmus.interface import Interface, load
from fmus.native.toolchain import FLAGS, FREESTANDING, PLATFORMS, compile_library, compiler, host_platform
from tests.blocks import folder as folder_of
from tests.once import built

ROOT = Path(__file__).parents[2]
GUID = "{00000000-0000-0000-0000-000000000000}"
OK, WARNING, DISCARD, ERROR, FATAL = range(5)

_LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)
_ALLOCATE = ctypes.CFUNCTYPE(c_void_p, c_size_t, c_size_t)
_FREE = ctypes.CFUNCTYPE(None, c_void_p)


class Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", _LOGGER),
        ("allocateMemory", _ALLOCATE),
        ("freeMemory", _FREE),
        ("stepFinished", c_void_p),
        ("environment", c_void_p),
    )


@cache
def library(block: str) -> ctypes.CDLL:
    """The block's library for this machine, of the sources as they are, with the functions of direct.c besides."""
    host = host_platform()
    with tempfile.TemporaryDirectory() as folder:
        sources, includes = native.lay_out(load(block), folder_of(block), GUID, Path(folder))
        sources.append(Path(__file__).with_name("direct.c"))

        def make(path: Path) -> None:
            path.write_bytes(compile_library(block, sources, includes, [host])[host])

        name = f"{block}{PLATFORMS[host].suffix}"
        return opened(built(name, [compiler(), *FLAGS, *sources, *includes, FREESTANDING], make))


def opened(path: Path) -> ctypes.CDLL:
    """A library with the types of the functions that need them."""
    lib = ctypes.CDLL(str(path))
    lib.fmi2Instantiate.restype = c_void_p
    lib.fmi2Instantiate.argtypes = [c_char_p, c_int, c_char_p, c_char_p, POINTER(Callbacks), c_int, c_int]
    lib.fmi2FreeInstance.restype = None
    lib.fmi2FreeInstance.argtypes = [c_void_p]
    lib.fmi2SetupExperiment.argtypes = [c_void_p, c_int, c_double, c_double, c_int, c_double]
    lib.fmi2DoStep.argtypes = [c_void_p, c_double, c_double, c_int]
    for name in ("EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset"):
        getattr(lib, f"fmi2{name}").argtypes = [c_void_p]
    for kind, c_type in (("Real", c_double), ("Integer", c_int), ("Boolean", c_int), ("String", c_char_p)):
        for verb in ("Get", "Set"):
            getattr(lib, f"fmi2{verb}{kind}").argtypes = [c_void_p, POINTER(c_uint), c_size_t, POINTER(c_type)]
    lib.fmi2SetDebugLogging.argtypes = [c_void_p, c_int, c_size_t, POINTER(c_char_p)]
    lib.fmi2GetFMUstate.argtypes = [c_void_p, POINTER(c_void_p)]
    lib.fmi2SetFMUstate.argtypes = [c_void_p, c_void_p]
    lib.fmi2FreeFMUstate.argtypes = [c_void_p, POINTER(c_void_p)]
    lib.fmi2SerializedFMUstateSize.argtypes = [c_void_p, c_void_p, POINTER(c_size_t)]
    lib.fmi2SerializeFMUstate.argtypes = [c_void_p, c_void_p, c_char_p, c_size_t]
    lib.fmi2DeSerializeFMUstate.argtypes = [c_void_p, c_char_p, c_size_t, POINTER(c_void_p)]
    lib.fmi2GetRealStatus.argtypes = [c_void_p, c_int, POINTER(c_double)]
    return lib


class Refused(Exception):
    """A call returned another status than fmi2OK; the text is what the block logged."""


class Instance:
    """One instance of a block. `memory` has the addresses that it holds."""

    def __init__(
        self,
        block: str | Interface,
        lib: ctypes.CDLL | None = None,
        name: str = "it",
        guid: str = GUID,
        log: bool = False,
    ):
        self.interface = load(block) if isinstance(block, str) else block
        self.lib = lib or library(self.interface.name)
        self.messages: list[tuple[int, str, str]] = []
        self.memory: dict[int, Any] = {}
        self.callbacks = Callbacks(_LOGGER(self._log), _ALLOCATE(self._allocate), _FREE(self._free), None, None)
        self.handle = self.lib.fmi2Instantiate(
            name.encode(), 1, guid.encode(), None, byref(self.callbacks), 0, int(log)
        )

    def _log(self, environment: int, name: bytes, status: int, category: bytes, message: bytes) -> None:
        self.messages.append((status, category.decode(), message.decode("utf-8", "replace")))

    def _allocate(self, count: int, size: int) -> int:
        block = ctypes.create_string_buffer(
            b"\xa5" * (count * size), count * size
        )  # not zero: the block must do without
        self.memory[ctypes.addressof(block)] = block
        return ctypes.addressof(block)

    def _free(self, address: int) -> None:
        block = self.memory.pop(address)
        ctypes.memset(block, 0xDD, len(block))

    def call(self, function: str, *arguments: Any) -> None:
        """Calls fmi2`function` on this instance; raises Refused unless it returns fmi2OK."""
        if status := getattr(self.lib, f"fmi2{function}")(self.handle, *arguments):
            raise Refused(f"{status}: {self.messages[-1][2] if self.messages else 'no message'}")

    def set(self, name: str, value: Any) -> None:
        """Sets a variable as a whole; an enumeration by its item's name."""
        variable = self.interface.variables[name]
        if variable.type == "enumeration" and isinstance(value, str):
            value = variable.items.index(value) + 1
        values = np.ravel(value).tolist() if variable.shape else [value]
        kind, c_type = _KINDS[variable.type]
        if kind == "String":
            values = [value.encode()]
        n = len(variable.elements)
        assert len(values) == n
        self.call(f"Set{kind}", (c_uint * n)(*variable.value_references), n, (c_type * n)(*values))

    def get(self, name: str) -> Any:
        """A variable as a whole, in its shape."""
        variable = self.interface.variables[name]
        kind, c_type = _KINDS[variable.type]
        n = len(variable.elements)
        values = (c_type * n)()
        self.call(f"Get{kind}", (c_uint * n)(*variable.value_references), n, values)
        if kind == "String":
            return values[0].decode()
        return np.array(values).reshape(variable.shape) if variable.shape else values[0]

    def set_all(self, record: Any) -> None:
        """Sets every field of a Python block's Parameters or Inputs that the interface has."""
        for name in record.__dataclass_fields__:
            if name in self.interface.variables:
                self.set(name, getattr(record, name))

    def initialize(self, start: float = 0.0) -> None:
        self.call("SetupExperiment", 0, 0.0, start, 0, 0.0)
        self.call("EnterInitializationMode")
        self.call("ExitInitializationMode")

    def step(self, t: float, h: float) -> None:
        self.call("DoStep", t, h, 1)

    def outputs(self) -> dict[str, Any]:
        return {v.name: self.get(v.name) for v in self.interface.of("output")}

    def free(self) -> None:
        if self.handle:
            self.lib.fmi2FreeInstance(self.handle)
            self.handle = None

    def __enter__(self) -> Instance:
        return self

    def __exit__(self, *_: object) -> None:
        self.free()


_KINDS: dict[str, tuple[str, Any]] = {
    "real": ("Real", c_double),
    "integer": ("Integer", c_int),
    "enumeration": ("Integer", c_int),
    "boolean": ("Boolean", c_int),
    "string": ("String", c_char_p),
}


def references(*numbers: int) -> Any:
    return (c_uint * len(numbers))(*numbers)


def running(block: str, **changes: Any) -> Instance:
    it = Instance(block)
    for name, value in changes.items():
        it.set(name, value)
    it.initialize()
    return it


def saved(it: Instance) -> c_void_p:
    state = c_void_p()
    it.call("GetFMUstate", byref(state))
    return state


def serialized(it: Instance, state: c_void_p) -> bytes:
    size = c_size_t()
    it.call("SerializedFMUstateSize", state, byref(size))
    data = ctypes.create_string_buffer(size.value)
    it.call("SerializeFMUstate", state, data, size.value)
    return data.raw


def same(a: dict[str, Any], b: dict[str, Any]) -> bool:
    return all(np.array_equal(a[name], b[name]) for name in a)


def assert_first_of_set(one: dict[str, Any], of_set: dict[str, Any]) -> None:
    """The outputs of a block with one part are, bit by bit, those of the block for a set of which this part alone is
    there; the others' are zero."""
    for name, value in one.items():
        other = of_set[name]
        if np.shape(other) != np.shape(value):
            assert not other[1:].any(), name
            other = other[0]
        assert np.array_equal(value, other), name
