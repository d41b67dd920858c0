"""Time scales: the instants of a run in UTC, TT and Unix time, by ERFA.

A run counts elapsed seconds of the SI from its epoch, a UTC. So an instant is TAI(epoch) + t, and a leap second within
the run is counted: UTC then shows 23:59:60.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import date, timedelta
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestration.errors import InputError, Place, Problem

DAY, J2000 = 86400.0, 2451545.0
_UTC = re.compile(r"(\d{4})-(?:(\d\d)-(\d\d)|(\d{3}))T(\d\d):(\d\d)(?::(\d\d(?:\.\d*)?))?Z?")
_AHEAD = {"UTC": 0.0, "TAI": 0.0, "TT": 32.184, "TDT": 32.184, "GPS": -19.0}
"""By how many seconds a scale is ahead of TAI; UTC has its leap seconds."""


def erfa() -> Any:
    """Returns the library. Raises InputError where it is missing."""
    try:
        import erfa  # optional  # noqa: PLC0415
    except ModuleNotFoundError:
        raise missing("pyerfa") from None
    return erfa


def missing(package: str) -> InputError:
    """Returns what is raised where a package of the extra `formats` is not installed."""
    return InputError(Problem(f"the package {package} is missing", remedy="pip install 'attitude-cosim[formats]'"))


class Instants:
    """Instants at times (n,) s from an epoch. Raises InputError where the epoch is no UTC of ISO 8601."""

    def __init__(self, epoch: str, time: NDArray[np.float64], place: str = "epoch") -> None:
        self.epoch, self.time, self._erfa = epoch, np.asarray(time, float), erfa()
        self._tai0 = tai(epoch, "UTC", place)

    def utc(self) -> list[str]:
        """Returns UTC as `2009-08-10T00:00:00.100000000`, to 1e-9 s."""
        with _quiet():
            utc = self._erfa.taiutc(self._tai0[0], self._tai0[1] + self.time / DAY)
            y, m, d, part = self._erfa.d2dtf("UTC", 9, *utc)
        rows = zip(y, m, d, *(part[name] for name in "hmsf"), strict=True)
        return [f"{y:04d}-{m:02d}-{d:02d}T{h:02d}:{mi:02d}:{s:02d}.{ns:09d}" for y, m, d, h, mi, s, ns in rows]

    def unix_ns(self) -> NDArray[np.int64]:
        """Returns Unix time in ns: that of the epoch plus t, so without the leap seconds of the run."""
        with _quiet():
            y, m, d, part = self._erfa.d2dtf("UTC", 9, *self._erfa.taiutc(*self._tai0))
        hour, minute, second, ns = (int(part[name]) for name in "hmsf")
        whole = (date(y, m, d).toordinal() - date(1970, 1, 1).toordinal()) * 86400 + hour * 3600 + minute * 60 + second
        return whole * 1_000_000_000 + ns + np.round(self.time * 1e9).astype(np.int64)

    @property
    def tt0(self) -> tuple[float, float]:
        """Returns TT of the epoch as a Julian date in two parts."""
        return self._erfa.taitt(*self._tai0)

    @property
    def tt0_seconds(self) -> float:
        """Returns TT of the epoch, s since 2000-01-01 12:00 TT."""
        return float((self.tt0[0] - J2000) * DAY + self.tt0[1] * DAY)


def tai(text: str, scale: str, place: str) -> tuple[float, float]:
    """Returns the TAI of a date of ISO 8601 (calendar or day of the year) as a Julian date in two parts.

    Raises InputError.
    """
    found = _UTC.fullmatch(text.strip())
    if found is None or scale not in _AHEAD:
        expected = f"a date such as 2009-08-10T00:00:00, in {', '.join(_AHEAD)}"
        raise InputError(Problem(expected=expected, found=f"{text!r} in {scale}", place=Place(place)))
    year, month, day, of_year, hour, minute, second = found.groups()
    e = erfa()
    try:
        on = date(int(year), int(month or 1), int(day or 1)) + timedelta(int(of_year or 1) - 1)
        clock = on.year, on.month, on.day, int(hour), int(minute), float(second or 0.0)
        with _quiet():
            one, two = e.dtf2d("UTC" if scale == "UTC" else "TAI", *clock)
            if scale == "UTC":
                one, two = e.utctai(one, two)
    except (ValueError, e.ErfaError):
        raise InputError(Problem(expected="a date of the calendar", found=repr(text), place=Place(place))) from None
    return float(one), float(two) - _AHEAD[scale] / DAY


def seconds_after(epoch: str, texts: Sequence[str], scale: str, place: str) -> NDArray[np.float64]:
    """Returns elapsed seconds (n,) from a UTC to dates in a time scale. Raises InputError."""
    zero = tai(epoch, "UTC", "epoch")
    others = np.array([tai(text, scale, place) for text in texts])
    return ((others[:, 0] - zero[0]) + (others[:, 1] - zero[1])) * DAY


@contextmanager
def _quiet() -> Iterator[None]:
    """A date far from now has leap seconds that nobody knows yet; ERFA warns of it, and takes those of today."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
