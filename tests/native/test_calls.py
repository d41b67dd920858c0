"""The FMI shell's calls: their order, steps, refusals that change nothing, and what is logged."""

from __future__ import annotations

import math
from ctypes import byref, c_char_p, c_double, c_uint

import numpy as np
import pytest

from .driver import ERROR, Instance, Refused, references, running, same


def test_calls_out_of_order_are_refused_and_change_nothing() -> None:
    with Instance("allocator") as it:
        for call, arguments in (("ExitInitializationMode", ()), ("DoStep", (0.0, 0.1, 1)), ("Terminate", ())):
            with pytest.raises(Refused, match="not allowed before fmi2EnterInitializationMode"):
                it.call(call, *arguments)
        it.initialize()
        for call, arguments in (("EnterInitializationMode", ()), ("SetupExperiment", (0, 0.0, 0.0, 0, 0.0))):
            with pytest.raises(Refused, match="not allowed in step mode"):
                it.call(call, *arguments)
        with pytest.raises(Refused, match="dipole_max is a fixed parameter and cannot be set after initialization"):
            it.set("dipole_max", 20.0)
        with pytest.raises(Refused, match="holding is an output and cannot be set"):
            it.set("holding", True)
        with pytest.raises(Refused, match="holding is of type boolean, not real"):
            it.call("GetReal", references(it.interface.variables["holding"].value_references[0]), 1, (c_double * 1)())
        with pytest.raises(Refused, match="value reference: expected that of a variable of this FMU, found 1000"):
            it.call("GetReal", references(1000), 1, (c_double * 1)())
        with pytest.raises(Refused, match="an array is NULL"):
            it.call("GetReal", references(0), 1, None)
        it.set("hold_fraction", 0.9)  # tunable
        it.step(0.0, 0.1)
        it.call("Terminate")
        assert it.get("hold_fraction") == 0.9
        for call, arguments in (("DoStep", (0.1, 0.1, 1)), ("Terminate", ())):
            with pytest.raises(Refused, match="not allowed after fmi2Terminate"):
                it.call(call, *arguments)
        it.call("Reset")
        assert it.get("hold_fraction") == 0.8
        it.initialize()


def test_a_set_of_several_values_is_all_or_nothing() -> None:
    with Instance("controller") as it:
        with pytest.raises(Refused, match=r"K0\[3\]"):
            it.set("K0", [0.1, 0.2, math.nan])
        assert it.get("K0").tolist() == it.interface.variables["K0"].start


def test_references_in_any_order_across_variables_set_and_get_their_own() -> None:
    """Runs that end within a variable, that run backwards, repeat and jump; a value that is not finite ends none
    quietly."""
    with Instance("controller") as it:
        first = it.interface.variables["R_NB"].value_references[0]
        for order in ([7, 8, 9, 10, 11, 12, 2, 1, 0, 15, 16], [17, 16, 15], [3, 4, 5, 3], list(range(18))):
            n = len(order)
            places = (c_uint * n)(*(first + i for i in order))
            it.call("SetReal", places, n, (c_double * n)(*(100.0 + i for i in order)))
            read = (c_double * n)()
            it.call("GetReal", places, n, read)
            assert list(read) == [100.0 + i for i in order]
        assert it.get("v_N").tolist() == [115.0, 116.0, 117.0]
        with pytest.raises(Refused, match=r"omega_B\[2\].*infinity"):
            it.call("SetReal", (c_uint * 18)(*range(first, first + 18)), 18, (c_double * 18)(*[0.0] * 10, math.inf))
        assert it.get("R_NB").ravel().tolist() == [100.0 + i for i in range(9)]


@pytest.mark.parametrize(
    ("t", "h"), [(0.0, 0.0), (0.0, -0.1), (0.0, math.nan), (0.0, math.inf), (0.05, 0.1), (math.nan, 0.1)]
)
def test_a_step_of_no_length_or_from_another_time_is_refused(t: float, h: float) -> None:
    with running("plant") as it:
        before = it.outputs()
        with pytest.raises(Refused, match="fmi2DoStep: .*expected"):
            it.step(t, h)
        assert same(before, it.outputs())
        it.step(0.0, 0.1)


def test_a_step_that_fails_changes_nothing() -> None:
    with running("controller", reference="lvlh") as it:
        it.step(0.0, 0.1)
        before = it.outputs()
        it.set("R_NB", np.diag([1.0, 1.0, 1.01]))
        with pytest.raises(
            Refused, match=r"R_NB: expected a rotation matrix, max \|R_NB\^T R_NB - I\| at most 0.0001, found 0.0201"
        ):
            it.step(0.1, 0.1)
        it.set("R_NB", np.eye(3))
        assert same(before, it.outputs())
        it.step(0.1, 0.1)


def test_the_experiment_may_start_at_any_time() -> None:
    with running("plant") as zero, Instance("plant") as later:
        later.initialize(start=100.0)
        zero.step(0.0, 0.1)
        later.step(100.0, 0.1)
        assert same(zero.outputs(), later.outputs())
        time = c_double()
        later.call("GetRealStatus", 2, byref(time))
        assert time.value == 100.1


def test_in_initialization_mode_outputs_follow_the_inputs_and_nothing_is_latched() -> None:
    with Instance("controller") as it, running("controller", omega_B=[0.0, 0.0, 0.0]) as other:
        it.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        it.call("EnterInitializationMode")
        it.set("omega_B", [0.3, 0.2, 0.1])
        first = it.get("rate_error_B")
        it.set("omega_B", [0.0, 0.0, 0.0])
        assert not np.array_equal(it.get("rate_error_B"), first)
        it.call("ExitInitializationMode")
        assert same(it.outputs(), other.outputs())


def test_errors_are_always_logged_and_events_where_logging_is_on() -> None:
    with Instance("allocator") as quiet, Instance("allocator", log=True) as talking:
        for it in (quiet, talking):
            it.initialize()
        assert quiet.messages == []
        assert [message for *_, message in talking.messages] == ["instantiated", "initialized"]
        assert {category for _, category, _ in talking.messages} == {"logAll"}
        talking.call("SetDebugLogging", 0, 0, None)
        talking.call("Reset")
        assert len(talking.messages) == 2
        quiet.call("SetDebugLogging", 1, 1, (c_char_p * 1)(b"logAll"))
        quiet.call("Reset")
        assert quiet.messages == [(0, "logAll", "reset")]
        quiet.call("SetDebugLogging", 0, 2, (c_char_p * 2)(b"logStatusError", b"logAll"))
        with pytest.raises(Refused, match="expected a category of the modelDescription.xml, found nonsense"):
            quiet.call("SetDebugLogging", 1, 1, (c_char_p * 1)(b"nonsense"))
        assert quiet.messages[-1][:2] == (ERROR, "logStatusError")


@pytest.mark.parametrize(
    "value",
    [
        0.0,
        1.0,
        -1.0,
        0.1,
        123456789.0,
        1234567890.0,
        1e-5,
        1.5e-5,
        1e-300,
        1e308,
        9.9999999999e-5,
        0.0001234,
        3.141592653589793,
    ],
)
def test_numbers_in_messages_read_as_printf_g(value: float) -> None:
    with running("plant") as it, pytest.raises(Refused) as refusal:
        it.step(value + 0.5 if abs(value) < 10.0 else value, 0.1)
    shown = value + 0.5 if abs(value) < 10.0 else value
    assert str(refusal.value).endswith(f"found {shown:.9g}")
