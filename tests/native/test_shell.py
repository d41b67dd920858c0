"""The FMI shell: order of calls, refusals that change nothing, states, instances, logging and memory."""

from __future__ import annotations

import ctypes
import math
import threading
from ctypes import byref, c_char_p, c_double, c_size_t, c_uint, c_void_p
from typing import Any

import numpy as np
import pytest

from fmus.interface import BLOCKS, load
from tests import dates

from .driver import ERROR, GUID, Callbacks, Instance, Refused, library, references


def running(block: str, **changes: Any) -> Instance:
    it = Instance(block)
    for name, value in changes.items():
        it.set(name, value)
    it.initialize()
    return it


def saved(it: Instance) -> c_void_p:
    state = c_void_p()
    it.call("GetFMUstate", byref(state))
    return state


def serialized(it: Instance, state: c_void_p) -> bytes:
    size = c_size_t()
    it.call("SerializedFMUstateSize", state, byref(size))
    data = ctypes.create_string_buffer(size.value)
    it.call("SerializeFMUstate", state, data, size.value)
    return data.raw


def same(a: dict[str, Any], b: dict[str, Any]) -> bool:
    return all(np.array_equal(a[name], b[name]) for name in a)


# ------------------------------------------------------------------------------------------- values


@pytest.mark.parametrize("block", BLOCKS)
def test_every_variable_starts_with_its_start_value(block: str) -> None:
    with Instance(block) as it:
        for v in it.interface.variables.values():
            if v.start is not None:
                start = v.items.index(v.start) + 1 if v.type == "enumeration" else v.start
                assert np.array_equal(it.get(v.name), start), v.name


@pytest.mark.parametrize("block", BLOCKS)
def test_each_input_and_parameter_keeps_what_was_set_and_disturbs_no_other(block: str) -> None:
    with Instance(block) as it:
        settable = [v for v in it.interface.variables.values() if v.causality != "output"]
        for chosen in settable:
            before = {v.name: it.get(v.name) for v in settable}
            it.set(chosen.name, _other(chosen, before[chosen.name]))
            after = {v.name: it.get(v.name) for v in settable}
            changed = [name for name in before if not np.array_equal(before[name], after[name])]
            assert changed == [chosen.name]
            assert np.array_equal(after[chosen.name], _other(chosen, before[chosen.name]))


def _other(v: Any, value: Any) -> Any:
    if v.type == "string":
        return "2011-12-13T14:15:16Z"
    if v.type == "boolean":
        return 1 - value
    if v.type in ("enumeration", "integer"):
        top = len(v.items) if v.type == "enumeration" else v.max
        return value - 1 if value == top else value + 1
    shift = 1e-3 * (1.0 + np.abs(value)) * (1.0 + np.arange(np.size(value)).reshape(np.shape(value)))
    low, high = (-math.inf if v.min is None else v.min), (math.inf if v.max is None else v.max)
    moved = np.where(value + shift > high, value - shift, value + shift)
    return np.clip(moved, low, high)


def test_starts_of_inputs_are_usable() -> None:
    for block in BLOCKS:
        with running(block) as it:
            for i in range(3):
                it.step(0.1 * i, 0.1)
            assert all(np.isfinite(value).all() for value in it.outputs().values())


@pytest.mark.parametrize(
    ("block", "name", "value", "message"),
    [
        ("allocator", "hold_fraction", 1.5, r"hold_fraction: expected 1e-06 to 1, found 1.5"),
        ("allocator", "hold_fraction", math.nan, r"hold_fraction: expected 1e-06 to 1, found NaN"),
        ("allocator", "dipole_max", 0.0, r"dipole_max: expected a finite number, at least 1e-09, found 0"),
        ("allocator", "dipole_max", math.inf, r"dipole_max: expected a finite number, at least 1e-09, found infinity"),
        ("controller", "omega_B", [0.0, -math.inf, 0.0], r"omega_B\[2\]: expected a finite number, found -infinity"),
        ("controller", "reference", 4, r"reference: expected 1 to 3, found 4"),
        ("controller", "gravitational_parameter", 3.98e5, r"expected 1e\+14 to 1e\+15, found 398000"),
        ("plant", "orbit_radius", 6.4e6, r"orbit_radius: expected 6478137 to 50000000, found 6400000"),
        ("plant", "inclination", -0.125, r"inclination: expected 0 to 3.14159265, found -0.125"),
        ("plant", "epoch", "a" * 128, r"epoch has at most 127 bytes"),
    ],
)
def test_a_value_out_of_range_is_refused_by_name_value_and_range(
    block: str, name: str, value: Any, message: str
) -> None:
    with Instance(block) as it:
        before = it.get(name)
        with pytest.raises(Refused, match=f"^{ERROR}: fmi2Set.*{message}"):
            it.set(name, value)
        assert np.array_equal(it.get(name), before)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"J_B": np.diag([1.0, 1.0, 2.5])}, r"J_B: expected the inertia of a body"),
        ({"J_error_B": np.diag([-3.0, 0.0, 0.0])}, r"J_B \+ J_error_B: expected a positive definite matrix"),
        ({"rod_axes": np.eye(3) * 0.5}, r"rod_axes: expected rows of unit length, to 1e-06, found 0.5"),
        ({"h_w0": 0.031}, r"h_w0: expected within wheel_momentum_max, found 0.031"),
        ({"integrator_order": 3}, r"integrator_order: expected 2, 4 or 6, found 3"),
        (
            {"Q0": np.diag([1.0, 1.0, -1.0])},
            r"Q0: expected a rotation matrix, determinant \+1 \(this is a reflection\)",
        ),
        ({"q_NB0": [0.9, 0.0, 0.0, 0.0], "initial_attitude": "q_NB0"}, r"q_NB0: expected a quaternion of unit length"),
        ({"epoch": "10 August 2009"}, r"epoch: expected UTC in ISO 8601.*found '10 August 2009'"),
        ({"epoch": "50%s"}, r"epoch: .*found '50%%s'"),  # doubled: FMI's message is a format
        ({"epoch": "2009-02-29T00:00:00Z"}, r"epoch: expected UTC"),
        ({"epoch": "2009-08-10T00:00:00+02:00"}, r"epoch: expected UTC"),
        (
            {"field_model": "wmm2025"},
            r"epoch: expected a date that wmm2025 covers, 2025.0 to 2030.0, or field_extrapolate, found 2009.6",
        ),
        (
            {"orbit_start": "position_velocity", "r_N0": [6.475e6, 0.0, 0.0], "v_N0": [0.0, -1092.0, 7770.0]},
            r"r_N0, v_N0: expected a perigee of at least",
        ),
        ({"orbit_radius": 9e6}, r"orbit_radius: expected heights of 150 km to 2000 km"),
        ({"orbit_start": "position_velocity", "v_N0": [1.0, 0.0, 0.0]}, r"v_N0: expected below escape speed"),
        ({"orbit_start": "position_velocity", "v_N0": [0.0, 0.0, 12e3]}, r"v_N0: expected below escape speed"),
        ({"center_of_mass_B": [0.0, 0.33, 0.0]}, r"center_of_mass_B\[2\]: expected inside the body"),
    ],
)
def test_a_plant_that_cannot_be_is_refused_when_initialization_ends(changes: dict[str, Any], message: str) -> None:
    with Instance("plant") as it:
        for name, value in changes.items():
            it.set(name, value)
        it.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        it.call("EnterInitializationMode")
        with pytest.raises(Refused, match=f"^{ERROR}: fmi2ExitInitializationMode: {message}"):
            it.call("ExitInitializationMode")
        for name in changes:  # what was refused can be mended, and initialization goes on
            v = it.interface.variables[name]
            it.set(name, v.start)
        it.call("ExitInitializationMode")


# ------------------------------------------------------------------------------------------- order of calls


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
    """Runs that end within a variable, that run backwards, repeat and jump; a value that is not finite ends none quietly."""
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


# ------------------------------------------------------------------------------------------- state


@pytest.mark.parametrize("block", BLOCKS)
def test_a_run_restored_at_half_time_ends_in_the_same_bits(block: str) -> None:
    rng = np.random.default_rng(1)
    inputs = [
        {
            v.name: np.asarray(v.start) + 1e-5 * rng.normal(size=v.shape) if v.type == "real" else v.start
            for v in load(block).of("input")
        }
        for _ in range(20)
    ]

    def go(it: Instance, first: int) -> dict[str, Any]:
        for i in range(first, 20):
            for name, value in inputs[i].items():
                it.set(name, value)
            it.step(0.1 * i, 0.1)
        return it.outputs()

    with running(block) as it, Instance(block) as fresh:
        for i in range(10):
            for name, value in inputs[i].items():
                it.set(name, value)
            it.step(0.1 * i, 0.1)
        state = saved(it)
        data = serialized(it, state)
        end = go(it, 10)
        it.call("SetFMUstate", state)
        assert same(go(it, 10), end)
        read = c_void_p()
        fresh.call("DeSerializeFMUstate", data, len(data), byref(read))
        fresh.call("SetFMUstate", read)
        assert same(go(fresh, 10), end)
        fresh.call("FreeFMUstate", byref(read))
        it.call("FreeFMUstate", byref(state))
        assert not state.value
        it.call("FreeFMUstate", byref(state))
        assert len(it.memory) == len(fresh.memory) == 1  # the instance itself


def test_bytes_that_are_no_state_of_this_fmu_are_refused() -> None:
    with running("controller") as it, running("allocator") as other:
        state, foreign = saved(it), saved(other)
        data = serialized(it, state)
        read = c_void_p()
        spoilt = bytes([*data[:-1], data[-1] ^ 1]), data[:-1], b"", serialized(other, foreign), bytes(len(data))
        for wrong in spoilt:
            with pytest.raises(Refused, match="expected the unchanged bytes"):
                it.call("DeSerializeFMUstate", wrong, len(wrong), byref(read))
        for call in ("SetFMUstate", "FreeFMUstate"):
            with pytest.raises(Refused, match="expected a state that fmi2GetFMUstate of this FMU gave"):
                it.call(call, byref(foreign) if call == "FreeFMUstate" else foreign)
        it.call("FreeFMUstate", byref(state))
        other.call("FreeFMUstate", byref(foreign))


def test_reset_clears_the_hold_and_the_latches() -> None:
    with running("allocator", tau_cmd_B=[1e-4, 2e-4, 0.0]) as it, running("allocator") as fresh:
        it.step(0.0, 0.1)
        it.set("tau_cmd_B", [1.0, 0.0, 0.0])
        it.step(0.1, 0.1)
        assert it.get("holding")
        assert np.abs(it.get("dipole_cmd")).max() > 0.0
        it.call("Reset")
        it.initialize()
        assert same(it.outputs(), fresh.outputs())


# ------------------------------------------------------------------------------------------- instances


def test_instances_share_nothing_and_run_in_threads_of_their_own() -> None:
    alone = running("plant", omega_B0=[0.04, -0.0789, 0.04])
    for i in range(300):
        alone.step(0.1 * i, 0.1)
    expected = alone.outputs()
    instances = [running("plant", omega_B0=[0.04, -0.0789, 0.04]) for _ in range(8)]
    disturbing = [running("plant", omega_B0=[0.01 * k, 0.0, 0.1], integrator_order=4) for k in range(8)]

    def run(it: Instance) -> None:
        for i in range(300):
            it.step(0.1 * i, 0.1)

    threads = [threading.Thread(target=run, args=(it,)) for it in [*instances, *disturbing]]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(same(it.outputs(), expected) for it in instances)
    for it in [alone, *instances, *disturbing]:
        it.free()
        assert not it.memory


def test_a_wrong_guid_type_or_name_gives_no_instance_but_a_message() -> None:
    other = Instance("controller", guid="{other}")
    assert other.handle is None
    assert not other.memory
    assert GUID in other.messages[0][2]
    assert "{other}" in other.messages[0][2]
    assert Instance("controller", name="").handle is None
    lib = library("controller")
    callbacks = Callbacks()
    assert lib.fmi2Instantiate(b"it", 1, GUID.encode(), None, byref(callbacks), 0, 0) is None
    assert lib.fmi2Instantiate(b"it", 1, GUID.encode(), None, None, 0, 0) is None


def test_no_memory_is_asked_for_after_instantiation_but_for_saved_states() -> None:
    with Instance("plant") as it:
        assert len(it.memory) == 1
        it.initialize()
        for i in range(50):
            it.step(0.1 * i, 0.1)
        it.call("Reset")
        assert len(it.memory) == 1
    assert not it.memory


def test_a_null_component_gives_an_error_and_no_crash() -> None:
    lib = library("allocator")
    assert lib.fmi2DoStep(None, 0.0, 0.1, 1) == ERROR
    assert lib.fmi2Reset(None) == ERROR
    assert lib.fmi2GetReal(None, (c_uint * 1)(0), 1, (c_double * 1)()) == ERROR
    lib.fmi2FreeInstance(None)


# ------------------------------------------------------------------------------------------- logging


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


# ------------------------------------------------------------------------------------------- dates


@pytest.mark.parametrize("block", ["plant", "controller_planned"])
def test_both_blocks_with_an_epoch_read_the_same_dates_and_refuse_the_same_texts(block: str) -> None:
    with Instance(block) as it:
        it.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        it.call("EnterInitializationMode")
        for text in dates.REFUSED:
            it.set("epoch", text)
            with pytest.raises(Refused, match="epoch: expected UTC in ISO 8601, such as 2009-08-10T12:00:00Z, found '"):
                it.call("ExitInitializationMode")
    for text in dates.READ:
        with Instance(block) as it:
            it.set("epoch", text)
            it.set("field_model", "igrf14")
            it.initialize()
