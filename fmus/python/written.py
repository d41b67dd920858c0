"""Functions that make the elements of a variable, as FMI sees them, from a block's value.

Carried by every Python FMU, so it needs the standard library and numpy only. Tests: tests/fmus/python/test_slave.py.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..variables import Variable

Writer = Callable[[Any], Any]


def _only(*types: type) -> Writer:
    """The first type, of values of these types alone: bool(None) would be false, and str(None) a text."""
    first: Writer = types[0]

    def convert(value: Any) -> Any:
        if not isinstance(value, types):
            raise TypeError
        return first(value)

    return convert


SCALARS: dict[str, Writer] = {
    "real": float,
    "integer": int,
    "boolean": _only(bool, np.bool_, int),
    "string": _only(str),
}
"""By FMI's types: each raises TypeError, ValueError or OverflowError for a value that is not of it."""


def writer(variable: Variable) -> Writer:
    """Returns the function that makes a variable's elements from its value: a list from an array."""
    if len(variable.shape) == 1:
        return np.ndarray.tolist
    if variable.shape:
        return lambda value: value.ravel().tolist()
    if variable.type == "enumeration":
        return lambda value: variable.items.index(value) + 1
    return SCALARS[variable.type]
