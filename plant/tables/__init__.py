"""Numbers from outside that the plant needs at run time: read from PyPI packages, carried by a built FMU.

In a source tree they are read from the packages that maintain them. `dump` gives the same numbers as
files; the build places these beside this module inside the FMU, where they are preferred, so that a
running FMU needs none of the packages. This is the one place of the plant that reads files.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from ..geomagnetic import FieldModel
from . import field_models

_HERE = Path(__file__).parent


@cache
def field_model(name: str) -> FieldModel:
    """The geomagnetic field model of this name: one of `field_models.NAMES`."""
    carried = _HERE / field_models.FILE
    return field_models.parse(carried.read_bytes(), name) if carried.exists() else field_models.from_package(name)


def dump() -> dict[str, bytes]:
    """The files that an FMU carries, by name."""
    return {field_models.FILE: field_models.dump()}
