"""A result as a data frame of pandas and as a data set of xarray."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from .data import RunData

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset


def to_pandas(result: RunData) -> DataFrame:
    """Returns a DataFrame: a row for each instant, a column for each recorded element, units in `attrs["units"]`.

    Raises InputError where pandas is missing.
    """
    try:
        import pandas  # optional, and slow to import  # noqa: PLC0415
    except ModuleNotFoundError:
        raise _missing("pandas") from None

    frame = pandas.DataFrame(
        {label: result[label].reshape(len(result.time)) for label in result.labels},
        index=pandas.Index(result.time, name="time"),
    )
    units = {label: result.unit_of_column(node) for label, node in zip(result.labels, result.columns, strict=True)}
    frame.attrs["units"] = {"time": "s", **units}
    return frame


def to_xarray(result: RunData) -> Dataset:
    """Returns a Dataset with `time`, `axis` for vectors of three, counted as the FMU counts, and `units` as attributes.

    A matrix (3, 3) has `row` and `axis`. Another length is named: `axis_4` of a quaternion; another first index, too.
    Raises InputError where xarray is missing.
    """
    try:
        import xarray  # optional, and slow to import  # noqa: PLC0415
    except ModuleNotFoundError:
        raise _missing("xarray") from None

    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": ("time", result.time, {"units": "s"})}
    for name in result:
        variable, values = result.variable(name), result[name]
        first = variable.first_index or (1,) * len(variable.shape)
        shape = values.shape[1:]
        axes = [
            _axis(len(shape) - place, length, one)
            for place, (length, one) in enumerate(zip(shape, first, strict=False), 1)
        ]
        coordinates |= {a: np.arange(one, one + n) for a, one, n in zip(axes, first, shape, strict=False)}
        attributes = {"units": result.units[name], "long_name": variable.description}
        variables[name] = (("time", *axes), values, {key: text for key, text in attributes.items() if text})
    return xarray.Dataset(variables, coordinates, {"scenario": result.scenario.name})


def _axis(before: int, length: int, first: int) -> str:
    """Returns the name of a dimension that so many others follow: one for all signals that have it."""
    name = ("axis", "row")[before] if before < 2 else f"row_{before}"
    return name + (f"_{length}" if length != 3 else "") + (f"_from_{first}" if first != 1 else "")


def _missing(package: str) -> InputError:
    return InputError(f"to_{package} needs the package {package}: pip install 'attitude-cosim[{package}]'")
