"""Dates and sidereal time. UT1 is taken as UTC (they differ by less than 0.9 s, 0.004 deg of Earth rotation)."""

from __future__ import annotations

import math
import re
from calendar import isleap
from datetime import UTC, datetime, timedelta

EARTH_RATE = 7.2921158553e-5
"""Rate of GMST, rad/s: the Earth's rotation relative to the mean equinox of date."""

_J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)


_EPOCH = re.compile(r"\d{4}-\d\d-\d\d([T ]([01]\d|2[0-3]):\d\d(:\d\d([.,]\d+)?)?(Z|[+-]\d\d:\d\d)?)?", re.ASCII)


def parse_epoch(text: str) -> datetime:
    """A UTC date and time from the extended form of ISO 8601. Raises ValueError.

    2009-08-10, or 2009-08-10T12:00[:00[.5]] and Z, +00:00, -00:00 or nothing. A space may stand for the T and a comma
    for the point; digits beyond microseconds are dropped. Years 1 to 9999; no leap second.
    """
    try:
        if _EPOCH.fullmatch(text) is None:
            raise ValueError
        epoch = datetime.fromisoformat(text)
        if epoch.utcoffset() not in (None, timedelta(0)):
            raise ValueError
    except ValueError:
        raise ValueError(f"epoch: expected UTC in ISO 8601, such as 2009-08-10T12:00:00Z, found {text!r}") from None
    return epoch.replace(tzinfo=UTC)


def days_since_j2000(epoch: datetime) -> float:
    """Days of 86400 s from 2000-01-01 12:00 to `epoch`."""
    return (epoch - _J2000) / timedelta(days=1)


def gmst(epoch: datetime) -> float:
    """Greenwich mean sidereal time, rad in [0, 2 pi): IAU 1982 (Aoki et al., A&A 105, 1982)."""
    T = days_since_j2000(epoch) / 36525.0
    seconds = 67310.54841 + T * (876600.0 * 3600.0 + 8640184.812866 + T * (0.093104 - T * 6.2e-6))
    return math.radians((seconds % 86400.0) / 240.0)


def day_of_year(epoch: datetime) -> float:
    """Day of the year with its fraction elapsed, 1.0 at the start of 1 January."""
    return 1.0 + (epoch - datetime(epoch.year, 1, 1, tzinfo=UTC)) / timedelta(days=1)


def decimal_year(epoch: datetime) -> float:
    """The date as a year with its fraction elapsed, as the field models count time."""
    start = datetime(epoch.year, 1, 1, tzinfo=UTC)
    return epoch.year + (epoch - start) / timedelta(days=366 if isleap(epoch.year) else 365)
