"""What others know: outside numbers and programs, and how far the plant lies from them."""

from __future__ import annotations

from importlib import import_module

from .registry import REGISTRY, Authority

MODULES = (
    "torque_free",
    "orekit",
    "basilisk",
    "basilisk_wheels",
    "libration",
    "structure",
    "integrator",
    "field",
    "density",
    "orbits",
    "sun",
)


def load() -> list[Authority]:
    """All authorities, by subject."""
    for module in MODULES:
        import_module(f"{__name__}.{module}")
    subjects = list(dict.fromkeys(authority.subject for authority in REGISTRY))
    return sorted(REGISTRY, key=lambda authority: subjects.index(authority.subject))
