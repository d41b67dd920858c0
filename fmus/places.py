"""Where files are: in the repository, or, once installed, in what the wheel brings along ready-made.

A wheel holds, in the folder `ready` of this package: native/*.fmu, python/*.fmu, loop/*, scenarios/, LICENSE.
Tests: tests/packaging/test_wheel.py.
"""

from __future__ import annotations

from pathlib import Path

from .versions import version_of

NAME = __name__.rpartition(".")[0]
"""The name by which this package is imported here: `fmus`, or `attitude_cosim.fmus` where a wheel is installed."""
PACKAGES = Path(__file__).parents[1]
"""Where this package and those of the blocks stand: the repository, or the folder of an installed copy."""
READY = Path(__file__).parent / "ready"


def installed() -> bool:
    """Returns whether this is an installed wheel, with no sources beside the packages and no folder to build into."""
    return READY.is_dir()


def shared(name: str) -> Path:
    """A file or folder that stands in the repository's root: `scenarios`, `LICENSE`."""
    return (READY if installed() else PACKAGES) / name


def ready(name: str) -> Path | None:
    """Returns the folder of a wheel's ready-made files, such as `native/plant.fmu`; None in the repository."""
    path = READY / name
    return path if path.exists() else None


def work() -> Path:
    """Returns where to build what is missing: out/ in the repository, or the user's cache."""
    if not installed():
        return PACKAGES / "out"
    # Here, since it takes 10 ms and only a build from a wheel needs it.
    from platformdirs import user_cache_path  # noqa: PLC0415

    return user_cache_path("attitude-cosim", appauthor=False) / (version_of("attitude-cosim") or "")
