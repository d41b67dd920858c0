"""The FMI shell's instances and their states: saved and restored, reset, side by side, and their memory."""

from __future__ import annotations

import threading
from ctypes import byref, c_double, c_uint, c_void_p
from typing import Any

import numpy as np
import pytest

from fmus.interface import BLOCKS, load

from .driver import ERROR, GUID, Callbacks, Instance, Refused, library, running, same, saved, serialized


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
