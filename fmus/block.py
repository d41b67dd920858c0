"""A block as sources: its interface, and the folder of the package that implements it.
Tests: tests/fmus/test_nested.py."""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
import threading
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from . import places
from .interface import BLOCKS, Interface, load, package_of


class BuildError(RuntimeError):
    """A block that cannot be built; the message says which and why."""


@dataclass(frozen=True)
class Block:
    """The sources of an FMU: an interface, and the folder of the package that implements it."""

    interface: Interface
    folder: Path

    @property
    def name(self) -> str:
        return self.interface.name

    @classmethod
    def named(cls, name: str) -> Block:
        """A block of this project. Raises BuildError where there is none of this name."""
        if name not in BLOCKS:
            raise BuildError(f"there is no block {name!r}; expected one of {', '.join(BLOCKS)}")
        return cls(load(name), places.PACKAGES.joinpath(*package_of(name).split(".")))


def package_name(folder: Path) -> str:
    """The name of the package in this folder, from its topmost package on: `allocator.bounded`.

    What an installed copy puts round this project's packages does not count.
    """
    name, above = folder.name, folder.parent
    while above != places.PACKAGES and (above / "__init__.py").exists():
        name, above = f"{above.name}.{name}", above.parent
    return name


def files_of(folder: Path) -> list[Path]:
    """All files in a block's folder, sorted, without its C and without blocks in folders of their own."""
    inside = (path for path in folder.iterdir() if path.is_dir())
    apart = {folder / "native", *(path for path in inside if is_block(os.listdir(path)))}
    found = (path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc")
    return sorted(path for path in found if apart.isdisjoint(path.parents))


def is_block(names: Collection[str]) -> bool:
    """Returns whether these are in the folder of a block."""
    return "native" in names or "block.py" in names


@contextlib.contextmanager
def module_of(folder: Path, name: str) -> Iterator[ModuleType]:
    """A module of the package in this folder, such as `native.tables`, even if another of its name is imported
    already."""
    package = package_name(folder)
    with importing_from(folder.parents[package.count(".")], package.partition(".")[0]):
        yield importlib.import_module(f"{package}.{name}")


@contextlib.contextmanager
def importing_from(folder: Path, *packages: str) -> Iterator[None]:
    """Imports these packages from this folder, even if imported already; restores `sys.modules` afterwards.

    One thread at a time: the others wait.
    """

    with _IMPORTING:
        yield from _importing_from(folder, packages)


_IMPORTING = threading.RLock()


def _importing_from(folder: Path, packages: tuple[str, ...]) -> Iterator[None]:
    def of_packages() -> list[str]:
        return [name for name in sys.modules if name.partition(".")[0] in packages]

    path, write, aside = (
        sys.path.copy(),
        sys.dont_write_bytecode,
        {name: sys.modules.pop(name) for name in of_packages()},
    )
    sys.path.insert(0, str(folder))
    sys.dont_write_bytecode = True
    importlib.invalidate_caches()
    try:
        yield
    finally:
        sys.path[:] = path
        sys.dont_write_bytecode = write
        for name in of_packages():
            del sys.modules[name]
        sys.modules.update(aside)


WITHIN = {"controller.planned.wheels": "controller_planned"}
"""Packages whose C has that of another block in it, and that block."""


def inside(folder: Path) -> Block | None:
    """The block whose C that in a block's folder has in it; None where it stands alone."""
    name = WITHIN.get(package_name(folder))
    return None if name is None else Block.named(name)


def natives(folder: Path) -> list[Path]:
    """The folders of C that a block in this folder is made of, its own first."""
    within = inside(folder)
    return [folder / "native"] + ([] if within is None else [within.folder / "native"])


LENT = {"gauss_models.h": "estimator"}
"""Headers of tables that the C of several blocks may include, and the block whose `native/tables.py` writes them."""


def lenders(folder: Path) -> dict[str, Path]:
    """Of the headers in LENT those that the C in a block's folder includes, with the folder of the block
    that writes them."""
    if not (folder / "native").is_dir():
        return {}
    files = (path for native in natives(folder) for path in sorted(native.rglob("*.c")))
    text = "".join(path.read_text("utf-8") for path in files)
    return {name: Block.named(owner).folder for name, owner in LENT.items() if f'#include "{name}"' in text}


def start_values(block: str, helper: str, value: Any, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The start values that a helper input of a block stands for, by the function of its name in the block's module
    `inputs`.

    `parameters` are those in force, in SI units, items of enumerations by their names. Raises ValueError.
    """
    given: dict[str, Any] = getattr(_inputs(block), helper)(value, parameters)
    return given


@cache
def _inputs(block: str) -> ModuleType:
    with module_of(Block.named(block).folder, "inputs") as inputs:  # 0.3 s
        return inputs
