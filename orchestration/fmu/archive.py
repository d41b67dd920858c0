"""Opening an FMU: what can be checked of it before any of its code runs, and its unpacking.

FMPy reads and validates modelDescription.xml, lxml its version and its size before.
"""

from __future__ import annotations

import hashlib
import re
import time
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from fmus import places
from fmus.kept import code, kept
from fmus.versions import version_of

from ..errors import InputError, Problem, file_hint
from . import zipped
from .aliases import aliases, set_together
from .co_simulation import CoSimulation
from .description import describe
from .head import Head, read_head
from .model import Model
from .starts import starts_of
from .zipped import line, shown

__all__ = [
    "Fmu",
    "Head",
    "Unsupported",
    "check_version",
    "described",
    "examined",
    "libraries",
    "open_fmu",
    "platforms",
    "read_head",
    "second",
    "shown",
]

VERSIONS = re.compile(r"2\.0|3\.0(\.\d+)?")
"""Of FMI, which run here."""
_UNREADABLE = (ValueError, TypeError, KeyError, IndexError, AttributeError, ArithmeticError, RecursionError)
"""What a description that is not valid brings about where FMPy or `describe` reads it."""


@dataclass(frozen=True)
class Fmu:
    """An FMU that can run here."""

    path: Path
    sha256: str
    kind: CoSimulation
    model: Model
    problems: tuple[str, ...] = ()
    """What is not valid in its modelDescription.xml, where that was asked to be passed over."""

    @cached_property
    def description(self) -> Any:
        """FMPy's ModelDescription: it is read when it is asked for, since the import of FMPy takes 60 ms."""
        return described(self.path, read_head(self.path), lenient=True)[0]

    @property
    def library(self) -> str:
        """Path in it of the library for this platform; of a law in Python its file."""
        return str(self.path) if self.path.suffix == ".py" else self.kind.library

    def extract(self, folder: Path, names: Iterable[str] | None = None) -> None:
        """Unpacks it, or these of its entries, into an empty folder. Raises InputError."""
        zipped.unpack(self.path, folder, "FMU", names)


def second(fmus: Mapping[str, Fmu]) -> tuple[str, str] | None:
    """The names of two instances of one FMU that declares itself able to have one only in a process; None without such
    a pair."""
    first: dict[str, str] = {}
    for name, fmu in fmus.items():
        if fmu.kind.alone and first.setdefault(fmu.sha256, name) != name:
            return first[fmu.sha256], name
    return None


class Unsupported(InputError):
    """An FMU of a version or kind that does not run here."""

    def __init__(self, path: Path, what: str, expected: str) -> None:
        self.what = f"{what}; expected {expected}"
        super().__init__(f"{shown(path)} {self.what}")


def check_version(path: Path, head: Head) -> None:
    """Raises Unsupported for a version of FMI that does not run here."""
    if not VERSIONS.fullmatch(head.version or ""):
        version = f"is an FMU of FMI {head.version}" if head.version else "declares no fmiVersion"
        raise Unsupported(path, version, "FMI 2.0 or 3.0 for co-simulation")


def libraries(names: Collection[str], platform: str) -> str:
    """The libraries among the names of an FMU's entries, for a message: those for this platform, else the platforms."""
    files = sorted(name for name in names if re.fullmatch(r"binaries/[^/]+/[^/]+", name))
    here = [name for name in files if name.split("/")[1] == platform]
    return ", ".join(here) or f"binaries for {', '.join(platforms(names)) or 'none'}"


def platforms(names: Iterable[str]) -> list[str]:
    """The platforms for which an FMU has binaries, of the names of its entries."""
    return sorted({name.split("/")[1] for name in names if re.fullmatch(r"binaries/[^/]+/[^/]+", name)})


def open_fmu(path: Path, lenient: bool = False) -> Fmu:
    """Reads and checks an FMU; its code does not run yet. Raises InputError, without the scenario's line.

    `lenient`: what is not valid in its modelDescription.xml is kept in `problems` as far as it can be read all the
    same. What has been read is kept for the file as it is: by its size, time and number on the disk.
    """
    try:
        status = path.stat()
        # What was written a moment ago may be written again at the same time by the clock of the disk.
        moment = time.time_ns() if time.time_ns() - status.st_mtime_ns < _MOMENT else 0
    except OSError:
        return _opened(path, lenient)
    return _opened(path, lenient, status.st_size, status.st_mtime_ns, status.st_ino, moment)


_MOMENT = 2 * 10**9
"""ns"""


@lru_cache(50)
def _opened(path: Path, lenient: bool, *state: object) -> Fmu:
    """Opens one in this state, of which it is kept.

    One that this project has built or brings along, whose code runs here anyway, is read once for all processes.
    """
    if not any(path.is_relative_to(folder) for folder in (places.work() / "fmus", places.READY)):
        return _open(path, lenient)
    readers = code(Path(__file__).parents[1]), code(Path(places.__file__).parent)
    return kept(Fmu, (path, lenient, _digest(path), readers, version_of("fmpy")), lambda: _open(path, lenient))


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _open(path: Path, lenient: bool) -> Fmu:
    fmu = examined(path, lenient)
    names = zipped.names(path, "FMU")
    if fmu.library not in names:
        found = libraries(names, fmu.kind.platform)
        raise InputError(f"{shown(path)} has no binary for this platform: expected {fmu.library}, found {found}")
    return fmu


def examined(path: Path, lenient: bool = False) -> Fmu:
    """An FMU as `open_fmu` reads it, whether it has a binary for this platform or not. Raises InputError."""
    if not path.exists():
        near = file_hint(path.name, (p.name for p in path.parent.glob("*.fmu"))) if path.parent.is_dir() else ""
        raise InputError(f"there is no FMU {shown(path)}{near}")
    names = zipped.names(path, "FMU")
    head = read_head(path)
    # The version decides first: the schema's complaints about another version would only confuse.
    check_version(path, head)
    description, model, problems = described(path, head, lenient)
    if description.fmiVersion == "2.0":
        problems += [text + wrong for alike, text in aliases(description) if (wrong := set_together(alike))]
        if problems and not lenient:
            raise _not_valid(path, problems)
    return Fmu(path, _digest(path), CoSimulation.of(description, platforms(names)), model, tuple(problems))


def described(path: Path, head: Head, lenient: bool) -> tuple[Any, Model, list[str]]:
    """FMPy's ModelDescription, the model made of it, and what is not valid in it.

    Raises InputError where it cannot be read or is not valid and `lenient` is not set, and Unsupported where it is not
    for co-simulation or has clocks.
    """
    # Here, since it takes 60 ms and what is kept needs none of it.
    from fmpy.model_description import ValidationError, read_model_description  # noqa: PLC0415

    problems: list[str] = []
    try:
        try:
            description = read_model_description(path)
        except ValidationError as error:
            problems = list(error.problems)
            description = read_model_description(path, validate=False)
    except Exception as error:  # FMPy and lxml raise what they please
        raise _unreadable(path, problems, error) from None
    if problems and not lenient:
        raise _not_valid(path, problems)
    if description.coSimulation is None:
        kinds = {"model exchange": description.modelExchange, "scheduled execution": description.scheduledExecution}
        kind = " and ".join(name for name, element in kinds.items() if element is not None) or "nothing"
        raise Unsupported(path, f"is for {kind} only", "an FMU for co-simulation")
    if clocks := [v.name for v in description.modelVariables if v.type == "Clock"]:
        raise Unsupported(path, f"has clocks, which need event mode: {', '.join(clocks[:5])}", "an FMU without clocks")
    for variable in description.modelVariables:
        if variable.name in head.unsigned:
            variable.min, variable.max = head.unsigned[variable.name]
    try:
        model = describe(description, head.optional, head.quantities)
        model = replace(model, starts=starts_of(description, model))
    except InputError as error:
        raise InputError(f"{shown(path)}: {error}") from None
    except _UNREADABLE as error:
        raise _unreadable(path, problems, error) from None
    return description, model, problems


def _unreadable(path: Path, problems: list[str], error: Exception) -> InputError:
    if problems:
        return _not_valid(path, problems)
    why = f"it names {error} and does not define it" if isinstance(error, KeyError) else line(error)  # a unit, a type
    return InputError(f"{shown(path)}: modelDescription.xml cannot be read: {why}")


def _not_valid(path: Path, problems: list[str]) -> InputError:
    more = [f"and {len(problems) - 5} more"] if len(problems) > 5 else []
    text = "\n  ".join([f"{shown(path)}: modelDescription.xml is not valid:", *problems[:5], *more])
    return InputError(Problem(text, kind="not valid"))
