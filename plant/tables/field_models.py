"""Coefficients of the geomagnetic field models.

WMM 2010 to 2025 from pygeomag (the .COF files of NOAA/NCEI and BGS), IGRF-14 from ppigrf (the .shc file
of IAGA). Each file is found without importing its package. Tests: tests/plant/test_field.py.
"""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ..geomagnetic import FieldModel

FILE = "field_models.json"

_WMM = {"wmm2010": "WMM_2010.COF", "wmm2015": "WMM_2015v2.COF", "wmm2020": "WMM_2020.COF", "wmm2025": "WMM_2025.COF"}
NAMES = ("igrf14", *_WMM)

_DEGREE = 13
_WMM_LIFE = 5.0
"""Years for which a WMM is issued."""


def from_package(name: str) -> FieldModel:
    """Reads a model from the package that maintains it."""
    if name in _WMM:
        return _read_cof(_package_file("pygeomag", f"wmm/{_WMM[name]}"), name)
    return _read_shc(_package_file("ppigrf", "IGRF14.shc"), name)


def dump() -> bytes:
    """All models as one JSON file."""
    return json.dumps([_to_json(from_package(name)) for name in NAMES], separators=(",", ":")).encode()


def parse(data: bytes, name: str) -> FieldModel:
    """A model out of the file that `dump` wrote."""
    entry = next(entry for entry in json.loads(data) if entry["name"] == name)
    square = [_square(entry[key]) for key in ("g_dot", "h_dot")]
    sets = [np.array([_square(values) for values in entry[key]]) for key in ("g", "h")]
    return FieldModel(name, tuple(entry["epochs"]), entry["valid_until"], *sets, *square)


def _package_file(package: str, path: str) -> Path:
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise ModuleNotFoundError(
            f"the field models' coefficients come from {package}, which is not installed: pip install {package}"
        )
    return Path(spec.submodule_search_locations[0], path)


def _read_cof(path: Path, name: str) -> FieldModel:
    """A .COF file: a header with the epoch, then n, m, g, h and their secular variation, then a line of 9s."""
    header, *lines = path.read_text("ascii").splitlines()
    epoch = float(header.split()[0])
    g, h, g_dot, h_dot = np.zeros((4, _DEGREE + 1, _DEGREE + 1))
    for line in lines:
        if line.startswith("9999"):
            break
        n, m, *values = line.split()
        g[int(n), int(m)], h[int(n), int(m)], g_dot[int(n), int(m)], h_dot[int(n), int(m)] = map(float, values)
    return FieldModel(name, (epoch,), epoch + _WMM_LIFE, g[None], h[None], g_dot, h_dot)


def _read_shc(path: Path, name: str) -> FieldModel:
    """An .shc file: comments, a line of counts, the epochs, then n, m (negative for h) and a value for each epoch.

    IGRF's last epoch is its prediction, so its secular variation is the slope of the last interval and
    nothing is covered beyond it.
    """
    lines = [line for line in path.read_text("ascii").splitlines() if line.strip() and not line.startswith("#")]
    epochs = tuple(map(float, lines[1].split()))
    g, h = np.zeros((2, len(epochs), _DEGREE + 1, _DEGREE + 1))
    for line in lines[2:]:
        n, m, *values = line.split()
        (h if int(m) < 0 else g)[:, int(n), abs(int(m))] = list(map(float, values))
    span = epochs[-1] - epochs[-2]
    return FieldModel(name, epochs, epochs[-1], g, h, (g[-1] - g[-2]) / span, (h[-1] - h[-2]) / span)


_LOWER = [(n, m) for n in range(1, _DEGREE + 1) for m in range(n + 1)]


def _square(values: list[float]) -> np.ndarray:
    square = np.zeros((_DEGREE + 1, _DEGREE + 1))
    for (n, m), value in zip(_LOWER, values, strict=True):
        square[n, m] = value
    return square


def _to_json(model: FieldModel) -> dict[str, object]:
    def rows(array: np.ndarray) -> list[float]:
        return [float(array[n, m]) for n, m in _LOWER]

    return {
        "name": model.name,
        "epochs": model.epochs,
        "valid_until": model.valid_until,
        "g": [rows(a) for a in model.g],
        "h": [rows(a) for a in model.h],
        "g_dot": rows(model.g_dot),
        "h_dot": rows(model.h_dot),
    }
