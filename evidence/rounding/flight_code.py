"""The C of a block, called for many samples at once."""

from __future__ import annotations

import ctypes
import tempfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from fmus import native
from fmus.block import Block
from fmus.interface import Interface
from fmus.native.toolchain import compile_library, host_platform
from orchestration import InputError

from .bound import Doubles

BATCH = Path(__file__).with_name("batch.c")
_KINDS = {"real": "f8", "boolean": "?"}


def layout(interface: Interface, causality: Any) -> np.dtype[Any]:
    """Returns the layout of the C structure."""
    fields = [(v.name, _KINDS.get(v.type, "i4"), v.shape or ()) for v in interface.of(causality)]
    return np.dtype(fields, align=True)


class FlightCode:
    """A block's library of the sources as they are, or of a copy in which `change` has been made of a file's text."""

    def __init__(self, block: str, change: tuple[str, str, str] | None = None) -> None:
        whole, host = Block.named(block), host_platform()
        self.interface = whole.interface
        self._folder = tempfile.TemporaryDirectory()
        folder = Path(self._folder.name)
        sources, includes = native.lay_out(whole.interface, whole.folder, "{0}", folder)
        if change is not None:
            name, before, after = change
            text = next(p for p in sources if p.name == name).read_text("utf-8")
            if text.count(before) != 1:
                raise InputError(f"{name}: expected {before!r} once, found it {text.count(before)} times")
            (folder / name).write_text(text.replace(before, after), "utf-8")
            sources = [folder / name if p.name == name else p for p in sources]
        path = folder / f"batch_{block}.so"
        path.write_bytes(compile_library(block, [*sources, BATCH], includes, [host])[host])
        self._library = ctypes.CDLL(str(path))
        self._library.batch.restype = ctypes.c_size_t
        self.doubles = Doubles(self._elementary("atan2"), self._elementary("log1p"))

    def parameters(self, **changes: Any) -> tuple[Any, SimpleNamespace]:
        """The structure with start values and changes, and the values; enumerations by their items' names."""
        record = np.zeros(1, layout(self.interface, "parameter"))
        values = {v.name: changes.get(v.name, v.start) for v in self.interface.of("parameter")}
        for v in self.interface.of("parameter"):
            x = values[v.name]
            record[v.name] = v.items.index(x) + 1 if v.type == "enumeration" else x
        return record, SimpleNamespace(**values)

    def inputs(self, n: int) -> Any:
        """n inputs with start values."""
        record = np.zeros(n, layout(self.interface, "input"))
        for v in self.interface.of("input"):
            record[v.name] = v.start
        return record

    def outputs(self, parameters: Any, inputs: Any) -> Any:
        """Returns the outputs of each input but the first, after a start with the one before it. Raises InputError
        where one is refused.
        """
        n = len(inputs) - 1
        y = np.zeros(n, layout(self.interface, "output"))
        done = self._library.batch(_address(parameters), _address(inputs), ctypes.c_size_t(n), _address(y))
        if done != n:
            raise InputError(f"{self.interface.name}: refused sample {done}: {inputs[done : done + 2]}")
        return y

    def _elementary(self, name: str) -> Any:
        def of(*arguments: Any) -> Any:
            given = [np.ascontiguousarray(x, float) for x in np.broadcast_arrays(*arguments)]
            result = np.empty_like(given[0])
            size = ctypes.c_size_t(result.size)
            getattr(self._library, f"batch_{name}")(*map(_address, given), size, _address(result))
            return result

        return of


def _address(x: Any) -> Any:
    return ctypes.c_void_p(x.ctypes.data)
