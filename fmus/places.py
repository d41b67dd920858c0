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


def package_name(folder: Path) -> str:
    """The name by which the package in this folder is imported: `allocator.bounded` for `allocator/bounded`."""
    name, above = folder.name, folder.parent
    while (above / "__init__.py").exists():
        name, above = f"{above.name}.{name}", above.parent
    return name


def of_block(folder: Path) -> list[Path]:
    """All files in a block's folder, sorted, but its C and the blocks that have their own folders in it."""
    apart = {folder / "native", *filter(_is_block, folder.iterdir())}
    found = (path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc")
    return sorted(path for path in found if apart.isdisjoint(path.parents))


def _is_block(folder: Path) -> bool:
    return (folder / "native").is_dir() or (folder / "block.py").is_file()
