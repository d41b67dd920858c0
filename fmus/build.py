"""Builds blocks as FMUs, and rebuilds them when what they are made of has changed.

build()                      # all blocks in C, into out/fmus/native/
build(flavour="python")      # the Python reference of those that have one, into out/fmus/python/
ensure("plant")              # the path of plant.fmu, built when missing or out of date
ensure("plant", here=True)   # the same for this machine's platform alone, which takes a third of the time
ensure_all(["plant", "allocator"])    # those in C that need it, side by side

Tests: tests/fmus/test_build.py.
"""

from __future__ import annotations

import hashlib
import logging
import os
import tempfile
import zipfile
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from time import perf_counter

from . import places
from .block import Block, BuildError
from .fingerprint import fingerprint
from .interface import BLOCKS, FLAVOURS, Interface, load

__all__ = ["BLOCKS", "FLAVOURS", "Block", "BuildError", "blocks_of", "build", "ensure", "ensure_all", "is_current"]

ROOT = places.PACKAGES

_LOG = logging.getLogger("attitude_cosim.build")  # the same name in an installed wheel, where this module has another


def blocks_of(flavour: str) -> list[str]:
    """The blocks of this project that have this flavour."""
    return [block for block in BLOCKS if flavour in load(block).flavours]


def build(
    blocks: Iterable[str | Block] | None = None, flavour: str = "native", out: Path | None = None, version: int = 2
) -> dict[str, Path]:
    """Builds FMUs into a folder, by default out/fmus/<flavour>, and returns their paths by block. Raises BuildError.

    Without `blocks` these are all that have the flavour. `version` is FMI's; those of FMI 3.0, native ones alone, are
    in out/fmus/fmi3 by default.
    """
    _check(flavour)
    if version == 3:
        if flavour != "native":
            raise BuildError(f"the flavour {flavour!r} has FMUs of FMI 2.0 only")
        out = out or places.work() / "fmus" / "fmi3"
    chosen = [Block.named(b) if isinstance(b, str) else b for b in (blocks_of(flavour) if blocks is None else blocks)]
    for block in chosen:
        _check_flavour(block.interface, flavour)
    paths = {}
    for number, block in enumerate(chosen, start=1):
        path = paths[block.name] = _path(block.name, flavour, out)
        _LOG.info("building %s (%s)%s ...", path.name, flavour, f", {number} of {len(chosen)}" if chosen[1:] else "")
        _make(block, flavour, path, version=version)
        here = _path(block.name, flavour, None, here=True)
        if flavour == "native" and out is None and here.exists():  # a file that was spoilt goes, without a gap
            _write(here, path.read_bytes(), fingerprint(block, flavour).encode())
    return paths


def _make(block: Block, flavour: str, path: Path, here: bool = False, version: int = 2) -> None:
    stamp = fingerprint(block, flavour).encode()
    package = _packager(flavour)
    if here:
        package = partial(package, platforms="host")
    if version == 3:
        package = partial(package, version=3)
    try:
        data = package(block.interface, block.folder, places.shared("LICENSE"))
    except Exception as error:
        raise BuildError(f"{block.name}: {error}") from error
    _write(path, data, stamp)


def ensure(block: str | Block, flavour: str = "native", out: Path | None = None, here: bool = False) -> Path:
    """The path of a block's FMU, which is built first when it is missing or its sources have changed.

    Of several processes that ask at the same time one builds and the others wait for it. `here`: it need only run on
    this machine; where it is built, it then stands in a folder of its own. Raises BuildError.
    """
    _check(flavour)
    chosen = Block.named(block) if isinstance(block, str) else block
    _check_flavour(chosen.interface, flavour)
    if isinstance(block, str) and out is None and (made := places.ready(f"{flavour}/{block}.fmu")):
        return made
    here = here and flavour == "native" and out is None
    path = _path(chosen.name, flavour, out, here)
    if not is_current(path, chosen, flavour):
        if here:
            _LOG.info("building %s (%s) ...", path.name, flavour)
            _build_once(chosen, flavour, path, partial(_make, chosen, flavour, path, here=True))
        else:
            _build_once(chosen, flavour, path, lambda: build([chosen], flavour, out))
    return path


def _build_once(block: Block, flavour: str, path: Path, make: Callable[[], object]) -> None:
    from filelock import FileLock  # here, since it takes 30 ms and only a build needs it  # noqa: PLC0415

    path.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(path.with_name(f".{path.name}.lock")):
        if not is_current(path, block, flavour):  # else another process has built it in the meantime
            make()


def ensure_all(names: Iterable[str], here: bool = False) -> None:
    """Builds in C those blocks that `ensure` would build, side by side where they are several. Raises BuildError.

    One compiler a core runs at a time. The log has the time that it takes.
    """
    blocks = {
        _path(name, "native", None, here): Block.named(name) for name in names if not places.ready(f"native/{name}.fmu")
    }
    needed = {path: block for path, block in blocks.items() if not is_current(path, block, "native")}
    if len(needed) < 2:
        return  # `ensure` does it
    where = "" if here else " for all platforms"
    _LOG.info("building %d FMUs%s: %s ...", len(needed), where, ", ".join(path.stem for path in needed))
    begun = perf_counter()
    _packager("native")  # imported here: threads that import it at once may wait for each other
    with ThreadPoolExecutor(len(needed)) as pool:
        made = [
            pool.submit(_build_once, block, "native", path, partial(_make, block, "native", path, here=here))
            for path, block in needed.items()
        ]
        for one in made:
            one.result()
    _LOG.info("built in %.0f s", perf_counter() - begun)


def is_current(path: Path, block: str | Block, flavour: str) -> bool:
    """Returns whether a file is the FMU of a block's sources as they are now. Without a file it is not."""
    chosen = Block.named(block) if isinstance(block, str) else block
    return _stamp(path) == fingerprint(chosen, flavour).encode()


def _packager(flavour: str) -> Callable[..., bytes]:
    """Imported here, since it takes long and `ensure` seldom needs it; PythonFMU may be missing."""
    if flavour == "native":
        from . import native  # takes long, and `ensure` seldom needs it  # noqa: PLC0415

        return native.package
    try:
        from .python import packaging  # PythonFMU may be missing  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise BuildError(
            f"building the Python flavour needs the package {error.name}: pip install {error.name}"
        ) from None
    return packaging.package


def _path(name: str, flavour: str, out: Path | None, here: bool = False) -> Path:
    return (out or places.work() / "fmus" / ("here" if here else flavour)) / f"{name}.fmu"


def _check(flavour: str) -> None:
    if flavour not in FLAVOURS:
        raise BuildError(f"there is no flavour {flavour!r}; expected one of {', '.join(FLAVOURS)}")


def _check_flavour(interface: Interface, flavour: str) -> None:
    if flavour not in interface.flavours:
        there = " and ".join(interface.flavours)
        raise BuildError(f"{interface.name} has no flavour {flavour!r}; expected {there}")


def _stamp(path: Path) -> bytes | None:
    """The fingerprint that was written into the comment at the end of the FMU's archive; None where there is none."""
    end = hashlib.sha256().digest_size * 2 + 22
    try:
        with path.open("rb") as file:
            file.seek(-end, os.SEEK_END)
            record = file.read()
    except OSError:
        return None
    return record[22:] if record.startswith(b"PK\5\6") else None


def _write(path: Path, data: bytes, stamp: bytes) -> None:
    """Writes a temporary file and renames it, so that another process never reads an incomplete FMU."""
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, name = tempfile.mkstemp(".tmp", dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
        with zipfile.ZipFile(name, "a") as archive:
            archive.comment = stamp
        os.chmod(name, 0o644)
        os.replace(name, path)
    except BaseException as error:
        os.unlink(name)
        if isinstance(error, OSError):
            error.filename = str(path)  # no name where the disk is full, else that of the temporary file
        raise
