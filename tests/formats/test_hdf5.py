"""HDF5, read by h5py and by xarray's reader of netCDF where a user has one."""

import json

import h5py

from formats.convert import convert

from .conftest import EPOCH


def test_each_signal_is_a_data_set_with_its_unit_on_the_scale_of_time(flown, tmp_path):
    (path,) = convert(flown, "hdf5", tmp_path / "run.h5")
    with h5py.File(path) as file:
        assert file.attrs["epoch"] == EPOCH
        assert file["time"][:].tolist() == flown.time.tolist()
        for name, values in flown.signals.items():
            found = file[name.replace(".", "/")]
            assert found[:].tolist() == values.tolist()
            assert found.attrs["units"] == flown.units.get(name, "")
            assert found.dims[0]["time"] == file["time"]
        assert json.loads(file["plant"].attrs["parameters"]) == {"epoch": EPOCH}


def test_a_run_without_epoch_has_none(flown, tmp_path):
    flown.parameters["plant"].clear()
    (path,) = convert(flown, "hdf5", tmp_path / "run.h5")
    with h5py.File(path) as file:
        assert "epoch" not in file.attrs
