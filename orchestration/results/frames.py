"""A result as a data frame of pandas and as a data set of xarray."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import InputError
from .data import RunData


def to_pandas(result: RunData) -> Any:
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


def to_xarray(result: RunData) -> Any:
    """Returns a Dataset: each signal with its own dimensions besides `time`, counted as the FMU counts; `units` among
    its attributes.

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
        axes = [f"{name}_{axis}" for axis in range(1, values.ndim)]
        first = variable.first_index or (1,) * len(variable.shape)
        for axis, one, length in zip(axes, first, values.shape[1:], strict=False):
            coordinates[axis] = np.arange(one, one + length)
        attributes = {"units": result.units[name], "long_name": variable.description}
        variables[name] = (("time", *axes), values, {key: text for key, text in attributes.items() if text})
    return xarray.Dataset(variables, coordinates, {"scenario": result.scenario.name})


def _missing(package: str) -> InputError:
    return InputError(f"to_{package} needs the package {package}: pip install 'attitude-cosim[{package}]'")
