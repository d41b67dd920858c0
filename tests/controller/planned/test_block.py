"""The block as a host sees it: samples, memory and saved states."""

import contextlib
from ctypes import byref, c_void_p

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.native.driver import Refused, saved, serialized

from .block import KNOWN, alike, at_target, feed, near_target, run, same, started, tumbling


@pytest.mark.parametrize("inputs", [near_target, tumbling])
def test_samples_are_independent_of_the_communication_step(inputs):
    runs = {}
    for h in (0.1, 0.25, 0.5):
        with started(inputs, **KNOWN) as it:
            runs[h] = run(it, 0.0, 25.0, h, inputs)[round(0.5 / h) - 1 :: round(0.5 / h)]
    assert len({len(r) for r in runs.values()}) == 1
    for a, b, c in zip(*runs.values(), strict=True):
        assert alike(a, c, 1e-6)
        assert alike(b, c, 1e-6)


def test_samples_keep_their_grid_where_steps_do_not_divide_it():
    """Steps of 0.2 s: a sample is the first step at or beyond each half second."""
    with started() as it:
        times, before = [], it.outputs()
        for i in range(20):
            feed(it, near_target(0.2 * (i + 1)))
            it.step(0.2 * i, 0.2)
            now = it.outputs()
            times += [] if same(now, before) else [round(0.2 * (i + 1), 1)]
            before = now
    assert times == [0.6, 1.0, 1.6, 2.0, 2.6, 3.0, 3.6, 4.0]


def test_between_samples_all_outputs_are_held():
    with started() as it:
        after = run(it, 0.0, 3.0, 0.1)
        for i in range(0, 25, 5):  # 0.5 s is the fifth
            sample = after[i + 4]
            assert all(same(sample, held) for held in after[i + 5 : i + 9])
            assert not same(sample, after[i + 9])
        feed(it, {"omega_B": [0.1, 0.0, 0.0]})
        it.step(3.0, 0.1)
        held = it.outputs()
        feed(it, {"omega_B": [0.2, 0.0, 0.0]})
        assert same(it.outputs(), held)


def test_samples_stay_in_time_over_hundreds_of_thousands_of_steps():
    """Sums of a tenth drift by far more than what a sample may be early; the samples must not drift with them."""
    with started(control_period=0.5, plan_period=1000.0) as it:
        feed(it, near_target(0.0))
        late = 0
        for i in range(200_000):
            it.step(0.1 * i, 0.1)
            if i % 1000 == 3:  # the step before a sample, and the sample
                before = it.get("tau_cmd_B")
                feed(it, {"omega_B": [1e-4 * (i // 1000 % 7), -1e-3, 0.0]})
                late += not np.array_equal(it.get("tau_cmd_B"), before)
            if i % 1000 == 4:
                now = it.get("tau_cmd_B")
                late += np.array_equal(now, before)
    assert late == 0


def test_a_step_of_any_length_takes_bounded_time():
    with started() as it:
        feed(it, near_target(0.0))
        for t, h in ((0.0, 3.0), (3.0, 1e4), (10003.0, 0.5)):
            it.step(t, h)
            assert all(np.isfinite(v).all() for v in it.outputs().values())
    with started() as it, contextlib.suppress(Refused):  # to the end of time: refused or not, but at once
        it.step(0.0, 1e300)


# ------------------------------------------------------------------------------------------- memory


@pytest.mark.parametrize("inputs", [at_target, tumbling])
def test_get_after_set_evaluates_the_law_anew_and_leaves_no_trace(inputs):
    with started(inputs) as it, started(inputs) as twin:
        for i in range(40):
            for each in (it, twin):
                feed(each, inputs(0.5 * (i + 1)))
                each.step(0.5 * i, 0.5)
            first = it.outputs()
            feed(
                it,
                {"omega_B": [0.01, 0.02, -0.03], "R_NB": Rotation.from_rotvec([0.3, 1, 0.1]).as_matrix(), "h_w": 0.02},
            )
            other = it.outputs()
            assert not np.array_equal(other["tau_cmd_B"], first["tau_cmd_B"])
            assert not np.array_equal(other["attitude_error"], first["attitude_error"])
            feed(it, inputs(0.5 * (i + 1)))
            assert same(it.outputs(), first)
            assert same(twin.outputs(), first)


def test_a_state_saved_after_a_plan_goes_on_in_the_same_bits():
    with started() as it, started(tumbling) as other:
        run(it, 0.0, 45.0)
        state = saved(it)
        data = serialized(it, state)
        end = run(it, 45.0, 100.0)
        assert end[0]["phase"] == 2
        bytes_at_end = serialized(it, saved(it))
        it.call("SetFMUstate", state)
        assert all(map(same, run(it, 45.0, 100.0), end))
        run(other, 0.0, 7.0, inputs=tumbling)  # a life of its own before
        read = c_void_p()
        other.call("DeSerializeFMUstate", data, len(data), byref(read))
        other.call("SetFMUstate", read)
        assert all(map(same, run(other, 45.0, 100.0), end))
        assert serialized(other, saved(other)) == bytes_at_end


def test_a_states_bytes_depend_on_its_own_history_only():
    """Nothing of what the instance did before, and no memory that was never written, is in it."""

    def quick(t):
        """A light body that turns fast: its plans have more stages."""
        return {**near_target(t), "omega_B": [0.036, -0.022, 0.011]}

    with started() as fresh, started(quick, J_B=np.diag([0.4, 0.5, 0.55])) as again:
        assert run(again, 0.0, 12.0, inputs=quick)[-1]["phase"] == 2
        again.call("Reset")
        feed(again, near_target(0.0))
        again.initialize()
        assert serialized(fresh, saved(fresh)) == serialized(again, saved(again))
        for t in (0.0, 30.0):
            assert all(map(same, run(fresh, t, t + 30.0), run(again, t, t + 30.0)))
            assert serialized(fresh, saved(fresh)) == serialized(again, saved(again))


def test_instances_side_by_side_do_as_each_alone():
    with started() as a:
        alone_a = run(a, 0.0, 12.0)
    with started(tumbling) as b:
        alone_b = run(b, 0.0, 12.0, inputs=tumbling)
    with started() as a, started(tumbling) as b:
        for i in range(24):
            (now_a,) = run(a, 0.5 * i, 0.5 * (i + 1))
            (now_b,) = run(b, 0.5 * i, 0.5 * (i + 1), inputs=tumbling)
            assert same(now_a, alone_a[i])
            assert same(now_b, alone_b[i])
