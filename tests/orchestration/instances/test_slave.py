"""The engine on real FMUs in C: a motor that integrates its voltage and a regulator, voltage = gain speed."""

from __future__ import annotations

import contextlib
import gc
import os
import re
import tempfile
import zipfile
from ctypes import byref
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi2 import defaultCallbacks
from fmpy.logging import addLoggerProxy

from orchestration import BlockError, InputError, run
from orchestration.fmu.archive import open_fmu
from orchestration.fmu.model import Element
from orchestration.instances.loading import in_words
from orchestration.instances.slave import Slave

from .. import fmus
from ..wrong_inputs import SCENARIO


def test_the_loop_is_that_of_explicit_euler(loop):
    result = run(loop)
    np.testing.assert_allclose(result["motor.speed"], 2.0 * 0.9 ** np.arange(21), rtol=1e-13)
    np.testing.assert_array_equal(result["regulator.voltage"], -result["motor.speed"])
    assert result["motor.steps"].tolist() == list(range(21))
    assert result["motor.steps"].dtype == np.int64
    assert result["motor.hot"].dtype == np.bool_


def test_parallel_exchange_feeds_the_motor_a_voltage_two_steps_old(loop):
    text = SCENARIO.replace("duration: 2 s", "duration: 2 s\nexchange: parallel")
    loop.write_text(text)
    result = run(loop)
    # What the regulator has at the start is -2 V, from initialization.
    speed = [2.0, 1.8]
    while len(speed) < 21:
        speed.append(speed[-1] - 0.1 * speed[max(len(speed) - 2, 0)])
    np.testing.assert_allclose(result["motor.speed"], speed, rtol=1e-13)


def test_overrides_are_start_values_step_and_duration(loop):
    result = run(loop, {"motor.speed0": "30 rpm", "step": "50 ms", "duration": 1, "motor.axis[2]": 3})
    assert result["motor.speed"][0] == pytest.approx(np.pi)
    assert result.time[-1] == 1.0
    assert len(result.time) == 11  # recorded every 0.1 s, as the scenario says
    assert result.manifest["scenario"]["blocks"]["motor"]["start"]["axis[2]"] == 3.0


def test_numpy_values_will_do_as_overrides(loop):
    result = run(loop, {"motor.axis": np.array([0.0, 1.0, 0.0]), "motor.speed0": np.float64(3.0)})
    assert result["motor.speed"][0] == 3.0
    assert result.manifest["scenario"]["blocks"]["motor"]["start"]["axis"] == [0.0, 1.0, 0.0]


def test_parameters_and_inputs_can_be_recorded(loop):
    text = SCENARIO.replace(
        "record: {interval: 0.1 s}", "record: {signals: [motor.axis, motor.voltage, motor.mode, motor.cooled]}"
    )
    loop.write_text(text)
    result = run(loop, {"motor.mode": "brake", "motor.cooled": True})
    assert result["motor.axis"].shape == (21, 3)
    assert set(result["motor.mode"]) == {2}
    assert result["motor.cooled"].all()
    assert result["motor.voltage"][0] == -2.0
    assert list(result) == [
        "motor.axis",
        "motor.voltage",
        "motor.mode",
        "motor.cooled",
        "motor.speed",
        "motor.hot",  # a boolean output, recorded whatever was asked for
    ]  # the last is expected


def test_several_blocks_may_be_made_of_one_fmu(tmp_path, monkeypatch):
    fmus.write_pair(tmp_path)
    monkeypatch.chdir(tmp_path)
    blocks = {
        name: {"fmu": "motor.fmu", "start": {"speed0": speed, "voltage": 1}} for name, speed in (("a", 1), ("b", 2))
    }
    result = run({"name": "two", "step": 0.5, "duration": 1, "blocks": blocks})
    np.testing.assert_allclose(result["a.speed"], [1.0, 1.5, 2.0])
    np.testing.assert_allclose(result["b.speed"], [2.0, 2.5, 3.0])


def test_a_failing_block_raises_and_what_was_computed_is_with_the_error(loop):
    with pytest.raises(
        BlockError, match=r"motor: fmi2DoStep at 1 s: gave status error\n  motor logged: \[error\] cannot step from 1"
    ) as info:
        run(loop, {"motor.fault": 1, "motor.fault_time": 1}, out=loop.parent / "kept")
    assert len(info.value.result["motor.speed"]) == 11
    assert info.value.result.manifest["outcome"] == "failed"
    assert len((loop.parent / "kept" / "signals.csv").read_text().splitlines()) == 12


def test_a_warning_is_no_failure(loop):
    result = run(loop, {"motor.fault": 6})
    assert result.failure is None
    assert len(result.time) == 21


def test_the_log_of_each_block_is_its_own(tmp_path):
    fmus.write_pair(tmp_path)
    slaves = []
    for name in ("one", "two"):
        fmu = open_fmu(tmp_path / "motor.fmu")
        fmu.extract(tmp_path / name)
        slaves.append(Slave(name, fmu, tmp_path / name))
    for slave, fault in zip(slaves, (1, 4), strict=True):
        slave.set([(Element("fault", 0), fault)])
        slave.wire([], [], [0, 0, 0, 0], np.zeros(0))
    for slave in slaves:
        with pytest.raises(BlockError):
            slave.do_step(0.0, 0.1)
    assert slaves[0].log == ("[error] cannot step from 0",)
    assert slaves[1].log == ("[discard] step too long: 0.1",)
    for slave in slaves:
        slave.close()
        slave.close()


def test_what_fmus_log_reaches_their_logs_although_fmpy_sets_its_own_logger(tmp_path):
    fmus.write_pair(tmp_path)
    fmu = open_fmu(tmp_path / "motor.fmu")
    fmu.extract(tmp_path / "one")
    slave = Slave("one", fmu, tmp_path / "one")
    addLoggerProxy(byref(defaultCallbacks))  # as FMPy does when it is imported
    slave.set([(Element("fault", 0), 1)])
    slave.wire([], [], [0, 0, 0, 0], np.zeros(0))
    with pytest.raises(BlockError):
        slave.do_step(0.0, 0.1)
    assert slave.log == ("[error] cannot step from 0",)
    slave.close()


@pytest.mark.skipif(os.name == "nt", reason="the path of the temporary folder differs")
@pytest.mark.parametrize("fault", [0, 1, 2, 3, 5])
def test_nothing_is_left_in_the_temporary_folder(loop, fault, tmp_path, monkeypatch):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    with contextlib.suppress(BlockError):
        run(loop, {"motor.fault": fault})
    gc.collect()
    assert list(temporary.iterdir()) == []
    assert Path.cwd() == loop.parent


def test_vectors_limits_units_and_dependencies_are_read_from_the_fmu(tmp_path):
    fmus.write_pair(tmp_path, runnable=False)
    model = open_fmu(tmp_path / "motor.fmu").model
    axis, inertia, mode = (model.variables[name] for name in ("axis", "inertia", "mode"))
    assert (axis.shape, axis.references) == ((3,), (11, 12, 13))
    assert (inertia.minima, inertia.maxima) == ((0.001,), (10.0,))
    assert mode.items == (("normal", 1), ("brake", 2))
    assert model.variables["speed"].unit.name == "rad/s"
    regulator = open_fmu(tmp_path / "regulator.fmu").model
    assert regulator.feedthrough[Element("voltage", 0)] == {Element("speed", 0)}
    assert regulator.feedthrough[Element("samples", 1)] == frozenset()


@pytest.mark.parametrize(
    ("loader", "words"),
    [
        (
            "Failed to load shared library binaries/linux64/x.so. libfoo.so.3: cannot open shared object file: No "
            "such file or directory",
            "it needs the library libfoo.so.3, which is not on this machine; remedy: install it, or pack it into "
            "the FMU beside its library",
        ),
        ("x.so: undefined symbol: start", "x.so needs the symbol start, which no library that is loaded has"),
        ("x.so: undefined symbol: fmi2DoStep", "x.so lacks the function fmi2DoStep"),
        ("x.so: wrong ELF class: ELFCLASS32", "x.so is for another processor"),
        (
            "/lib/libc.so.6: version `GLIBC_2.99' not found (required by x.so)",
            "x.so needs GLIBC_2.99, which the libraries of this system are too old for",
        ),
        ("something else", "something else"),
    ],
)
def test_what_the_loader_says_is_put_in_plain_words(loader, words):
    assert in_words(loader) == words


def test_a_full_disk_while_unpacking_is_named_and_not_blamed_on_the_scenario(loop, monkeypatch):
    def full(*arguments, **options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(zipfile.ZipFile, "extractall", full)
    with pytest.raises(InputError) as info:
        run(loop)
    place = re.escape(f"{tempfile.gettempdir()}{os.sep}")
    expected = (
        rf"motor\.fmu cannot be unpacked in {place}.*: the disk is full; remedy: room there, or another "
        rf"folder in TMPDIR"
    )
    assert re.fullmatch(expected, str(info.value))
