"""The place of a run's results: a folder that one run at a time may write, and in which new results replace earlier
ones.

New results are complete in a folder of their own, `.orchestrate-part-...`, before anything of the earlier ones is
touched. Its renaming to `.orchestrate-ready` decides: from then on its files take the places of the earlier ones, the
manifest last. A run that is killed before leaves the earlier results, and one that is killed after it leaves the rest
to the next run.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from threading import get_ident
from typing import Any

from ..errors import InputError, reason
from ..interrupt import held
from .whole import PART, parsed, sync

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

MANIFEST = "manifest.json"
FILES = ("expectations.json", "report.html", "signals.csv", "signals.parquet", "signals.mat", MANIFEST)
"""What a run may leave in its folder; nothing else there is touched."""
_LOCK, _READY = ".orchestrate.lock", ".orchestrate-ready"


def check_writable(folder: Path) -> None:
    """Refuses a folder that could not be written, before a run is spent on it."""
    try:
        existing = next((p for p in (folder, *folder.absolute().parents) if p.exists()), folder)
    except (OSError, ValueError) as error:
        raise InputError(f"the results cannot be written to {str(folder)!r}: {reason(error)}") from None
    if not existing.is_dir():
        raise InputError(f"the results cannot be written to {folder}: {existing} is a file")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError(f"the results cannot be written to {folder}: {existing} is not writable")
    for name in FILES:
        if (folder / name).is_dir():
            raise InputError(
                f"the results cannot be written to {folder}: {folder / name} is a folder; expected a file, or none"
            )


def refuse_links(folder: Path) -> None:
    """Refuses a folder of results in which something is a link, since a command would write beyond the folder, or a
    pipe, a socket or a device, for which it would wait. Raises InputError. A run's files take the place of such."""
    with suppress(OSError):  # it is not there
        for path in sorted(folder.iterdir()):
            if path.name in FILES or path.name.startswith("."):
                continue
            remedy = "remedy: remove it, or another folder (--out)"
            if path.is_symlink():
                raise InputError(f"{path} is a link; expected what lies in the folder itself; {remedy}")
            if path.exists() and not (path.is_file() or path.is_dir()):
                raise InputError(f"{path} is a device, a pipe or a socket; expected a regular file; {remedy}")


def refuse_foreign(folder: Path, own: Iterable[str] = ()) -> None:
    """Refuses a folder that could not be written, or has files in it that are no results. Raises InputError, which
    names them.

    A folder with the manifest of a run is one of results, and a hidden file is no one's; `own` are further names of
    ours.
    """
    check_writable(folder)
    refuse_links(folder)
    try:
        there = {path.name for path in folder.iterdir()}
    except OSError:  # it is not there
        return
    foreign = sorted(name for name in there - set(own) if not name.startswith("."))
    if not foreign or _READY in there or "scenario" in _manifest(folder):
        return
    more = f" and {len(foreign) - 3} more" if len(foreign) > 3 else ""
    raise InputError(
        f"{folder} holds files that are no results: {', '.join(foreign[:3])}{more}; expected a new or empty folder, "
        f"or one with the results of a run, which new ones replace; remedy: --out {folder / 'results'}"
    )


def refuse_other(folder: Path, scenario: str) -> None:
    """Refuses a folder with the results of another scenario file, one that is still there. Raises InputError."""
    earlier = _manifest(folder).get("scenario_file")
    if not isinstance(earlier, str):
        return
    try:
        same = os.path.samefile(earlier, scenario)
    except (OSError, ValueError):
        return
    if not same:
        remedy = f"--out DIR, or another name in {scenario}"
        raise InputError(f"{folder} holds the results of another scenario, {earlier}; remedy: {remedy}")


def _manifest(folder: Path) -> dict[str, Any]:
    """Returns the manifest in a folder; nothing where there is none of ours."""
    try:
        data = parsed(folder / MANIFEST)
    except (OSError, ValueError):
        return {}
    return data if isinstance(data, dict) else {}


@contextmanager
def reserved(folder: Path) -> Iterator[None]:
    """Keeps other runs out of the folder, and clears what a killed one left there. Raises InputError where another is
    in it.

    The folder is made, and removed again where nothing was put into it. Within one thread it may be entered again.
    """
    check_writable(folder)
    made = [path for path in (folder, *folder.absolute().parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        place = get_ident(), folder.resolve()
        release = None if place in _ours else _lock(folder)
    except (BlockingIOError, TimeoutError):
        remedy = "wait for it, or another folder (--out)"
        message = f"the results cannot be written to {folder}: another run writes there; remedy: {remedy}"
        raise InputError(message) from None
    except (OSError, ValueError) as error:
        raise InputError(f"the results cannot be written to {folder}: {reason(error)}") from None
    if release is None:
        yield
        return
    _ours.add(place)
    try:
        _clear(folder)
        yield
    finally:
        _ours.remove(place)
        for path in made:
            with suppress(OSError):  # it is not empty
                path.rmdir()
        release()


_ours: set[tuple[int, Path]] = set()
"""The folders that this process has reserved, each by one thread."""


def _close(descriptor: int) -> None:
    with suppress(OSError):  # an FMU in this process has closed it
        os.close(descriptor)


def _lock(folder: Path) -> Callable[[], None]:
    """Takes the folder's lock and returns what gives it back. Raises BlockingIOError or TimeoutError where another has
    it.
    """
    if fcntl is not None:
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(descriptor)
            raise
        except OSError:  # NFS has no locks of folders
            os.close(descriptor)
        else:
            return partial(_close, descriptor)
    from filelock import FileLock  # here, since it takes 30 ms and is seldom needed  # noqa: PLC0415

    lock = FileLock(folder / _LOCK, timeout=0)
    lock.acquire()
    return lock.release


def _clear(folder: Path) -> None:
    """Completes or removes what a killed run left."""
    with suppress(OSError):
        _finish(folder)
    for left in folder.glob(f"{PART}*"):
        if left.is_dir() and not left.is_symlink():
            shutil.rmtree(left, ignore_errors=True)
        else:
            left.unlink(missing_ok=True)


@contextmanager
def replacing(folder: Path) -> Iterator[Path]:
    """An empty folder whose files take the places of the earlier results when the block of code is left; not where it
    raises.

    One of them has to be the manifest, which names the others in `files`. Signals wait for the end, a second one only
    for the end of the replacing. Raises OSError, which names files by their places in the folder.
    """
    with reserved(folder), held():
        part = Path(tempfile.mkdtemp(prefix=PART, dir=folder))
        try:
            yield part
            for path in part.iterdir():
                sync(path)
            with held(firmly=True):
                os.rename(part, folder / _READY)
                _finish(folder)
        except OSError as error:
            if error.filename and Path(str(error.filename)).parent.name.startswith(".orchestrate"):
                error.filename = str(folder / Path(str(error.filename)).name)
            raise
        finally:
            shutil.rmtree(part, ignore_errors=True)


def _finish(folder: Path) -> None:
    """Moves the files that are ready to their places, the manifest last, and removes those of which it says nothing."""
    ready = folder / _READY
    if ready.is_symlink() or not ready.is_dir():
        ready.unlink(missing_ok=True)
        return
    stays = _manifest(ready).get("files")
    if isinstance(stays, (dict, list)):  # else it is none that a run has made ready
        for name in FILES:
            if name not in stays and name != MANIFEST:
                (folder / name).unlink(missing_ok=True)
            elif (ready / name).exists():
                os.replace(ready / name, folder / name)
    shutil.rmtree(ready, ignore_errors=True)
    sync(folder)


def check(folder: Path) -> None:
    """Holds the files of a run against the SHA-256 in its manifest. Raises InputError, which names a changed one."""
    files = _manifest(folder).get("files")
    for name, value in files.items() if isinstance(files, dict) else ():
        path = folder / Path(str(name)).name
        if path.is_file() and value != _digest(path):
            raise InputError(f"{path} is damaged: its SHA-256 is not the one in {MANIFEST}; remedy: the run again")


def digests(folder: Path) -> dict[str, str]:
    """Returns the SHA-256 of each file in the folder."""
    return {path.name: _digest(path) for path in sorted(folder.iterdir())}


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
