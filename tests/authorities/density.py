"""The density's table against the model that it was made from."""

from __future__ import annotations

import math

from tests.authorities.registry import authority


def _register(f107: float) -> None:
    def measure() -> float:
        from tests.plant.test_density import deviation_along_orbit

        return 100.0 * math.expm1(deviation_along_orbit(f107, "2009-08-10T00:00:00Z", 4.0, 600e3))

    measure.__name__ = f"density_{f107:.0f}"
    authority(
        "Density",
        f"Density along the paper's orbit at F10.7 = {f107:.0f}: largest deviation",
        source="pymsis, NRLMSISE-00 (version 0)",
        unit="%",
        tolerance=3.0,
        needs="pymsis:pymsis",
    )(measure)


for _f107 in (70.0, 150.0, 230.0):
    _register(_f107)
