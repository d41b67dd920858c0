"""Where things are: in the repository, or, once installed, in what the wheel brings along ready-made.

A wheel holds, in the folder `ready` of this package: native/*.fmu, python/*.fmu, loop/*, scenarios/, LICENSE.
"""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path

REPOSITORY = Path(__file__).parents[1]
READY = Path(__file__).parent / "ready"


def installed() -> bool:
    """Whether this is an installed wheel, with no sources beside the packages and no folder to build into."""
    return READY.is_dir()


def shared(name: str) -> Path:
    """A file or folder that stands in the repository's root: `scenarios`, `LICENSE`."""
    return (READY if installed() else REPOSITORY) / name


def ready(name: str) -> Path | None:
    """What a wheel brings ready-made, such as `native/plant.fmu`; None in the repository."""
    path = READY / name
    return path if path.exists() else None


def work() -> Path:
    """Where to build what is missing: build/ in the repository, or the user's cache."""
    if not installed():
        return REPOSITORY / "build"
    from platformdirs import user_cache_path

    return user_cache_path("attitude-cosim", appauthor=False) / version("attitude-cosim")
