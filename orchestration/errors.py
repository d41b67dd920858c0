"""Errors of the user or of an FMU, which are found before a run, and failures of a block while it runs.

An error is data: its place, what was expected and found there, and the remedy. Its text is made here, and only here.
Longer than 250 lines: so that the words of all errors stand in one place.
"""

from __future__ import annotations

import errno
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal, TypedDict

Kind = Literal["", "damaged", "not valid"]
"""What a caller may ask of an error: an archive that is damaged, a modelDescription.xml that is not valid."""


@dataclass(frozen=True)
class Place:
    """Place of something: in a file or an option of the command line, in which line, and under which name there."""

    source: str | None = None
    line: int | None = None
    name: str = ""

    def __str__(self) -> str:
        source = f"{self.source}:{self.line}" if self.source and self.line else self.source
        return ": ".join(filter(None, (source, self.name))) or "scenario"


class Fields(TypedDict, total=False):
    """Fields of an error beside its text."""

    expected: str
    found: str
    remedy: str
    kind: Kind


@dataclass(frozen=True)
class Problem:
    """One error of the user or of an FMU."""

    text: str = ""
    """What is wrong, where expected and found do not say it."""
    expected: str = ""
    found: str = ""
    remedy: str = ""
    place: Place | None = None
    kind: Kind = ""

    def __str__(self) -> str:
        separator = "\n  " if "\n" in self.text else "; "
        return self._said() + (f"{separator}remedy: {self.remedy}" if self.remedy else "")

    def _said(self) -> str:
        wanted = f"expected {self.expected}" if self.expected else ""
        found = f"found {self.found}" if self.found else ""
        said = "; ".join(filter(None, (self.text, ", ".join(filter(None, (wanted, found))))))
        return said if self.place is None else f"{self.place}: {said}"

    def at(self, place: Place) -> Problem:
        """Returns this error as one of what stands at a place; the place that it has stays in its text."""
        if self.place is None:
            return replace(self, place=place)
        return Problem(self._said(), remedy=self.remedy, place=place, kind=self.kind)


class InputError(ValueError):
    """The scenario, an FMU or an option is wrong, and nothing was run. Exit status 2."""

    def __init__(self, *problems: Problem | str) -> None:
        self.problems = tuple(p if isinstance(p, Problem) else Problem(p) for p in problems)
        super().__init__("\n".join(self.messages))

    @property
    def messages(self) -> tuple[str, ...]:
        """The texts of the errors."""
        return tuple(map(str, self.problems))


class Problems(list[Problem]):
    """Errors that are gathered, to be raised together at the end of the `with` that makes the list."""

    def __enter__(self) -> Problems:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None and self:
            raise InputError(*self)

    @contextmanager
    def gathered(self) -> Iterator[None]:
        """Takes in what is raised inside as InputError."""
        try:
            yield
        except InputError as error:
            self += error.problems


@contextmanager
def naming(place: Place) -> Iterator[None]:
    """Puts at a place what is raised inside as InputError; what stands in a line already stays there."""
    try:
        yield
    except InputError as error:
        raise InputError(*(p if p.place and p.place.line else p.at(place) for p in error.problems)) from None


class NoRoom(InputError):
    """A folder of this machine cannot take what a run needs there: no error of the scenario, and nothing was run.

    Exit status 2.
    """

    def __init__(self, what: str, folder: Path, error: OSError) -> None:
        super().__init__(
            Problem(f"{what} in {folder}: {reason(error)}", remedy="room there, or another folder in TMPDIR")
        )


class BlockError(RuntimeError):
    """A block failed: in initialization (`time` is None) or during the run. Exit status 3.

    `status` is what the call gave, where it gave one.
    `result` holds what was computed up to then, once the run has ended.
    """

    def __init__(
        self,
        block: str,
        call: str,
        problem: str,
        time: float | None = None,
        log: Sequence[str] = (),
        status: int | None = None,
    ) -> None:
        self.block, self.call, self.problem, self.time, self.log = block, call, problem, time, tuple(log)
        self.status = status
        self.result: Any = None
        super().__init__(block, call, problem)

    def __str__(self) -> str:
        when = "in initialization" if self.time is None else f"at {self.time:.10g} s"
        text = f"{self.block}: {self.call} {when}: {self.problem}"
        return "\n".join([text, *(f"  {self.block} logged: {line}" for line in self.log)])


class ResultsError(RuntimeError):
    """The results could not be written. Exit status 4. `result` is what could not be, where it is known."""

    result: Any = None


_PLAIN = {
    errno.EACCES: "no permission",
    errno.EPERM: "no permission",
    errno.EISDIR: "it is a folder; expected a file",
    errno.ENOTDIR: "a part of this path is a file; expected a folder",
    errno.EEXIST: "something else is there, such as a link to nothing",
    errno.ENOENT: "there is no such file or folder",
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.EROFS: "the disk is read-only",
    errno.ENAMETOOLONG: "the name is too long",
    errno.ELOOP: "its links lead in a circle",
}
"""What the system reports, in plain words."""


def reason(error: BaseException) -> str:
    """Returns in plain words why the system refused something."""
    return _PLAIN.get(getattr(error, "errno", None) or 0) or getattr(error, "strerror", None) or str(error)


@contextmanager
def writing(target: Path) -> Iterator[None]:
    """Raises ResultsError where the system refuses what is written inside."""
    try:
        yield
    except OSError as error:
        raise ResultsError(f"{error.filename or target} cannot be written: {reason(error)}") from None


_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""What a terminal may obey instead of showing: all but line ends and tabs, with what turns the direction of writing."""


def printable(text: str) -> str:
    """Text from anywhere with its control characters escaped, for a terminal: `\\x1b` for ESC."""
    return _CONTROLS.sub(lambda match: match[0].encode("unicode_escape").decode(), text)


def printable_json(text: str) -> str:
    """JSON with the same characters escaped as JSON escapes them."""
    return _CONTROLS.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


_MANY = 5000
"""Names from which on not all are compared: 30 comparisons with 80,000 names take half a minute."""


def nearest(name: str, names: Iterable[str]) -> str | None:
    """The one of the names that is nearly this name, whatever its case; None where none is.

    Of thousands of names, one that begins with the same letter.
    """
    wanted, folded = name.casefold(), {known.casefold(): known for known in names}
    able = folded if len(folded) <= _MANY else [known for known in folded if known[:1] == wanted[:1]]
    match = get_close_matches(wanted, able, n=1)
    return folded[match[0]] if match else None


def suggestion(match: str | None) -> str:
    """ "; did you mean 'x'?" of a match."""
    return f"; did you mean {match!r}?" if match is not None else ""


def hint(name: str, names: Iterable[str]) -> str:
    """Returns what ends a message about an unknown name: the match among the names, or else the names where they are
    few.
    """
    names = list(names)
    few = f"; there {'is only' if len(names) == 1 else 'are'} {', '.join(names)}" if 0 < len(names) <= 8 else ""
    return suggestion(nearest(name, names)) or few


def file_hint(file: str, files: Iterable[str]) -> str:
    """The same for a file among others, by their names without the suffix."""
    by_stem = {name.rpartition(".")[0]: name for name in files}
    match = nearest(file.rpartition(".")[0], by_stem)
    return suggestion(by_stem[match]) if match else hint("", by_stem.values())


def in_kind(value: Any) -> str:
    """A value's kind, for "found ..." of a whole file: it may be none that messages should print."""
    return "text" if isinstance(value, str) else as_written(value)


def as_written(value: Any) -> str:
    """A value as the user wrote it, for "found ..."; of a text at most 200 characters."""
    if value is None or isinstance(value, bool):
        return "nothing" if value is None else str(value).lower()
    if isinstance(value, dict):
        return "names with values"
    if isinstance(value, str) and len(value) > 200:
        return f"{value[:200]!r} ... of {len(value)} characters"
    return "a list" if isinstance(value, (list, tuple)) else repr(value)


def lacking(what: str, package: str | None, needed: str = "attitude-cosim[campaign]") -> InputError:
    """Returns the error of something that needs a package which is not installed, and what installs it."""
    return InputError(f"{what} needs the package {package!r}; remedy: pip install '{needed}'")
