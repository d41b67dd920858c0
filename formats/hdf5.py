"""Writes the signals of a run as HDF5: a group a block, a data set a signal, units and the epoch as attributes."""

from __future__ import annotations

import json
from pathlib import Path

from .instants import missing
from .recorded import Recorded


def write(data: Recorded, path: Path, epoch: str | None) -> None:
    """`/time` (n,), `/plant/R_NB` (n, 3, 3) and so on; `units` of each, `epoch` and `parameters` (JSON) of the file.

    Time is the first dimension's scale, so that xarray and netCDF find it. Raises InputError without h5py.
    """
    try:
        import h5py  # optional, and slow to import  # noqa: PLC0415
    except ModuleNotFoundError:
        raise missing("h5py") from None
    with h5py.File(path, "w") as file:
        file.attrs["scenario"] = data.name
        if epoch is not None:
            file.attrs["epoch"] = epoch
        time = file.create_dataset("time", data=data.time)
        time.attrs["units"] = "s"
        time.make_scale("time")
        for name, values in data.signals.items():
            block, _, variable = name.partition(".")
            made = file.create_dataset(f"{block}/{variable.replace('/', '_x002F_')}", data=values, compression="gzip")
            made.attrs["units"] = data.units.get(name, "")
            made.dims[0].attach_scale(time)
        for block, parameters in data.parameters.items():
            file.require_group(block).attrs["parameters"] = json.dumps(parameters)
