"""The engine on blocks of pure Python."""

from __future__ import annotations

import os
import signal
import threading
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from orchestration.errors import InputError
from orchestration.fmu.model import Element
from orchestration.quantities import Unit

from ..mocks import Mock, law, model, ramp, real, run

CHAIN = ["plant.y -> first.u", "first.y -> second.u", "second.y -> plant.u"]


def chain(**scenario):
    """The plant's time goes through two laws and back to the plant: how old is what comes back?"""
    blocks = [ramp("plant"), law("first"), law("second")]
    result = run(blocks, {"step": 0.1, "duration": 2.0, "connections": CHAIN, **scenario})
    return result, blocks


def test_sequential_exchange_has_no_hidden_delay():
    result, _ = chain()
    np.testing.assert_array_equal(result["first.y"], result.time)
    np.testing.assert_array_equal(result["second.y"], result.time)
    # The plant holds over [t, t + h] the command that the laws gave at t.
    np.testing.assert_allclose(result["plant.seen"][1:], result.time[:-1], atol=1e-12)


def test_parallel_exchange_delays_every_connection_by_a_step():
    result, _ = chain(exchange="parallel")
    age = lambda name: np.round((result.time - result[name])[5:] / 0.1, 6)  # noqa: E731
    np.testing.assert_array_equal(age("first.y"), 1)
    np.testing.assert_array_equal(age("second.y"), 2)
    np.testing.assert_array_equal(age("plant.seen"), 3)  # instead of 1


def test_the_order_of_blocks_in_the_scenario_does_not_matter_where_feedthrough_decides():
    forward = run([ramp("plant"), law("first"), law("second")], {"step": 0.1, "duration": 1.0, "connections": CHAIN})
    backward = run([law("second"), law("first"), ramp("plant")], {"step": 0.1, "duration": 1.0, "connections": CHAIN})
    for name in forward:
        np.testing.assert_array_equal(forward[name], backward[name])


def test_an_output_that_is_only_looked_at_is_that_of_its_instant_too():
    """It feeds nothing, stands first in the scenario, and depends directly on a block behind it."""
    for blocks in ([law("first"), ramp("plant")], [law("second"), law("first"), ramp("plant")]):
        wires = [*(["first.y -> second.u"] if len(blocks) > 2 else []), "plant.y -> first.u"]
        result = run(blocks, {"step": 0.1, "duration": 1.0, "connections": wires}, start={"plant": {"u": 0}})
        np.testing.assert_array_equal(result["first.y"], result.time)


def test_blocks_step_in_the_order_of_the_scenario_as_far_as_what_feeds_them_allows():
    """One that waits for nothing does not overtake one that waited and may step."""
    stepped: list[str] = []
    blocks = [law("late"), ramp("plant"), law("fed"), ramp("free"), law("end")]
    for block in blocks:
        block.advance = lambda b, t, h: stepped.append(b.name)
    wires = ["plant.y -> fed.u", "fed.y -> late.u", "free.y -> end.u"]
    run(blocks, {"step": 0.1, "duration": 0.1, "connections": wires}, start={"plant": {"u": 0}, "free": {"u": 0}})
    assert stepped == ["plant", "fed", "late", "free", "end"]


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
def test_get_is_never_called_between_set_and_do_step(exchange):
    _, blocks = chain(exchange=exchange)
    for block in blocks:
        calls = [call[0] for call in block.calls]
        for here, after in pairwise(calls):
            if here == "set_inputs":
                assert after == "do_step"


def test_do_step_is_told_times_that_are_whole_multiples_of_the_step_without_drift():
    block = ramp("plant")
    block.evaluate, block.advance = lambda b: None, lambda b, t, h: None
    run([block], {"step": 0.1, "duration": 1000.0, "record": {"interval": 100.0}}, start={"plant": {"u": 0}})
    steps = [call[1:] for call in block.calls if call[0] == "do_step"]
    assert len(steps) == 10_000
    assert steps == [(n / 10, 0.1) for n in range(10_000)]


def test_a_million_steps_do_not_drift():
    from orchestration.system.clock import Clock

    clock = Clock(1, 10, 1_000_000, 1)
    summed = float(np.add.accumulate(np.full(1_000_000, 0.1))[-1])
    assert clock.time(1_000_000) == 100_000.0 != summed
    np.testing.assert_array_equal(clock.sample_times(), np.arange(1_000_001) / 10)


def test_times_that_no_double_counts_exactly_are_rounded_once():
    result, _ = chain(step=1 / 3, duration=2.0)
    np.testing.assert_allclose(result.time, np.arange(7) / 3, rtol=1e-15)


def test_a_duration_that_is_no_multiple_of_the_step_runs_to_the_next_step_and_says_so():
    result, _ = chain(duration=0.25)
    assert result.time[-1] == 0.3
    assert result.warnings == ["0.25 s is no multiple of the step, 0.1 s; the run ends at 0.3 s"]


def test_a_duration_that_is_counted_in_cycles_runs_to_the_next_step_without_a_word():
    result = run(
        [ramp("plant")],
        {"step": 0.1, "duration": "2 turns", "cycle": {"name": "turns", "period": 0.123}},
        start={"plant": {"u": 0}},
    )
    assert result.time[-1] == 0.3
    assert result.warnings == []


def test_a_block_at_a_multiple_of_the_base_step_is_stepped_over_all_of_it_when_it_has_passed():
    blocks = [ramp("plant"), law("first"), law("second")]
    result = run(blocks, {"step": 0.1, "duration": 2.0, "connections": CHAIN}, every={"first": 5})
    assert [call[1:] for call in blocks[1].calls if call[0] == "do_step"] == [
        (0.0, 0.5),
        (0.5, 0.5),
        (1.0, 0.5),
        (1.5, 0.5),
    ]
    expected = np.floor(np.arange(21) / 5) * 0.5  # sampled and held
    np.testing.assert_allclose(result["first.y"], expected, atol=1e-12)
    np.testing.assert_allclose(result["second.y"], expected, atol=1e-12)


def test_steps_left_over_after_the_last_multiple_of_every_are_not_made():
    """In the Python loop, since the blocks are mocks: 1.0 s is 10 base steps, of which two times 4 are made."""
    blocks = [ramp("plant"), law("first"), law("second")]
    result = run(blocks, {"step": 0.1, "duration": 1.0, "connections": CHAIN}, every={"first": 4})
    assert [call[1:] for call in blocks[1].calls if call[0] == "do_step"] == [(0.0, 0.4), (0.4, 0.4)]
    np.testing.assert_allclose(result["first.y"][8:], 0.8, atol=1e-12)


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
def test_a_longer_recording_interval_takes_every_so_manyth_sample_and_changes_nothing_else(exchange):
    fine, _ = chain(exchange=exchange)
    coarse, _ = chain(exchange=exchange, record={"interval": 0.5})
    np.testing.assert_array_equal(coarse.time, [0.0, 0.5, 1.0, 1.5, 2.0])
    for name in fine:
        np.testing.assert_array_equal(coarse[name], fine[name][::5])


def test_what_only_is_recorded_is_fetched_only_when_it_is_recorded():
    _, (plant, *_) = chain(record={"interval": 0.5})
    assert [c[0] for c in plant.calls].count("get_all") == 1 + 4
    assert [c[0] for c in plant.calls].count("get_live") == 16


def test_initialization_takes_outputs_to_inputs_in_the_order_of_their_dependence():
    plant = ramp("plant")
    plant.state = 3.0
    seen: list[float] = []
    plant.leave = lambda: seen.append(plant["u"])
    blocks = [law("second", lambda u: u + 1), law("first", lambda u: 2 * u), plant]
    result = run(blocks, {"step": 0.1, "duration": 0.1, "connections": CHAIN})
    assert (result["first.y"][0], result["second.y"][0]) == (6.0, 7.0)
    assert seen == [7.0], "the command that follows from its own initial state is there when initialization is left"


def test_start_values_are_set_before_initialization():
    block = law("law")
    run([block], {"step": 0.1, "duration": 0.1}, start={"law": {"u": 4.5}})
    assert [c[0] for c in block.calls][:3] == ["set", "enter", "leave"]
    assert block["y"] == 4.5


def test_compatible_units_are_converted_by_factor_and_offset():
    angle, rate = (0, 0, 0, 0, 0, 0, 0, 1), (0, 0, 0, 0, 1, 0, 0, 0)
    degrees, radians = Unit("deg", angle, np.pi / 180), Unit("rad", angle)
    celsius, kelvin = Unit("degC", rate, 1.0, 273.15), Unit("K", rate)

    def evaluate(block):
        block["angle"], block["temperature"] = 180.0, 20.0

    source = Mock(
        "a", model("a", real("angle", "output", unit=degrees), real("temperature", "output", unit=celsius)), evaluate
    )
    inputs = real("angle", "input", unit=radians), real("temperature", "input", unit=kelvin)
    sink = Mock("b", model("b", *inputs), lambda block: None)
    connections = ["a.angle -> b.angle", "a.temperature -> b.temperature"]
    signals = ["b.angle", "b.temperature"]
    result = run([source, sink], {"step": 1, "duration": 2, "connections": connections, "record": {"signals": signals}})
    np.testing.assert_allclose(result["b.angle"], np.pi, rtol=1e-15)
    np.testing.assert_allclose(result["b.temperature"], 293.15, rtol=1e-15)


def test_whole_matrices_and_single_elements_are_connected():
    def evaluate(block):
        for i, element in enumerate(block.model.variables["R"].elements):
            block.values[element] = 10.0 + i

    source = Mock("a", model("a", real("R", "output", shape=(2, 3))), evaluate)
    sink = Mock(
        "b", model("b", real("R", "input", shape=(2, 3)), real("x", "input"), real("z", "input")), lambda b: None
    )
    connections = ["a.R -> b.R", "a.R[2,3] -> b.x", "a.R[1][2] -> b.z"]
    result = run(
        [source, sink],
        {"step": 1, "duration": 1, "connections": connections, "record": {"signals": ["b.R", "b.x", "b.z"]}},
    )
    np.testing.assert_array_equal(result["b.R"][-1], [[10, 11, 12], [13, 14, 15]])
    assert (result["b.x"][-1], result["b.z"][-1]) == (15.0, 11.0)
    assert result["b.R[2,1]"][-1] == result["b.R[2][1]"][-1] == 13.0


def test_a_delay_breaks_an_algebraic_loop_and_gives_the_value_of_the_step_before():
    blocks = [law("a", lambda u: u + 1), law("b", lambda u: u)]
    loop = {"step": 1, "duration": 5, "connections": ["a.y -> b.u", "b.y -> a.u"]}
    with pytest.raises(
        InputError, match=r"algebraic loop through a\.y -> b\.y -> a\.y; 'delays: \[a\.u\]' would break it"
    ):
        run(blocks, loop)
    blocks = [law("a", lambda u: u + 1), law("b", lambda u: u)]
    result = run(blocks, {**loop, "delays": ["a.u"]}, start={"a": {"u": 10}})
    np.testing.assert_array_equal(result["b.y"], [11, 12, 13, 14, 15, 16])


def test_an_fmu_that_declares_no_dependencies_closes_no_loop_but_is_warned_of():
    kind = model("law", real("u", "input"), real("y", "output"), feedthrough={"y": None})
    silent = law("a")
    silent.model = kind
    blocks = [silent, ramp("plant")]
    other = law("b")
    other.model = kind
    result = run([silent, other], {"step": 1, "duration": 2, "connections": ["a.y -> b.u", "b.y -> a.u"]})
    assert any("does not say on which inputs" in w for w in result.warnings)
    # With what its interface says of it, the order is right and nothing is to be warned of.
    hook = lambda block, element: frozenset({Element("u", 0)})  # noqa: E731
    fresh = law("a")
    fresh.model = kind
    result = run(
        [fresh, blocks[1]],
        {"step": 1, "duration": 2, "connections": ["a.y -> plant.u", "plant.y -> a.u"]},
        feedthrough=hook,
    )
    assert result.warnings == []
    np.testing.assert_array_equal(result["a.y"], result.time)


def test_a_diagnostic_that_feeds_nobody_is_of_the_instant_of_what_it_depends_on():
    """A block of diagnostics stands first in the scenario; nothing but the record asks for what it gives."""
    for blocks in ([law("diagnostic"), ramp("plant")], [ramp("plant"), law("diagnostic")]):
        scenario = {"step": 0.1, "duration": 1.0, "connections": ["plant.y -> diagnostic.u"]}
        result = run(blocks, scenario, start={"plant": {"u": 0}})
        np.testing.assert_array_equal(result["diagnostic.y"], result["plant.y"])


def test_blocks_are_stepped_by_what_outputs_depend_on_in_a_step_and_not_in_initialization():
    """What a block declares for steps and for initialization differs: first the one is empty, then the other."""
    blocks = [law("second"), law("first"), ramp("plant")]
    for block in blocks:
        block.model = replace(block.model, initial={element: frozenset() for element in block.model.initial})
    result = run(blocks, {"step": 0.1, "duration": 1.0, "connections": CHAIN})
    for name in ("first.y", "second.y"):
        np.testing.assert_array_equal(result[name][1:], result.time[1:])
    blocks = [law("first"), ramp("plant")]
    blocks[0].model = replace(
        blocks[0].model, feedthrough={element: frozenset() for element in blocks[0].model.initial}
    )
    result = run(blocks, {"step": 0.1, "duration": 1.0, "connections": ["plant.y -> first.u", "first.y -> plant.u"]})
    np.testing.assert_array_equal(result["first.y"][1:], result.time[:-1])


def test_a_plant_with_a_diagnostic_that_feeds_through_still_comes_first():
    """`seen` depends directly on the command; nobody is fed by it, so it decides nothing."""
    plant = ramp("plant")
    variables = plant.model.variables.values()
    plant.model = model("ramp", *variables, feedthrough={"seen": ["u"]})
    result = run([law("second"), plant, law("first")], {"step": 0.1, "duration": 1.0, "connections": CHAIN})
    np.testing.assert_array_equal(result["second.y"], result.time)


def test_what_comes_one_step_late_between_blocks_that_need_each_other_is_named():
    """No output depends on itself: torque, given, gain follow one another, but two are of one block."""
    outputs = [real(name, "output") for name in ("torque", "gain")]
    one = Mock("law", model("law", real("told", "input"), *outputs, feedthrough={"gain": ["told"]}), lambda block: None)
    inputs = [real(name, "input") for name in ("asked", "scale")]
    other = model("limits", real("given", "output"), *inputs, feedthrough={"given": ["asked"]})
    wires = ["law.torque -> limits.asked", "limits.given -> law.told", "law.gain -> limits.scale"]
    blocks = [one, Mock("limits", other, lambda block: None)]
    result = run(blocks, {"step": 0.1, "duration": 0.2, "connections": wires})
    assert result.warnings == [
        "law depends directly on limits, which is stepped after it: limits.given comes one step late"
    ]


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_an_output_that_is_not_finite_ends_the_run_and_is_named(value, exchange):
    def advance(block, time, step):
        block.state = value if time > 0.45 else round(time + step, 9)

    plant = ramp("plant")
    plant.advance = advance
    scenario = {"step": 0.1, "duration": 2.0, "connections": CHAIN, "exchange": exchange}
    result = run([plant, law("first"), law("second")], scenario)
    assert str(result.failure) == f"plant: output y at 0.6 s: is {value}, expected a finite number"
    np.testing.assert_array_equal(result.time, np.arange(6) / 10)
    np.testing.assert_array_equal(result["plant.y"], result.time)


def test_a_very_large_output_is_no_infinity():
    plant = ramp("plant")
    plant.advance = lambda block, time, step: setattr(block, "state", 1e200)
    assert run([plant], {"step": 1, "duration": 2}, start={"plant": {"u": 0}}).failure is None


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
def test_a_failing_block_ends_the_run_with_block_time_call_status_and_log(exchange):
    def advance(block, time, step):
        if time > 0.95:
            raise block.fail("fmi2DoStep", "discard")
        block.state = round(time + step, 9)

    plant = ramp("plant")
    plant.advance = advance
    result = run(
        [plant, law("first"), law("second")], {"step": 0.1, "duration": 2.0, "connections": CHAIN, "exchange": exchange}
    )
    assert str(result.failure) == "plant: fmi2DoStep at 1 s: gave status discard\n  plant logged: this is why"
    assert len(result.time) == len(result["first.y"]) == 11
    assert not result.passed


def test_a_failure_in_initialization_leaves_an_empty_result():
    block = law("law")

    def leave():
        raise block.fail("fmi2ExitInitializationMode")

    block.leave = leave
    result = run([block], {"step": 1, "duration": 2}, start={"law": {"u": 0}})
    assert "law: fmi2ExitInitializationMode in initialization: gave status error" in str(result.failure)
    assert len(result.time) == 0


@pytest.mark.skipif(os.name == "nt", reason="signals differ")
def test_ctrl_c_ends_the_run_between_two_steps_and_keeps_what_was_computed():
    assert threading.current_thread() is threading.main_thread()

    def advance(block, time, step):
        block.state = round(time + step, 9)
        if abs(time - 0.5) < 1e-9:
            os.kill(os.getpid(), signal.SIGINT)

    plant = ramp("plant")
    plant.advance = advance
    result = run([plant, law("first"), law("second")], {"step": 0.1, "duration": 2.0, "connections": CHAIN})
    assert result.interrupted == signal.SIGINT
    assert not result.passed
    np.testing.assert_array_equal(result["second.y"], np.arange(7) / 10)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_booleans_and_whole_numbers_come_back_as_such():
    variables = real("on", "output", type="boolean"), real("count", "output", type="integer"), real("x", "output")

    def evaluate(block):
        block["on"], block["count"], block["x"] = block.state > 1, block.state, 0.5

    def advance(block, time, step):
        block.state += 1

    result = run([Mock("a", model("a", *variables), evaluate, advance, 0)], {"step": 1, "duration": 3})
    assert result["a.on"].tolist() == [False, False, True, True]
    assert result["a.count"].dtype == np.int64
    assert result["a.count"].tolist() == [0, 1, 2, 3]
    assert list(result) == ["a.on", "a.count", "a.x"]


def test_progress_is_told_the_simulated_time(monkeypatch):
    monkeypatch.setattr("orchestration.master.master._REPORT_EVERY", -1.0)
    times: list[float] = []
    run([ramp("plant")], {"step": 0.1, "duration": 0.5}, start={"plant": {"u": 0}}, progress=times.append)
    assert times == [0.1, 0.2, 0.3, 0.4, 0.5]


def test_an_unknown_name_is_refused_by_the_result_with_the_nearest_one():
    result, _ = chain()
    with pytest.raises(KeyError, match=r"did you mean 'plant\.seen'"):
        result["plant.sen"]
