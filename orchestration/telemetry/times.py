"""Time columns: UTC, GPS and TAI as seconds of TAI since 1970-01-01, so that differences are elapsed seconds."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_LEAPS = (
    "1972-07 1973-01 1974-01 1975-01 1976-01 1977-01 1978-01 1979-01 1980-01 1981-07 1982-07 1983-07 1985-07 1988-01 "
    "1990-01 1991-01 1992-07 1993-07 1994-07 1996-01 1997-07 1999-01 2006-01 2009-01 2012-07 2015-07 2017-01"
).split()
"""Months that began after a leap second (IERS Bulletin C); TAI - UTC was 10 s before the first."""
_UNIX = np.array([datetime.fromisoformat(f"{month}-01T00:00:00+00:00").timestamp() for month in _LEAPS])
_LEAP_SECOND = re.compile(r"(?<=:\d\d):60(?![\d:])")
GPS_BEHIND_TAI = 19.0
DEFAULT_EPOCHS = {"UTC": "1970-01-01", "GPS": "1980-01-06", "TAI": "1970-01-01"}


class TimeError(ValueError):
    """A time that cannot be read, or one of another scale."""


def tai(seconds: Floats, scale: str) -> Floats:
    """Returns seconds of TAI since 1970-01-01 of such of a scale, as a calendar of 86400 s a day counts them."""
    if scale == "UTC":
        return seconds + 10.0 + np.searchsorted(_UNIX, seconds, side="right")
    return seconds + GPS_BEHIND_TAI if scale == "GPS" else seconds


def unix(seconds: float) -> float:
    """Returns Unix time (UTC without leap seconds) of seconds of TAI since 1970-01-01."""
    return seconds - 10.0 - float(np.searchsorted(_UNIX + 10.0 + np.arange(1, len(_UNIX) + 1), seconds, side="right"))


def utc_text(seconds: float) -> str:
    """Returns the UTC, to a second, of seconds of TAI since 1970-01-01."""
    calendar = unix(seconds)
    leap = float(tai(np.array([calendar]), "UTC")[0]) > seconds + 0.5  # Unix time has the next second's number
    when = datetime.fromtimestamp(calendar - leap, UTC)
    return when.strftime("%Y-%m-%dT%H:%M:60Z" if leap else "%Y-%m-%dT%H:%M:%SZ")


def calendar_seconds(text: str, scale: str) -> tuple[float, float]:
    """Returns the seconds since 1970-01-01 that a calendar of this scale counts to a text in ISO 8601, and those to
    add behind it: one in a leap second, 23:59:60 of UTC, which such a count has no number for. Raises TimeError."""
    leap = _LEAP_SECOND.search(text) if scale == "UTC" else None
    try:
        when = datetime.fromisoformat((_LEAP_SECOND.sub(":59", text) if leap else text).strip())
    except ValueError:
        raise TimeError(f"expected a date and time in ISO 8601, or a number, found {text!r}") from None
    if when.tzinfo is not None and scale != "UTC":
        raise TimeError(f"expected a time in {scale}, found {text!r}, which is UTC by its end")
    seconds = (when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp()
    if leap and math.floor(seconds) + 1.0 not in _UNIX:
        raise TimeError(f"expected a time in UTC, found {text!r}, when there was no leap second")
    return seconds, 1.0 if leap else 0.0


def instant(text: str, scale: str) -> float:
    """Returns the seconds of TAI since 1970-01-01 of a text in ISO 8601. Raises TimeError."""
    seconds, more = calendar_seconds(text, scale)
    return float(tai(np.array([seconds]), scale)[0]) + more


def instants(cells: Sequence[str], factor: float, epoch: float, scale: str) -> tuple[Floats, int | None, str]:
    """Returns the times of a column's cells as `tai` counts them.

    `factor` is that of a number's unit in s, `epoch` the calendar's seconds of the number 0. Behind the times: the
    place of the first cell that is none, and why.
    """
    try:
        return _finite(tai(factor * np.array([number(cell) for cell in cells]) + epoch, scale))
    except ValueError:
        seconds, more = np.full((2, len(cells)), np.nan)
    for i, cell in enumerate(cells):
        try:
            seconds[i], more[i] = _number(cell, factor, epoch) or calendar_seconds(cell, scale)
        except TimeError as error:
            return tai(seconds, scale), i, str(error) if cell.strip() else "expected a time, found nothing"
    return _finite(tai(seconds, scale) + more)


def _finite(times: Floats) -> tuple[Floats, int | None, str]:
    bad = np.flatnonzero(~np.isfinite(times))
    return times, (int(bad[0]) if len(bad) else None), "expected a finite time"


def number(cell: str) -> float:
    """Returns the number in a cell. Raises ValueError; Python alone reads `1_0` as 10."""
    if "_" in cell:
        raise ValueError(cell)
    return float(cell)


def _number(cell: str, factor: float, epoch: float) -> tuple[float, float] | None:
    try:
        return factor * number(cell) + epoch, 0.0
    except ValueError:
        return None
