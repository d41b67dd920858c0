"""Gauss coefficients of the onboard field models, from the packages that maintain them; a built FMU carries them.

WMM 2010 to 2025 from pygeomag (the .COF files of NOAA/NCEI and BGS), IGRF-14 from 2000 on from ppigrf (the .shc file of
IAGA). They are the estimator's own, and not the plant's, so that they can be wrong without the plant being so. The
build writes the header of native/tables.py from them, which the planned controller includes too.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

PACKAGES = ("ppigrf", "pygeomag")
FILE = "gauss_models.json"
DEGREE = 13
TERMS = [(n, m) for n in range(1, DEGREE + 1) for m in range(n + 1)]
NAMES = ("igrf14", "wmm2010", "wmm2015", "wmm2020", "wmm2025")
"""In the order of the parameter field_model."""

_WMM = {"wmm2010": "WMM_2010.COF", "wmm2015": "WMM_2015v2.COF", "wmm2020": "WMM_2020.COF", "wmm2025": "WMM_2025.COF"}
_FIRST_YEAR = 2000.0
_HERE = Path(__file__).parent

Table = dict[tuple[int, int], list[float]]
"""Values at each epoch, by degree and order; a negative order stands for h."""


@dataclass(frozen=True)
class GaussModel:
    """Coefficients, nT, Schmidt semi-normalised: linear in time between the epochs, by the rates, nT/year, after the
    last.

    g and h hold for each epoch, g_rate and h_rate once, the values of TERMS.
    """

    years: list[float]
    valid_until: float
    g: list[list[float]]
    h: list[list[float]]
    g_rate: list[float]
    h_rate: list[float]

    def at(self, year: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """g and h (14, 14), nT, at a decimal year, by degree and order."""
        last = len(self.years) - 1
        i = max(k for k, first in enumerate(self.years) if k == 0 or first <= year)
        elapsed = year - self.years[i]
        found = np.zeros((2, DEGREE + 1, DEGREE + 1))
        for square, values, rate in zip(found, (self.g, self.h), (self.g_rate, self.h_rate), strict=True):
            now = np.array(values[i])
            if i < last:
                now = now + elapsed / (self.years[i + 1] - self.years[i]) * (np.array(values[i + 1]) - now)
            else:
                now = now + elapsed * np.array(rate)
            square[tuple(np.transpose(TERMS))] = now
        return found[0], found[1]


@cache
def gauss_model(name: str) -> GaussModel:
    """The model of this name, one of NAMES."""
    carried = _HERE / FILE
    return GaussModel(**json.loads(carried.read_bytes())[name]) if carried.exists() else _from_package(name)


def dump() -> dict[str, bytes]:
    """The file that an FMU carries."""
    models = {name: vars(_from_package(name)) for name in NAMES}
    return {FILE: json.dumps(models, separators=(",", ":")).encode()}


def _from_package(name: str) -> GaussModel:
    if name in _WMM:
        years, valid_until, values, rates = _cof(_package_file("pygeomag", f"wmm/{_WMM[name]}"))
    else:
        years, valid_until, values, rates = _shc(_package_file("ppigrf", "IGRF14.shc"))

    def column(table: Table, sign: int, i: int) -> list[float]:
        return [table[n, sign * m][i] if (n, sign * m) in table else 0.0 for n, m in TERMS]

    g, h = ([column(values, sign, i) for i in range(len(years))] for sign in (1, -1))
    return GaussModel(
        years, valid_until, g, _without_m_0(h), column(rates, 1, 0), _without_m_0([column(rates, -1, 0)])[0]
    )


def _without_m_0(rows: list[list[float]]) -> list[list[float]]:
    """h has no order 0."""
    return [[value if m else 0.0 for value, (_, m) in zip(row, TERMS, strict=True)] for row in rows]


def _package_file(package: str, path: str) -> Path:
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise ModuleNotFoundError(
            f"the field models' coefficients come from {package}, which is not installed: pip install {package}"
        )
    return Path(spec.submodule_search_locations[0], path)


def _cof(path: Path) -> tuple[list[float], float, Table, Table]:
    lines = path.read_text("ascii").splitlines()
    epoch = float(lines[0].split()[0])
    values: Table = {}
    rates: Table = {}
    for line in lines[1:]:
        if line.startswith("9999"):
            break
        n, m, g, h, g_rate, h_rate = (float(field) for field in line.split())
        values[int(n), int(m)], rates[int(n), int(m)] = [g], [g_rate]
        if m > 0:
            values[int(n), -int(m)], rates[int(n), -int(m)] = [h], [h_rate]
    return [epoch], epoch + 5.0, values, rates


def _shc(path: Path) -> tuple[list[float], float, Table, Table]:
    """After comments: a line of counts, the epochs, then n, m (negative for h) and a value for each epoch."""
    lines = [line.split() for line in path.read_text("ascii").splitlines() if line.strip() and line[0] != "#"]
    epochs = [float(field) for field in lines[1]]
    first = epochs.index(_FIRST_YEAR)
    values = {(int(n), int(m)): [float(x) for x in row[first:]] for n, m, *row in lines[2:]}
    years = epochs[first:]
    return years, years[-1], values, {}
