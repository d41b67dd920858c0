"""What FMI 2.0 asks of every FMU, of both flavours alike: the experiment's limits, Booleans, and states."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

import pytest

from fmus.build import ensure
from fmus.interface import BLOCKS, load

from .host import Host


@pytest.fixture(params=["native", "python"])
def host(request: pytest.FixtureRequest) -> Iterator[Host]:
    with Host(ensure("controller", request.param)) as host:
        yield host


def _until(host: Host, stop: float, start: float = 0.0) -> None:
    host.fmu.setupExperiment(startTime=start, stopTime=stop)
    host.fmu.enterInitializationMode()
    host.fmu.exitInitializationMode()


# ------------------------------------------------------------------------------------------- the experiment


def test_a_step_beyond_the_stop_time_is_refused_and_changes_nothing(host: Host) -> None:
    """FMI 2.0, 2.1.6: an FMU that is asked to compute past a defined stopTime has to return fmi2Error."""
    _until(host, 1.0)
    host.step(0, count=10)
    before = host.serialized()
    message = host.refuses(lambda: host.step(10))
    assert "oStep: " in message
    assert "1.1" in message
    assert host.serialized() == before


def test_the_stop_time_is_counted_from_zero_and_not_from_the_start_time(host: Host) -> None:
    _until(host, 100.2, start=100.0)
    host.step(1000, count=2)
    host.refuses(lambda: host.step(1002))


@pytest.mark.parametrize("beyond", [1e-4, 9e-3])
def test_a_step_may_end_a_hundredth_of_itself_beyond_the_stop_time(host: Host, beyond: float) -> None:
    """A master that adds up a step of 0.1 s ten million times is 1.6e-4 s beyond its sum."""
    _until(host, 0.1 * (1.0 - beyond))
    host.step(0)


def test_a_step_that_ends_more_than_a_hundredth_of_itself_beyond_the_stop_time_is_refused(host: Host) -> None:
    _until(host, 0.1 * (1.0 - 1.1e-2))
    host.refuses(lambda: host.step(0))


def test_without_a_stop_time_and_after_a_reset_there_is_no_limit(host: Host) -> None:
    _until(host, 0.1)
    host.fmu.reset()
    host.started()
    host.step(0, count=3)


@pytest.mark.parametrize("stop", [-1.0, math.nan, math.inf])
def test_a_stop_time_below_the_start_time_or_not_finite_is_refused(host: Host, stop: float) -> None:
    message = host.refuses(lambda: host.fmu.setupExperiment(startTime=0.0, stopTime=stop))
    assert "expected a finite number, at least" in message
    _until(host, 0.0)


def test_initialization_without_an_experiment_is_refused(host: Host) -> None:
    assert "etupExperiment" in host.refuses(host.fmu.enterInitializationMode)
    host.started()
    host.fmu.reset()
    host.refuses(host.fmu.enterInitializationMode)


def test_a_restored_state_has_the_stop_time_that_it_was_saved_with(host: Host) -> None:
    _until(host, 0.2)
    host.step(0)
    data = host.serialized()
    host.fmu.reset()
    _until(host, 100.0)
    host.restore(data)
    host.step(1)
    host.refuses(lambda: host.step(2))


# ------------------------------------------------------------------------------------------- Booleans


@pytest.mark.parametrize("value", [7, -1, 256, 2**31 - 1, -(2**31)])
def test_a_boolean_is_zero_or_one_and_nothing_else(host: Host, value: int) -> None:
    (variable,) = [v for v in host.description.modelVariables if v.name == "compensate_gravity"]
    before = host.get("compensate_gravity")
    message = host.refuses(lambda: host.fmu.setBoolean([variable.valueReference], [value]))
    assert "expected fmi2False (0) or fmi2True (1), found " in message
    assert host.get("compensate_gravity") == before
    for good in (0, 1):
        host.fmu.setBoolean([variable.valueReference], [good])
        assert host.get("compensate_gravity") == good


# ------------------------------------------------------------------------------------------- states


@pytest.mark.parametrize("serialize", [False, True])
def test_a_restored_state_has_the_tunable_parameters_that_it_was_saved_with_and_their_law(
    host: Host, serialize: bool
) -> None:
    host.started(omega_B=[0.01, 0.02, 0.03], gain_schedule=2)
    host.step(0)
    first = host.get("kappa0"), host.get("tau_cmd_B")
    data = host.serialized()
    state = host.fmu.getFMUstate()
    host.set("kappa0", 7.0)
    host.set("lambda0", 5.0)
    host.step(1)
    assert host.get("tau_cmd_B") != first[1]
    if serialize:
        host.restore(data)
    else:
        host.fmu.setFMUstate(state)
    host.fmu.freeFMUstate(state)
    assert (host.get("kappa0"), host.get("tau_cmd_B")) == first
    host.step(1)  # the same inputs: the law of the parameters that were restored
    assert host.get("tau_cmd_B") == first[1]


@pytest.mark.parametrize("block", BLOCKS)
def test_the_step_of_the_default_experiment_divides_its_stop_time(block: str) -> None:
    """Hosts that make whole steps only, such as fmusim, refuse the others."""
    interface = load(block)
    assert Fraction(repr(interface.stop)) % Fraction(repr(interface.step)) == 0
