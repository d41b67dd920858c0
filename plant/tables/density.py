"""The file of the density model's table: `density.csv` beside this module.

It is kept with the sources, so neither a build nor a run needs pymsis; plant.tables.density_fit makes it.
Tests: tests/plant/test_density.py.
"""

from __future__ import annotations

import csv
import io

import numpy as np

from ..atmosphere import ACTIVITY, AZIMUTH, DAY, QUANTITIES, DensityModel

FILE = "density.csv"

_HEADER = ["n", "m", "azimuth", "day", "activity", *QUANTITIES]
_SHAPE_ROWS = ("ap shape a", "ap shape b")


def parse(data: bytes) -> DensityModel:
    """The model out of the file that `dump` wrote."""
    header, *rows = csv.reader(io.StringIO(data.decode("ascii")))
    if header != _HEADER:
        raise ValueError(f"{FILE}: expected the columns {_HEADER}, found {header}")
    shape = [row for row in rows if row[0] in _SHAPE_ROWS]
    terms = [row for row in rows if row[0] not in _SHAPE_ROWS]
    return DensityModel(
        terms=np.array(
            [(int(n), int(m), AZIMUTH.index(a), DAY.index(d), ACTIVITY.index(s)) for n, m, a, d, s, *_ in terms]
        ),
        coefficients=np.array([[float(value or 0.0) for value in row[5:]] for row in terms]),
        ap_shape=np.array([[float(value) for value in row[5:]] for row in shape]),
    )


def dump(model: DensityModel) -> bytes:
    """The model as a CSV file: a row for each term, nothing where a quantity lacks it."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_HEADER)
    for name, values in zip(_SHAPE_ROWS, model.ap_shape, strict=True):
        writer.writerow([name, "", "", "", "", *(f"{value:.6g}" for value in values)])
    for (n, m, a, d, s), values in zip(model.terms, model.coefficients, strict=True):
        writer.writerow([n, m, AZIMUTH[a], DAY[d], ACTIVITY[s], *(f"{value:.7g}" if value else "" for value in values)])
    return text.getvalue().encode("ascii")
