"""Numbers from outside that the plant needs at run time: read from PyPI packages, carried by a built FMU.

In a source tree the field's are read from the packages that maintain them; the density's table, which takes
a fit to make, is kept beside this module. `dump` gives all of them as files; the build places these beside
this module inside the FMU, where they are preferred, so that a running FMU needs none of the packages.
This is the one place of the plant that reads files.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from ..atmosphere import DensityModel
from ..geomagnetic import FieldModel
from . import density, field_models

PACKAGES = ("pygeomag", "ppigrf")
"""The packages whose numbers a built FMU carries."""

_HERE = Path(__file__).parent


@cache
def field_model(name: str) -> FieldModel:
    """The geomagnetic field model of this name: one of `field_models.NAMES`."""
    carried = _HERE / field_models.FILE
    return field_models.parse(carried.read_bytes(), name) if carried.exists() else field_models.from_package(name)


@cache
def density_model() -> DensityModel:
    """The table of NRLMSISE-00's density."""
    return density.parse((_HERE / density.FILE).read_bytes())


def dump() -> dict[str, bytes]:
    """The files that an FMU carries, by name."""
    return {field_models.FILE: field_models.dump(), density.FILE: (_HERE / density.FILE).read_bytes()}
