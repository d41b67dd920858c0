"""The C structures of a block's ports, for calls of its C without an FMU's shell between."""

from __future__ import annotations

import ctypes
from ctypes import c_bool, c_char, c_double, c_int32
from functools import cache
from typing import Any, Literal

import numpy as np

from fmus.interface import load
from fmus.native.generate import TEXT_SIZE


@cache
def record(block: str, causality: Literal["parameter", "input", "output"]) -> Any:
    """The C structure of the block's ports."""
    kinds: dict[str, Any] = {"real": c_double, "boolean": c_bool, "string": c_char * TEXT_SIZE}
    fields = []
    for v in load(block).of(causality):
        kind = kinds.get(v.type, c_int32)
        fields.append((v.name, kind * len(v.elements) if v.shape else kind))
    return type(causality, (ctypes.Structure,), {"_fields_": fields})


def filled(block: str, causality: Literal["parameter", "input"], **changes: Any) -> Any:
    """The structure with start values, and changes."""
    values = record(block, causality)()
    for v in load(block).of(causality):
        value = changes.get(v.name, v.start)
        if v.shape:
            getattr(values, v.name)[:] = np.ravel(value).tolist()
        elif v.type == "string":
            setattr(values, v.name, value.encode())
        elif v.type == "enumeration" and isinstance(value, str):
            setattr(values, v.name, v.items.index(value) + 1)
        else:
            setattr(values, v.name, value)
    return values
