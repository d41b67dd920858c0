"""The outcomes of a hold, told apart from recorded signals."""

import numpy as np
import pytest

from orchestration import load
from orchestration.errors import InputError
from orchestration.expectations.holds import AT_ZERO, LATCHED, NEVER, RELEASED, HoldObserver, prepare
from tests.orchestration import mocks
from tests.orchestration.mocks import law

TIME = 0.5 * np.arange(8)
RUNNING = np.full((8, 2), 3.0)


def checked(limits=()):
    """The hold of `law.y` and `law.u` while `law.hold` is true, with limits of these names."""
    block = law("law")
    names = {limit: limit.replace(" ", "_") for limit in limits}
    for name in ("hold", *names.values()):
        block.model.variables[name] = mocks.Variable(name, "output", "boolean")
    entry = {"name": "commands", "signal": "law.hold", "keeps": ["law.y", "law.u"]}
    entry["limits"] = {limit: f"law.{name}" for limit, name in names.items()}
    scenario = load({"name": "s", "step": 0.5, "duration": 4, "blocks": {"law": {"fmu": "law"}}, "holds": [entry]})
    (check,) = prepare(scenario, {"law": block.model})
    return check


def outcome(held, kept=RUNNING, **limits):
    limits = {name.replace("_", " "): flag for name, flag in limits.items()}
    check = checked(limits)
    assert [node.element.variable for node in check.needed][:3] == ["hold", "y", "u"]
    columns = dict(zip(check.needed, np.array([held, *kept.T, *limits.values()], float), strict=True))
    told = []
    for piece in (len(TIME), 3, 1):  # in one piece or in several, the outcome is the same
        observer = HoldObserver(check)
        for i in range(0, len(TIME), piece):
            observer.see(TIME[i : i + piece], {node: column[i : i + piece] for node, column in columns.items()})
        told.append(observer.hold)
    assert told == [told[0]] * 3
    return told[0]


def test_a_run_without_a_hold_is_called_never_held():
    hold = outcome([0] * 8)
    assert (hold.outcome, hold.text, hold.spans) == (NEVER, "never held", [])


def test_a_running_value_that_is_held_and_released_is_told_with_both_times():
    hold = outcome([0, 1, 1, 0, 0, 0, 0, 0])
    assert hold.outcome == RELEASED
    assert hold.text == "running values held from 0.5 s to 1.5 s, then released"


def test_several_holds_are_counted_and_the_longest_is_told():
    hold = outcome([0, 1, 0, 1, 1, 1, 0, 0])
    assert hold.spans == [(0.5, 1.0), (1.5, 3.0)]
    assert hold.text.endswith("2 times in all, the longest for 1.5 s, released for the last time at 3 s")


def test_a_hold_of_zero_from_the_first_sample_is_not_called_a_hold_of_running_values():
    kept = np.where(np.arange(8)[:, None] < 3, 0.0, RUNNING)
    hold = outcome([1, 1, 1, 0, 0, 0, 0, 0], kept)
    assert hold.outcome == AT_ZERO
    assert hold.text == "held at zero from the start to 1.5 s, then released"


def test_a_hold_of_running_values_from_the_first_sample_is_not_called_a_hold_of_zero():
    assert outcome([1, 1, 1, 0, 0, 0, 0, 0]).outcome == RELEASED


@pytest.mark.parametrize("kept", [[3.0, 0.0], [0.0, 3.0], [0.0, -1e-300]])
def test_a_hold_of_values_of_which_only_some_are_zero_is_none_of_zero(kept):
    hold = outcome([1, 1, 1, 0, 0, 0, 0, 0], np.tile(kept, (8, 1)))
    assert (hold.outcome, hold.from_zero) == (RELEASED, False)
    assert hold.text == "running values held from 0 s to 1.5 s, then released"


def test_a_hold_that_the_end_finds_in_place_is_latched_and_names_the_limits_that_stand():
    hold = outcome(
        [0, 1, 0, 0, 1, 1, 1, 1],
        the_wheel_at_its_limit=[0, 0, 1, 0, 0, 1, 1, 1],
        the_rod_at_its_limit=[0, 0, 0, 0, 1, 1, 1, 0],
    )
    assert hold.outcome == LATCHED
    assert (
        hold.text
        == "latched: held since t = 2 s to the end of the run after one release, the wheel at its limit since 2.5 s"
    )


def test_a_hold_of_zero_that_never_ends_says_both():
    hold = outcome([1] * 8, np.zeros((8, 2)))
    assert hold.outcome == LATCHED
    assert hold.text == "latched: held at zero from the start to the end of the run"


def test_a_hold_of_the_last_sample_only_counts_as_in_place():
    assert outcome([0] * 7 + [1]).spans == [(3.5, None)]


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"signal": "law.y"}, "holds[1].signal: expected one boolean, but law.y is a real scalar"),
        ({"signal": "law.holds"}, "holds[1].signal: law has no variable 'holds'; did you mean 'hold'?"),
        ({"keeps": ["low.y"]}, "holds[1].keeps[1]: there is no block 'low'; did you mean 'law'?"),
        ({"limits": {"x": "law.z"}}, "holds[1].limits.x: law has no variable 'z'"),
    ],
)
def test_what_a_hold_names_wrongly_is_refused_with_its_place(entry, message):
    block = law("law")
    block.model.variables["hold"] = mocks.Variable("hold", "output", "boolean")
    scenario = {
        "step": 0.1,
        "duration": 1.0,
        "holds": [{"name": "h", "signal": "law.hold", "keeps": ["law.y"]} | entry],
    }
    with pytest.raises(InputError) as error:
        mocks.run([block], scenario)
    assert message in str(error.value)


def test_every_hold_that_names_something_wrongly_is_refused_at_once():
    block = law("law")
    block.model.variables["hold"] = mocks.Variable("hold", "output", "boolean")
    wrong = [{"name": n, "signal": f"law.{n}", "keeps": ["law.y"]} for n in ("one", "two")]
    with pytest.raises(InputError) as error:
        mocks.run([block], {"step": 0.1, "duration": 1.0, "holds": wrong})
    told = [message for message in error.value.messages if message.startswith("holds")]
    assert [message.partition(":")[0] for message in told] == ["holds[1].signal", "holds[2].signal"]


def test_several_releases_before_the_last_hold_are_counted():
    assert "after 2 releases" in outcome([1, 0, 1, 0, 1, 1, 1, 1]).text


def test_a_flag_counts_as_true_where_it_is_not_zero_whatever_number_a_block_gives_for_it():
    hold = outcome([0, 0, 0, 0, 2, 1, 1, 1], the_limit=[0, 0, 0, 0, 0, 3, 1, 1])
    assert (hold.name, hold.signal, hold.spans) == ("commands", "law.hold", [(2.0, None)])
    assert hold.limits == {"the limit": 2.5}
