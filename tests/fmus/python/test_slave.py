"""What an FMU does at Set, Get and doStep, as different masters call it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fmus.build import blocks_of

from ..host import Host


def test_start_values_are_those_of_the_interface_whatever_their_type(path: Path) -> None:
    with Host(path) as host:
        assert host.get("rate") == [1.0, 2.0]
        assert host.get("hold") == 0
        assert host.get("mode") == 1
        assert host.get("order") == 2
        assert host.get("label") == "50 %s of nothing"
        assert host.get("offset") == [0.5, 0.25]


def test_in_initialization_every_get_follows_the_inputs_and_latches_nothing(path: Path) -> None:
    with Host(path) as host:
        host.fmu.setupExperiment(startTime=0.0)
        host.fmu.enterInitializationMode()
        for rate in ([3.0, 4.0], [6.0, 8.0]):
            host.set("rate", rate)
            assert host.get("speed") == 2.0 * math.hypot(*rate)
            assert host.get("first_rate") == rate
        host.set("label", "äöü")
        host.set("mode", 2)
        assert (host.get("label_used"), host.get("mode_used")) == ("äöü", 2)
        host.fmu.exitInitializationMode()
        host.set("rate", [1.0, 1.0])
        assert host.get("first_rate") == [6.0, 8.0]


def test_a_get_after_a_set_reevaluates_feedthrough_and_leaves_memory_alone(path: Path) -> None:
    """OMSimulator reads outputs so, between two steps."""
    with Host(path) as asked, Host(path) as left_alone:
        for host in (asked, left_alone):
            host.started(mode=2)
        for k in range(5):
            for trial in ([30.0, 40.0], [-1.0, 0.0]):
                asked.set("rate", trial)
                assert asked.get("speed") == 2.0 * math.hypot(*trial)
                assert asked.get("steps") == k
            for host in (asked, left_alone):
                host.set("rate", [1.0, 0.5 * k])
                host.step(k)
            assert asked.outputs() == left_alone.outputs()


def test_a_block_sees_the_inputs_last_set_under_sequential_exchange_and_those_of_the_step_before_under_parallel(
    path: Path,
) -> None:
    """Two integrators in a chain; exact integration of a ramp of inputs shows each delay in the sum."""
    sums = {}
    for exchange in ("sequential", "parallel", "two steps late"):
        with Host(path) as first, Host(path) as second:
            first.started(mode=2, rate=[1.0, 0.0], offset=[0.0, 0.0])
            second.started(mode=2, rate=[0.0, 0.0], offset=[0.0, 0.0])
            late = [[0.0, 0.0]] * 2
            for k in range(4):
                if exchange == "sequential":
                    first.step(k)
                    second.set("rate", first.get("sum"))
                else:
                    late.append(first.get("sum"))
                    second.set("rate", late[-1] if exchange == "parallel" else late[-3])
                    first.step(k)
                second.step(k)
            sums[exchange] = second.get("sum")[0] / 0.01
    assert sums == pytest.approx(
        {"sequential": 1 + 2 + 3 + 4, "parallel": 0 + 1 + 2 + 3, "two steps late": 0 + 0 + 0 + 1}
    )


def test_a_tunable_parameter_may_change_between_steps_and_a_fixed_one_may_not(path: Path) -> None:
    with Host(path) as host:
        host.started()
        host.set("gain", 3.0)
        assert host.get("speed") == 3.0 * math.hypot(1.0, 2.0)
        with pytest.raises(Exception, match="error"):
            host.set("order", 3)
        assert "order cannot be set, it is fixed once initialization is over" in host.log[-1][2]


def test_reset_makes_an_instance_as_new(path: Path) -> None:
    with Host(path) as used, Host(path) as fresh:
        used.started(mode=2, rate=[9.0, 9.0], gain=5.0, label="other")
        used.step(0, count=7)
        used.fmu.reset()
        assert used.serialized() == fresh.serialized()
        for host in (used, fresh):
            host.started(rate=[0.5, 0.25])
            host.step(0, count=3)
        assert used.outputs() == fresh.outputs()


def test_a_start_time_shifts_the_block_s_clock(path: Path) -> None:
    with Host(path) as shifted, Host(path) as host:
        host.started()
        shifted.fmu.setupExperiment(startTime=100.0)
        shifted.fmu.enterInitializationMode()
        shifted.fmu.exitInitializationMode()
        host.step(0, h=0.5, count=3)
        shifted.step(200, h=0.5, count=3)
        assert shifted.outputs() == host.outputs()


def _drive(host: Host, block: str, k: int, count: int) -> None:
    """Steps with inputs that change, so that memory matters: the same for the same k."""
    for i in range(k, k + count):
        wave = math.sin(0.7 * i)
        if block == "plant":
            host.set("dipole_cmd", [wave, 0.3, -wave])
            host.set("wheel_torque_cmd", 1e-4 * wave)
        elif block == "plant_wheels":
            host.set("dipole_cmd", [wave, 0.3, -wave])
            host.set("wheel_torque_cmd", [1e-4 * wave, 0.0, -1e-4, 0.0])
        elif block in ("controller", "plant_judge", "supervisor"):
            host.set("omega_B", [0.02 * wave, 0.01, 0.003])
        elif block.startswith("allocator"):
            host.set("tau_cmd_B", [2e-3 * wave, 1e-3 * math.cos(i), 3e-4])
        elif block.startswith("estimator"):
            host.set("omega_B_measured", [0.02 * wave, 0.01, 0.003])
            host.set("R_NB_measured", Rotation.from_rotvec([0.1 * wave, 0.2, 0.3]).as_matrix())
        elif block.startswith("plant_sensors"):
            host.set("omega_B", [0.02 * wave, 0.01, 0.003])
            host.set("rate_noise", 1e-3)
        else:
            host.set("rate", [wave, 1.0])
        host.step(i)


@pytest.mark.parametrize("block", [*blocks_of("python"), "toy"])
@pytest.mark.parametrize("way", ["same instance", "same instance, twice", "other instance by bytes"])
def test_a_run_restored_at_half_time_ends_in_the_same_bits(
    built_fmus: dict[str, Path], path: Path, block: str, way: str
) -> None:
    chosen = path if block == "toy" else built_fmus[block]
    with Host(chosen) as host, Host(chosen) as other:
        host.started()
        _drive(host, block, 0, 20)
        state, data = host.fmu.getFMUstate(), host.serialized()
        _drive(host, block, 20, 20)
        expected = host.serialized()
        for _ in range(2 if "twice" in way else 1):
            if "bytes" in way:
                other.restore(data)
                assert other.serialized() == data
                host, other = other, host
            else:
                host.fmu.setFMUstate(state)
            _drive(host, block, 20, 20)
            assert host.serialized() == expected
        (other if "bytes" in way else host).fmu.freeFMUstate(state)


def test_a_saved_state_brings_back_inputs_parameters_and_memory_whatever_came_after(path: Path) -> None:
    with Host(path) as host, Host(path) as undisturbed:
        for h in (host, undisturbed):
            h.started().step(0)
        before, state = host.serialized(), host.fmu.getFMUstate()
        host.set("rate", [7.0, 7.0])
        host.set("gain", 9.0)
        host.step(1, count=3)
        host.fmu.setFMUstate(state)
        assert host.serialized() == before
        for h in (host, undisturbed):
            h.step(1, count=2)
        assert host.serialized() == undisturbed.serialized()
        host.fmu.freeFMUstate(state)
        host.fmu.freeFMUstate(state)  # of nothing: allowed


@pytest.mark.parametrize("block", blocks_of("python"))
def test_the_fmu_gives_what_the_block_gives_when_called_directly(built_fmus: dict[str, Path], block: str) -> None:
    from tests.blocks import inputs, parameters
    from tests.blocks import module as package

    module = package(block)
    p, u = parameters(block), inputs(block)
    module.check(p)
    x = module.start(p, u)
    with Host(built_fmus[block]) as host:
        host.started()
        out = module.outputs(x, u, p)
        for k in range(4):
            for name, value in host.outputs().items():
                expected = getattr(out, name)
                assert np.array_equal(np.ravel(expected), np.ravel(value)), (k, name)
            x, out = module.step(x, u, p, 0.1)
            host.step(k)


def test_a_block_with_a_sample_period_acts_at_its_own_instants_and_holds_in_between(path: Path) -> None:
    """As one without that the host steps at these instants only; a saved state has their count."""
    with Host(path) as own, Host(path) as slow:
        own.started(mode=1, sample_period=0.5)
        slow.started(mode=1)
        saved = b""
        for k in range(12):
            own.set("rate", [3.0, 4.0 * k])
            own.step(k)
            if k == 6:
                saved = own.serialized()
            if k % 5 == 4:
                slow.set("rate", [3.0, 4.0 * k])
                slow.step(k // 5, h=0.5)
            assert own.outputs() == slow.outputs()
            held = own.get("speed")
            own.set("rate", [30.0, 40.0])  # a Get after a Set evaluates the law at own instants only
            assert own.get("speed") == (100.0 if k % 5 == 4 else held)
            own.set("rate", [3.0, 4.0 * k])
            own.get("speed")
        own.restore(saved)
        for k in range(7, 12):
            own.set("rate", [3.0, 4.0 * k])
            own.step(k)
        assert own.outputs() == slow.outputs()
        assert "at most sample_period = 0.5 s" in own.refuses(lambda: own.step(2, h=0.6))
