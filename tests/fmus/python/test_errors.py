"""A call that goes wrong ends as fmi2Error with a message that helps, and the host lives on."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import make_dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import fmpy
import numpy as np
import pytest

from fmus.build import ROOT, blocks_of
from fmus.interface import parse
from fmus.python.memory import ContractError, Layout
from orchestration import BlockError, run

from ..host import Host
from ..toy import INTERFACE


def test_an_exception_in_a_step_is_logged_with_its_traceback_and_ends_as_an_error(path: Path) -> None:
    with Host(path) as host:
        host.started(label="fail")
        message = host.refuses(lambda: host.step(0))
        assert message.startswith("toy: ValueError: rate: 100 %% wrong \\udc80\nTraceback")
        assert "block.py" in message
        assert "in step" in message


def test_a_traceback_names_the_file_as_it_stands_in_the_archive(path: Path) -> None:
    entry = {"fmu": str(path), "start": {"label": "fail", "hold": False, "rate": [1.0, 1.0]}}
    with pytest.raises(BlockError) as failed:
        run({"name": "failing", "step": 1.0, "duration": 1.0, "blocks": {"toy": entry}})
    places = [line for line in failed.value.log if 'File "' in line]
    assert places
    assert all('File "resources/' in line for line in places)


def test_after_an_error_the_instance_stands_where_it_stood_and_every_call_is_safe(path: Path) -> None:
    with Host(path) as host, Host(path) as unharmed:
        for h in (host, unharmed):
            h.started().step(0, count=3)
        for _ in range(200):
            host.set("rate", [2e6, 0.0])
            message = host.refuses(lambda: host.step(3))
            assert "output sum[1] is inf; expected a finite number" in message
            host.get("sum")
        for h in (host, unharmed):
            h.set("rate", [1.0, 1.0])
            h.step(3)
        assert host.serialized() == unharmed.serialized()
        host.fmu.reset()
        host.started().step(0)
        host.fmu.terminate()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"sum": np.zeros(3)}, "output sum: expected an array of shape (2,), found one of shape (3,), float64"),
        (
            {"sum": np.zeros(3), "first_rate": np.zeros(1)},
            "output sum: expected an array of shape (2,), found one of shape (3,)",
        ),
        ({"sum": [0.0, 0.0]}, "output sum: expected an array of shape (2,), found [0.0, 0.0]"),
        (
            {"sum": np.array([None, 0.0])},
            "output sum: expected an array of shape (2,), found one of shape (2,), object",
        ),
        ({"speed": None}, "output speed: expected a scalar, real, found None"),
        ({"holding": None}, "output holding: expected a scalar, boolean, found None"),
        ({"holding": 1.0}, "output holding: expected a scalar, boolean, found 1.0"),
        ({"label_used": None}, "output label_used: expected a scalar, string, found None"),
        ({"mode_used": "slow"}, "output mode_used: expected one of leaky, exact, found 'slow'"),
    ],
)
def test_an_output_that_is_not_as_the_interface_says_is_named(wrong: dict[str, Any], message: str) -> None:
    interface = parse(INTERFACE)
    block: Any = ModuleType("block")
    for causality in ("parameter", "input", "output"):
        names = [v.name for v in interface.of(causality)]
        setattr(block, f"{causality.title()}s", make_dataclass(causality, names))
    layout = Layout(interface, block)
    right: dict[str, Any] = {"sum": np.zeros(2), "first_rate": np.zeros(2), "speed": 0.0, "steps": 0}
    right |= {"holding": False, "mode_used": "exact", "label_used": ""}
    layout.store(block.Outputs(**right), layout.starts)
    with pytest.raises(ContractError) as error:
        layout.store(block.Outputs(**{**right, **wrong}), layout.starts)
    assert str(error.value).startswith(message)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_value_that_is_not_finite_is_refused_by_name_and_not_stored(path: Path, value: float) -> None:
    with Host(path) as host:
        host.started()
        message = host.refuses(lambda: host.set("rate", [5.0, value]))
        assert message == f"toy: setReal: rate[2] = {value}; expected a finite number"
        assert host.get("rate") == [1.0, 2.0]


@pytest.mark.parametrize("block", blocks_of("python"))
def test_no_real_variable_of_a_block_accepts_nan(built_fmus: dict[str, Path], block: str) -> None:
    with Host(built_fmus[block]) as host:
        for variable in host.description.modelVariables:
            if variable.type == "Real" and variable.causality != "output":
                message = host.refuses(lambda v=variable: host.fmu.setReal([v.valueReference], [math.nan]))
                assert f"{variable.name} = nan" in message


@pytest.mark.parametrize("step", [0.0, -0.1, math.nan, math.inf])
def test_a_step_that_is_no_step_is_refused(path: Path, step: float) -> None:
    with Host(path) as host:
        host.started()
        message = host.refuses(lambda: host.fmu.doStep(0.0, step))
        assert message == f"toy: doStep: the step is {step} s; expected a finite number above 0"
        host.step(0)


def test_a_step_from_another_time_than_the_block_s_is_refused(path: Path) -> None:
    with Host(path) as host:
        host.started().step(0, count=2)
        message = host.refuses(lambda: host.step(3))
        assert "the step starts at 0.3" in message
        assert "the block is at 0.2 s" in message
        assert "nan" in host.refuses(lambda: host.fmu.doStep(math.nan, 0.1))


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("gain", -1.0, "gain = -1.0; expected 0.0 to 100.0"),
        ("order", 7, "order = 7; expected 1 to 6"),
        ("mode", 3, "mode = 3; expected 1 to 2"),
        ("mode", 0, "mode = 0; expected 1 to 2"),
        ("sum", [0.0, 0.0], "sum[1] cannot be set, it is an output"),
    ],
)
def test_a_value_out_of_range_is_refused_with_its_range(path: Path, name: str, value: object, said: str) -> None:
    with Host(path) as host:
        assert said in host.refuses(lambda: host.set(name, value))


def test_a_value_reference_of_another_type_or_of_nothing_is_refused(path: Path) -> None:
    with Host(path) as host:
        assert "no Real with the value reference 2" in host.refuses(lambda: host.fmu.getReal([2]))
        assert "no Integer with the value reference 999" in host.refuses(lambda: host.fmu.setInteger([999], [1]))


def test_parameters_that_the_block_refuses_end_initialization_with_its_words(path: Path) -> None:
    with Host(path) as host:
        assert "label: expected anything but 'wrong'" in host.refuses(lambda: host.started(label="wrong"))
        host.set("label", "right")
        host.fmu.exitInitializationMode()
        host.step(0)


def test_calls_in_the_wrong_mode_are_refused(path: Path) -> None:
    with Host(path) as host:
        assert "doStep: the block is instantiated" in host.refuses(lambda: host.step(0))
        host.started()
        assert "enterInitializationMode: the block is stepping" in host.refuses(host.fmu.enterInitializationMode)


def test_a_state_of_another_build_or_no_state_at_all_is_refused(path: Path, built_fmus: dict[str, Path]) -> None:
    with Host(path) as host, Host(built_fmus["allocator"]) as other:
        for data in (other.started().serialized(), b"\x00\xffnonsense", b"{}", b"[]"):
            assert "cannot be restored" in host.refuses(lambda d=data: host.restore(d))
        host.started().step(0)


def test_a_wrong_guid_gives_no_instance_and_says_why(path: Path) -> None:
    with Host(path) as host:
        wrong = fmpy.fmi2.FMU2Slave(
            guid="{wrong}", unzipDirectory=str(host.folder), modelIdentifier="toy", instanceName="wrong"
        )
        with pytest.raises(Exception, match="instantiate"):
            wrong.instantiate(callbacks=host._callbacks)
        assert "the GUID differs" in host.log[-1][2]


def test_a_host_that_goes_on_after_errors_ends_well(path: Path) -> None:
    """In a process of its own: wrongly counted references would end it with a signal."""
    code = f"""
import gc
from tests.fmus.host import Host
for round in range(20):
    with Host({str(path)!r}) as host:
        host.started(label="fail" if round % 2 else "fine")
        for k in range(50):
            nan = [float("nan")] * 2
            for call in (lambda: host.step(0, h=-1.0), lambda: host.set("rate", nan), lambda: host.restore(b"x")):
                try:
                    call()
                except Exception:
                    pass
            host.outputs()
            if k % 10 == 0:
                host.fmu.reset()
                host.started()
        gc.collect()
print("alive")
"""
    run = subprocess.run([sys.executable, "-X", "dev", "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr[-2000:]
    assert run.stdout.strip() == "alive"
