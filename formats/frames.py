"""The inertial frames of the formats, and how the frame N of a run is turned into them.

N is the mean equator and equinox of the epoch of the run, Greenwich being turned by GMST of IAU 1982. To it belongs
the precession of IAU 1976 (Lieske), so x_EME2000 = P^T x_N; x_GCRF = B^T x_EME2000 with the frame bias of IAU 2000.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from orchestration.errors import InputError, Place, Problem

from .instants import erfa

FRAMES = ("EME2000", "GCRF", "N")
NAMES = {"N": "MOE_EARTH", "EME2000": "EME2000", "GCRF": "GCRF"}
"""What SANA's registry calls them: MOE_EARTH is the mean equator and equinox of an epoch."""
_READ = {"J2000": "EME2000", "ICRF": "GCRF", "MOE_EARTH": "N", "MOD_EARTH": "N", "MOD": "N", "EME2000": "EME2000"}


def from_N(frame: str, tt: tuple[float, float]) -> NDArray[np.float64]:
    """Returns the matrix (3, 3) that takes components in N of an epoch to those of a frame.

    The epoch is a Julian date of TT in two parts.
    """
    if frame == "N":
        return np.eye(3)
    to_eme2000 = erfa().pmat76(*tt).T
    if frame == "EME2000":
        return np.asarray(to_eme2000)
    bias, _, _ = erfa().bp00(*tt)
    return np.asarray(bias.T @ to_eme2000)


def named(name: str, place: str) -> str:
    """Returns which of `FRAMES` a name of another tool means. Raises InputError for any other."""
    known = _READ.get(name.upper(), "GCRF" if name.upper().startswith("GCRF") else None)
    if known is None:
        expected = f"one of {', '.join(sorted({*_READ, 'GCRF'}))}"
        raise InputError(Problem(expected=expected, found=name, place=Place(place)))
    return known
