"""C tables of the onboard field models' Gauss coefficients, read at build time from the packages that maintain them.

WMM 2010 to 2025 from pygeomag (the .COF files of NOAA/NCEI and BGS), IGRF-14 from 2000 on from ppigrf (the .shc file of
IAGA). The controller has these of its own, so that it can be wrong without the plant being so.
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

_WMM = {
    "wmm2010": "WMM_2010.COF",
    "wmm2015": "WMM_2015v2.COF",
    "wmm2020": "WMM_2020.COF",
    "wmm2025": "WMM_2025.COF",
}
_FIRST_YEAR = 2000.0
_TERMS = [(n, m) for n in range(1, 14) for m in range(n + 1)]

Table = dict[tuple[int, int], list[float]]
"""By degree and order; a negative order stands for h."""


def generated() -> dict[str, str]:
    """C sources by file name."""
    parts = [
        '/* Written by controller/planned/native/tables.py from the packages that it names. */\n\n#include "onboard.h"\n'
    ]
    rows = []
    for name, (years, valid_until, values, rates) in _models().items():
        parts.append(f"static const double {name}_years[] = {_list(years)};")
        for letter, sign in (("g", 1), ("h", -1)):
            sets = [
                _list(values[n, sign * m][i] if (n, sign * m) in values else 0.0 for n, m in _TERMS)
                for i in range(len(years))
            ]
            parts.append(f"static const double {name}_{letter}[][ONBOARD_TERMS] = {{\n" + ",\n".join(sets) + "};")
            slope = _list(rates[n, sign * m][0] if (n, sign * m) in rates else 0.0 for n, m in _TERMS)
            parts.append(f"static const double {name}_{letter}_rate[] = {slope};")
        covered = f"a date that {name} covers, {years[0]:.1f} to {valid_until:.1f}"
        arrays = ", ".join(f"{name}_{part}" for part in ("g", "h", "g_rate", "h_rate"))
        rows.append(f'    {{{len(years)}, {name}_years, "{covered}", {valid_until!r}, {arrays}}}')
    parts.append("const GaussModel controller_planned_gauss_models[] = {\n" + ",\n".join(rows) + "\n};\n")
    return {"gauss_models.c": "\n".join(parts)}


PACKAGES = ("ppigrf", "pygeomag")


def _models() -> dict[str, tuple[list[float], float, Table, Table]]:
    """In the order of the parameter field_model: epochs, last year, coefficients and their rates after the last epoch."""
    models = {"igrf14": _shc(_package_file("ppigrf", "IGRF14.shc"))}
    return models | {name: _cof(_package_file("pygeomag", f"wmm/{file}")) for name, file in _WMM.items()}


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


def _list(values: Iterable[float]) -> str:
    return "{" + ", ".join(repr(float(value)) for value in values) + "}"
