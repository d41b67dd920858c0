"""Faults: what the receivers of a signal see, when, and what else stays as it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestration import BlockError, InputError
from orchestration import run as run_scenario
from orchestration.fmu.model import Element, Variable
from orchestration.quantities import parse_unit
from orchestration.session.read import load, read

from ..mocks import Mock, law, model, ramp, real, run

SCENARIOS = Path(__file__).parents[3] / "scenarios"


def chain(*faults, **options):
    """A ramp y = t whose value a law takes over, which the ramp is given back; 20 steps of 0.1 s."""
    blocks = [ramp("plant"), law("law")]
    scenario = {
        "step": 0.1,
        "duration": 2,
        "connections": ["plant.y -> law.u", "law.y -> plant.u"],
        "faults": list(faults),
        **options.pop("scenario", {}),
    }
    return run(blocks, scenario, **options)


TIME = np.round(0.1 * np.arange(21), 9)


def test_a_cut_signal_is_zero_from_its_time_to_its_end_and_the_giver_stays_sound():
    result = chain({"at": 0.5, "until": 1.0, "cut": "plant.y"})
    np.testing.assert_allclose(result["plant.y"], TIME)
    cut = (TIME >= 0.5) & (TIME < 1.0)
    np.testing.assert_allclose(result["law.y"], np.where(cut, 0.0, TIME))


def test_a_cut_signal_may_be_given_another_value():
    result = chain({"at": 1.5, "cut": "law.u", "to": -3})
    np.testing.assert_allclose(result["law.y"], np.where(TIME >= 1.5, -3.0, TIME))


def test_a_frozen_signal_keeps_the_value_that_it_has_when_the_fault_begins():
    result = chain({"at": 0.5, "until": 1.0, "freeze": "plant.y"})
    frozen = (TIME >= 0.5) & (TIME < 1.0)
    np.testing.assert_allclose(result["law.y"], np.where(frozen, 0.5, TIME))


def test_a_bias_is_added():
    biased = (TIME >= 0.5) & (TIME < 1.0)
    result = chain({"at": 0.5, "until": 1.0, "bias": "plant.y", "by": 10})
    np.testing.assert_allclose(result["law.y"], TIME + 10.0 * biased)


def test_several_faults_of_a_signal_act_in_the_order_of_the_scenario():
    one = chain({"at": 1, "freeze": "plant.y"}, {"at": 1, "bias": "plant.y", "by": 5})
    assert one["law.y"][-1] == pytest.approx(6.0)
    two = chain({"at": 1, "bias": "plant.y", "by": 5}, {"at": 1, "freeze": "plant.y"}, {"at": 1.5, "cut": "law.u"})
    assert two["law.y"][[10, 14, 15]] == pytest.approx([6.0, 6.0, 0.0])


def test_what_comes_from_a_block_stepped_later_is_at_fault_from_the_step_after():
    """The command of 0.5 s, at fault, is the one that the plant holds over [0.5, 0.6]."""
    result = chain({"at": 0.5, "until": 0.7, "cut": "law.y", "to": 100})
    # `seen` is what was held over the step that ends at each time.
    np.testing.assert_allclose(result["plant.seen"][4:9], [0.3, 0.4, 100.0, 100.0, 0.7])


def test_in_parallel_exchange_too_it_is_the_time_of_the_value_that_counts():
    result = chain({"at": 0.5, "until": 0.7, "cut": "plant.y", "to": 100}, scenario={"exchange": "parallel"})
    np.testing.assert_allclose(result["law.y"][4:9], [0.3, 0.4, 100.0, 100.0, 0.7])


def test_a_slow_block_is_given_what_is_at_fault_when_it_is_stepped():
    result = chain({"at": 0.5, "until": 0.9, "cut": "plant.y", "to": 9}, every={"law": 4})
    assert result["law.y"][[0, 4, 8, 12, 16]] == pytest.approx([0.0, 0.4, 9.0, 1.2, 1.6])


def test_a_fault_at_the_start_acts_in_initialization():
    result = chain({"at": 0, "cut": "plant.y", "to": 7})
    np.testing.assert_allclose(result["law.y"], 7.0)
    biased = chain({"at": 0, "bias": "plant.y", "by": 1})
    np.testing.assert_allclose(biased["law.y"], TIME + 1.0)


@pytest.mark.parametrize(
    ("fault", "every", "told"),
    [
        ({"at": 0.5, "until": 0.7, "cut": "plant.y"}, 4, "law is given a value from 0.5 s to 0.7 s; it is "
                                                         "stepped each 0.4 s"),
        ({"at": 1.9, "cut": "plant.y"}, 4, "law is given a value from 1.9 s; it is stepped each 0.4 s"),
        ({"at": 2.0, "freeze": "law.y"}, 1, "plant is given a value from 2 s; it is stepped each 0.1 s"),
        ({"at": 2.0, "bias": "plant.u", "by": 1}, 1, "plant is given a value from 2 s; it is stepped each 0.1 s"),
    ],
)  # fmt: skip
def test_a_fault_of_a_signal_that_no_step_sees_is_refused(fault, every, told):
    """What the law gives at 2 s, the end, is a step behind for the plant; with `every` 4 the law's last step ends at 2
    s."""
    with pytest.raises(InputError) as info:
        chain(fault, every={"law": every}, scenario={"duration": 1.9 if every == 4 and fault["at"] > 1 else 2})
    assert f"faults[1].at: no step of {told}" in str(info.value)


@pytest.mark.parametrize(
    ("fault", "every"),
    [
        ({"at": 0.5, "until": 0.9, "cut": "plant.y", "to": 9}, 4),
        ({"at": 2.0, "cut": "plant.y", "to": 9}, 4),
        ({"at": 0.0, "until": 0.1, "cut": "plant.y", "to": 9}, 4),
    ],
)
def test_a_fault_of_a_signal_that_one_step_sees_acts(fault, every):
    assert 9.0 in chain(fault, every={"law": every})["law.y"]


def test_a_fault_of_an_input_is_that_of_one_receiver_alone():
    blocks = [ramp("plant"), law("one"), law("two")]
    connections = ["plant.y -> one.u", "plant.y -> two.u"]
    faults = [{"at": 0.5, "cut": "one.u"}]
    scenario = {"step": 0.1, "duration": 1, "connections": connections, "faults": faults}
    result = run(blocks, scenario, start={"plant": {"u": 0}})
    assert (result["one.y"][-1], result["two.y"][-1]) == (0.0, 1.0)


def test_elements_and_units_are_those_of_the_signal_that_is_named():
    rate, degrees = parse_unit("rad/s"), parse_unit("deg/s")

    def give(block):
        for i in range(3):
            block.values[Element("w", i)] = float(i + 1)

    def take(block):
        for i in range(3):
            block.values[Element("seen", i)] = block.values[Element("w", i)]

    giver = Mock("giver", model("giver", real("w", "output", shape=(3,), unit=rate)), give)
    ports = real("w", "input", shape=(3,), unit=degrees), real("seen", "output", shape=(3,), unit=degrees)
    taker = Mock("taker", model("taker", *ports, feedthrough={"seen": ["w"]}), take)
    faults = [
        {"at": 1, "until": 2, "bias": "giver.w", "by": ["180 deg/s", 0, 1]},
        {"at": 2, "until": 3, "bias": "taker.w[2]", "by": "1 rad/s"},
        {"at": 3, "until": 4, "cut": "giver.w", "to": [1, 2, "3 deg/s"]},
        {"at": 4, "cut": "giver.w[3]"},
    ]
    scenario = {"step": 1, "duration": 4, "connections": ["giver.w -> taker.w"], "faults": faults}
    seen = np.deg2rad(run([giver, taker], scenario)["taker.seen"])
    np.testing.assert_allclose(seen[1], [1 + np.pi, 2, 4])
    np.testing.assert_allclose(seen[2], [1, 3, 3])
    np.testing.assert_allclose(seen[3], [1, 2, np.deg2rad(3)])
    np.testing.assert_allclose(seen[4], [1, 2, 0])


def test_booleans_and_enumerations_can_be_cut_and_frozen():
    items = (("off", 1), ("on", 2))
    kinds = {"flag": {"type": "boolean"}, "mode": {"type": "enumeration", "items": items}}

    def give(block):
        block["flag"], block["mode"] = 1.0, 2.0

    def take(block):
        block["saw_flag"], block["saw_mode"] = block["flag"], block["mode"]

    giver = Mock("giver", model("giver", *(Variable(n, "output", **k) for n, k in kinds.items())), give)
    ports = [Variable(n, "input", **k) for n, k in kinds.items()]
    ports += [Variable(f"saw_{n}", "output", **k) for n, k in kinds.items()]
    taker = Mock("taker", model("taker", *ports, feedthrough={"saw_flag": ["flag"], "saw_mode": ["mode"]}), take)
    wires = ["giver.flag -> taker.flag", "giver.mode -> taker.mode"]
    faults = [{"at": 1, "cut": "giver.flag"}, {"at": 1, "cut": "giver.mode", "to": "off"}]
    result = run([giver, taker], {"step": 1, "duration": 2, "connections": wires, "faults": faults})
    assert result["taker.saw_flag"].tolist() == [True, False, False]
    assert result["taker.saw_mode"].tolist() == [2, 1, 1]


# ---------------------------------------------------------------- parameters and free inputs


def tuned(*faults, every=1, fails_at=None, **scenario):
    """y = gain, a tunable parameter, evaluated in each step."""

    def evaluate(block):
        pass

    def advance(block, time, step):
        if fails_at is not None and block["gain"] == fails_at:
            raise block.fail("fmi2DoStep")
        block["y"] = block["gain"] + block["free"]

    ports = (
        real("gain", "parameter", variability="tunable", minima=(0.0,), maxima=(10.0,)),
        real("fixed", "parameter", variability="fixed"),
        Variable("text", "parameter", type="string", variability="tunable"),
        real("free", "input"),
        real("y", "output"),
    )
    block = Mock("block", model("block", *ports), evaluate, advance)
    data = {"step": 0.1, "duration": 1, "faults": list(faults), **scenario}
    start = {"block": {"gain": 1, "free": 0}}
    return run([block], data, start=start, every={"block": every}), block


def test_a_tunable_parameter_is_set_before_the_step_that_begins_at_its_time():
    result, _ = tuned({"at": 0.5, "set": "block.gain = 3"})
    assert result["block.y"][4:8].tolist() == [1.0, 1.0, 3.0, 3.0]


def test_what_was_set_for_a_while_is_set_back():
    result, _ = tuned({"at": 0.2, "set": "block.gain = 2"}, {"at": 0.5, "until": 0.7, "set": "block.gain = 3"})
    assert result["block.y"][1:10].tolist() == [1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 2.0, 2.0]


def test_the_same_fault_twice_begins_and_ends_as_one():
    fault = {"at": 0.3, "until": 0.7, "set": "block.gain = 3"}
    once, twice = tuned(fault)[0], tuned(fault, fault)[0]
    np.testing.assert_array_equal(once["block.y"], twice["block.y"])


def test_an_input_that_is_not_connected_can_be_set():
    result, _ = tuned({"at": 0, "until": 0.3, "set": "block.free = 5"})
    assert result["block.y"][[1, 3, 4]].tolist() == [6.0, 6.0, 1.0]


def test_a_slow_block_is_set_between_two_of_its_steps():
    """At 0.5 s its step from 0.4 s to 0.8 s is under way."""
    result, _ = tuned({"at": 0.5, "set": "block.gain = 3"}, every=4, duration=1.6)
    assert result["block.y"][[4, 8, 12, 16]].tolist() == [1.0, 1.0, 3.0, 3.0]


def test_a_failure_after_a_fault_names_the_time_as_ever():
    result, _ = tuned({"at": 0.5, "set": "block.gain = 3"}, fails_at=3.0)
    assert isinstance(result.failure, BlockError)
    assert (result.failure.time, len(result.time)) == (0.5, 6)


def test_a_refused_setting_names_its_time():
    result, block = tuned()
    assert result.failure is None

    def refuse(values):
        raise block.fail("fmi2SetReal of gain")

    calls = []
    block.set = lambda values: calls.append(values) if len(calls) < 1 else refuse(values)
    faults = [{"at": 0.3, "set": "block.gain = 2"}]
    failed = run([block], {"step": 0.1, "duration": 1, "faults": faults}, start={"block": {"free": 0}})
    assert "block: fmi2SetReal of gain at 0.3 s: gave status error" in str(failed.failure)
    assert len(failed.time) == 4


# ---------------------------------------------------------------- what is refused


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ({"at": 1}, "faults[1]: expected exactly one of set, freeze, bias, cut; found none"),
        ({"at": 1, "cut": "a.y", "freeze": "a.y"}, "found freeze and cut"),
        ({"at": 1, "bias": "block.y"}, "'by' says what 'bias' adds; expected both or neither"),
        ({"at": 1, "freeze": "block.y", "to": 1}, "'to' says what is given instead of a signal that is cut"),
        ({"at": 0.5, "until": 0.5, "cut": "block.y"}, "until: expected a time after 0.5 s, found 0.5 s"),
        ({"at": -1, "cut": "block.y"}, "at: expected zero or more, found -1 s"),
        ({"cut": "block.y"}, "faults[1]: 'at' is missing: when it begins"),
        ({"at": 1, "kut": "block.y"}, "unknown key 'kut'; did you mean 'cut'?"),
        ({"at": 3, "set": "block.gain = 1"}, "faults[1].at: 3 s lies after the end of the run, 1 s"),
        ({"at": 1, "set": "block.gain"}, "faults[1].set: expected block.parameter = value, found 'block.gain'"),
        ({"at": 1, "set": "block.gian = 1"}, "block has no input or output or parameter 'gian'; did you mean 'gain'?"),
        ({"at": 1, "set": "blok.gain = 1"}, "there is no block 'blok'; did you mean 'block'?"),
        ({"at": 1, "set": "block.gain = 11"}, "faults[1].set: expected at most 10, found 11"),
        ({"at": 1, "set": "block.gain = 1 kg"}, "gain has no unit, so expected a bare number, found '1 kg'"),
        (
            {"at": 1, "set": "block.fixed = 1"},
            "block.fixed is fixed: FMI lets only tunable parameters and inputs be set during a run; tunable are "
            "gain, text",
        ),
        ({"at": 1, "set": "block.y = 1"}, "block.y is an output"),
        ({"at": 0.5, "until": 1, "set": "block.text = a"}, "block.text is text, which can be set but not be restored"),
        ({"at": 1, "freeze": "block"}, "faults[1].freeze: expected block.variable, found 'block'"),
        ({"at": 1, "freeze": "block.y"}, "block.y feeds no input, so nothing would change"),
        ({"at": 1, "freeze": "block.free"}, "block.free is not connected; remedy: set: block.free = ..."),
        ({"at": 1, "cut": "block.gain"}, "block.gain is a parameter and no signal; remedy: set: block.gain = ..."),
    ],
)
def test_a_wrong_fault_is_refused(fault, message):
    with pytest.raises(InputError) as info:
        tuned(fault)
    assert message in str(info.value)


@pytest.mark.parametrize(
    ("at", "every", "begun"),
    [(1.0, 1, "0.9"), (0.95, 1, "0.9"), (0.9, 2, "0.8"), (0.5, 4, "0.4"), (0.41, 4, "0.4")],
)
def test_a_value_that_no_step_of_its_block_sees_is_refused(at, every, begun):
    """With `every` 4 the last step, from 0.4 s to 0.8 s, is under way at 0.5 s, and the run ends before a third."""
    message = f"{at:g} s lies after the beginning of the last step of block, {begun} s; no step sees it"
    with pytest.raises(InputError) as info:
        tuned({"at": at, "set": "block.gain = 3"}, every=every)
    assert f"faults[1].at: {message}" in str(info.value)
    with pytest.raises(InputError) as info:
        tuned(every=every, timeline=[{"at": min(at, 0.99), "set": {"block.gain": 3}}])
    assert f"timeline[1].set.block.gain: {message.replace('1 s lies', '0.99 s lies') if at == 1 else message}" in str(
        info.value
    )


@pytest.mark.parametrize(("at", "every"), [(0.9, 1), (0.8, 2), (0.75, 2), (0.4, 4)])
def test_a_value_for_the_last_step_of_its_block_is_seen(at, every):
    result, _ = tuned({"at": at, "set": "block.gain = 3"}, every=every)
    assert result["block.y"][-1] == 3.0


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ({"at": 1, "set": "law.u = 1"}, "law.u is connected; remedy: 'cut: law.u' with 'to'"),
        ({"at": 1, "bias": "law.u", "by": [1, 2]}, "expected one value, found a list of 2"),
        ({"at": 1, "bias": "law.u", "by": "2 kg"}, "by: the unit 'kg' does not fit that of u, 1"),
        ({"at": 1, "bias": "law.u", "by": True}, "by: expected a number or text with a unit, found true"),
        ({"at": 1, "cut": "law.u", "to": "NaN"}, "expected a number with a unit"),
        ({"at": 1, "cut": "law.u[1]"}, "law.u is a real scalar"),
    ],
)
def test_a_wrong_fault_of_a_signal_is_refused(fault, message):
    with pytest.raises(InputError) as info:
        chain(fault)
    assert message in str(info.value)


def whole(**fault):
    """A whole number that a block gives to another whose input is at most 5, with a fault from the start."""

    def give(block):
        block["o"] = 1.0

    def take(block):
        block["seen"] = block["i"]

    giver = Mock("a", model("a", Variable("o", "output", type="integer")), give)
    ports = Variable("i", "input", type="integer", maxima=(5.0,)), Variable("seen", "output", type="integer")
    taker = Mock("b", model("b", *ports, feedthrough={"seen": ["i"]}), take)
    scenario = {"step": 1, "duration": 2, "connections": ["a.o -> b.i"], "faults": [{"at": 0, **fault}]}
    return run([giver, taker], scenario)["b.seen"].tolist()


@pytest.mark.parametrize("name", ["a.o", "b.i"])
@pytest.mark.parametrize("by", [1.5, "1.5", "1.5 m"])
def test_a_bias_of_a_whole_number_is_one_too(name, by):
    with pytest.raises(InputError, match=f"by: expected a whole number, found '?{by}"):
        whole(bias=name, by=by)
    assert whole(bias=name, by=2) == [3, 3, 3]


def test_a_fault_may_lie_beyond_the_limits_of_its_receiver():
    assert whole(cut="b.i", to=9) == [9, 9, 9]


def test_a_time_between_two_steps_is_taken_as_the_next_with_a_note():
    result = chain({"at": 0.42, "until": "0.55 s", "cut": "plant.y"})
    assert result["law.y"][[4, 5, 6]] == pytest.approx([0.4, 0.0, 0.6])
    assert "faults[1].at: 0.42 s is no multiple of the step, 0.1 s; taken as 0.5 s" in result.warnings[0]
    assert "taken as 0.6 s" in result.warnings[1]


# ---------------------------------------------------------------- as a user sees it


def test_faults_are_the_same_in_processes(loop):
    freeze = {"at": 1.0, "until": 1.5, "freeze": "motor.speed"}
    faults = [freeze, {"at": 0.5, "until": 0.7, "set": "regulator.gain = -2"}]
    results = []
    for isolation in ("none", "process"):
        source = read(loop).with_value("isolation", isolation, "").with_value("faults", faults, "")
        results.append(run_scenario(load(source)))
    np.testing.assert_array_equal(results[0].samples, results[1].samples)
    assert results[1].manifest["fmus"]["motor"]["isolation"] == "process"


@pytest.mark.parametrize("name", ["failed_rod", "stuck_wheel", "lost_magnetometer"])
def test_the_scenarios_with_faults_show_what_they_say(name):
    result = run_scenario(SCENARIOS / f"fault_{name}.yaml")
    assert [outcome.name for outcome in result.outcomes if not outcome.passed] == []
