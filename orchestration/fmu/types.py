"""FMI's types: what each is in a block's model, which functions exchange it, and how C holds it."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

Type = Literal["real", "integer", "boolean", "string", "enumeration"]
CODES = ("f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "?")
"""NumPy's names of the C types of numbers."""


class Native(NamedTuple):
    """A type of FMI."""

    type: Type
    function: str
    """What its functions are named after: fmi2GetReal, fmi3SetUInt8."""
    code: str
    """One of CODES; "O" for text."""

    @property
    def whole(self) -> bool:
        """Returns whether it holds whole numbers only, of which a Boolean is none."""
        return self.type in ("integer", "enumeration")

    @property
    def bounds(self) -> tuple[float, float]:
        """Range of its values: from the first to below the second, as doubles."""
        if self.whole:
            limits = np.iinfo(self.code)
            return float(limits.min), float(limits.max + 1)
        if self.code == "f4":
            limit = float(np.finfo("f4").max)
            return -limit, float(np.nextafter(limit, np.inf))
        return -np.inf, np.inf


_WHOLE = {f"{sign}Int{bits}": f"{sign.lower() or 'i'}{bits // 8}" for sign in ("", "U") for bits in (8, 16, 32, 64)}
NATIVES: dict[int, dict[str, Native]] = {
    2: {
        "Real": Native("real", "Real", "f8"),
        "Integer": Native("integer", "Integer", "i4"),
        "Enumeration": Native("enumeration", "Integer", "i4"),
        "Boolean": Native("boolean", "Boolean", "i4"),
        "String": Native("string", "String", "O"),
    },
    3: {
        "Float64": Native("real", "Float64", "f8"),
        "Float32": Native("real", "Float32", "f4"),
        **{name: Native("integer", name, code) for name, code in _WHOLE.items()},
        "Enumeration": Native("enumeration", "Int64", "i8"),
        "Boolean": Native("boolean", "Boolean", "?"),
        "String": Native("string", "String", "O"),
    },
}
"""By FMI's major version and the name in modelDescription.xml."""
