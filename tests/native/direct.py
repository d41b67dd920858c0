"""A native block as flight software calls it: check, prepare, start, outputs and step, with no FMI shell between."""

from __future__ import annotations

from ctypes import byref, c_char_p, c_double
from typing import Any, Literal

from fmus.interface import Interface, load
from tests.structures import filled, record

from . import driver


class Direct:
    """Calls of one block, which has one state. Each returns the name of the variable that is refused, or None."""

    def __init__(self, block: str) -> None:
        self.block = block
        self.interface: Interface = load(block)
        self.lib = driver.library(block)
        for name in ("check", "start", "outputs", "step"):
            getattr(self.lib, f"direct_{name}").restype = c_char_p
        self.y = record(block, "output")()

    def check(self, **parameters: Any) -> str | None:
        return _name(self.lib.direct_check(byref(filled(self.block, "parameter", **parameters))))

    def start(self, **values: Any) -> str | None:
        """With start values but for these parameters and inputs; the parameters are not checked."""
        return _name(self.lib.direct_start(byref(self._of("parameter", values)), byref(self._of("input", values))))

    def outputs(self, **inputs: Any) -> str | None:
        return _name(self.lib.direct_outputs(byref(filled(self.block, "input", **inputs)), byref(self.y)))

    def step(self, h: float = 0.1, **inputs: Any) -> str | None:
        u = filled(self.block, "input", **inputs)
        return _name(self.lib.direct_step(byref(u), c_double(h), byref(self.y)))

    def _of(self, causality: Literal["parameter", "input"], values: dict[str, Any]) -> Any:
        names = {v.name for v in self.interface.of(causality)}
        return filled(self.block, causality, **{k: v for k, v in values.items() if k in names})


def _name(found: bytes | None) -> str | None:
    return found.decode() if found is not None else None
