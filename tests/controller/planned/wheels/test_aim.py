"""Shedding that ends near the attitude that is wanted: controller/planned/wheels/native/aim.c."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from evidence.flight.schemes import change
from evidence.wheels.cases import CONDITIONS, Flights, scenario
from orchestration import run
from tests.native.driver import Instance
from tests.plant.motion import FULL_INERTIA

from .loop import FOUR, MEASURED, MOMENTUM, STILL, H, fly
from .test_decisions import SHED, Seen

SAMPLES = 400


def tumble(seed: int, momentum: float) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    along = rng.normal(size=3)
    rate = np.linalg.solve(FULL_INERTIA, momentum * along / np.linalg.norm(along))
    return {**STILL, "omega_B0": rate, "q_NB0": np.roll(Rotation.random(random_state=seed).as_quat(), 1)}


def test_shedding_ends_near_the_attitude_and_not_in_a_random_one() -> None:
    """The angle of a random rotation is 126 deg in the mean, and below 60 deg for one of 17: (a - sin a)/pi."""
    ends = []
    for seed in range(8):
        seen = Seen()
        fly(1200.0, seen, FOUR, tumble(seed, 4.0 * MOMENTUM), {})
        assert seen.phase[0] == SHED
        ends.append(seen.error[len(seen.phase) - seen.phase[::-1].index(SHED)])
        assert max(seen.error[-100:]) < 0.1
    assert sum(end < 60.0 for end in ends) >= 5


def test_momentum_is_shed_a_second_time_as_the_first() -> None:
    tumbling: list[dict[str, Any]] = []

    def keep(_: int, seen: dict[str, Any], __: Any, ___: Instance) -> None:
        tumbling.append(seen)

    fly(SAMPLES * H, keep, FOUR, tumble(3, 4.0 * MOMENTUM), {})
    still = {**tumbling[0], "omega_B": np.zeros(3)}
    commands: list[list[np.ndarray]] = [[], []]
    with Instance("controller_planned_wheels") as it:
        for name, value in FOUR.items():
            it.set(name, value)
        for i, seen in enumerate([*tumbling, still, *tumbling]):
            for name in MEASURED:
                it.set(name, seen[name])
            it.initialize() if i == 0 else it.step((i - 1) * H, H)
            y = it.outputs()
            if i != SAMPLES:
                assert y["phase"] == SHED or i % (SAMPLES + 1) > 100
                commands[i // (SAMPLES + 1)].append(np.append(y["wheel_torque_ff"], y["dipole_ff"]))
    first, second = map(np.array, commands)
    assert np.abs(first[:50, :4]).max() > 1e-3
    np.testing.assert_allclose(second[:100], first[:100], rtol=1e-9, atol=1e-12)


def test_an_end_of_shedding_that_does_not_come_is_given_up() -> None:
    """Near the equator the momentum lies along the field; what three wheels hold with one stuck, no course sheds to."""
    flights = Flights("50 kg", "one stuck")
    data = change(scenario(flights, CONDITIONS["one stuck"]), flights.drawn(9)[8])
    recorded = {"interval": 10.0, "signals": ["judge.attitude_error"]}
    flown = run({**data, "duration": 4000.0, "record": recorded})
    assert np.degrees(flown["judge.attitude_error"][-60:].max()) < 1.0
