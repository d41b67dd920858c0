"""The sensors as a block, against closed forms."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

import plant.sensors as sensors
from tests.blocks import inputs, parameters

RARE = 1e-6
R = Rotation.from_rotvec([0.9, -0.7, 0.5]).as_matrix()
TRUTH = {
    "R_NB": R,
    "omega_B": [0.05, -0.02, 0.03],
    "r_N": [5e6, -4e6, 2.7e6],
    "v_N": [3e3, 5e3, -4e3],
    "b_B": [2e-5, 1.5e-5, -3e-5],
    "h_w": 0.012,
}
NOISY = {
    "attitude_noise": 2e-4,
    "rate_noise": 1e-5,
    "field_noise": 5e-8,
    "wheel_momentum_noise": 1e-5,
    "position_noise": 10.0,
    "velocity_noise": 0.02,
}
BIASED = {
    "attitude_bias_B": [0.01, -0.02, 0.03],
    "rate_bias_B": [1e-4, -2e-4, 3e-4],
    "field_bias_B": [1e-7, -2e-7, 3e-7],
}
NAMES = list(TRUTH)


def checked(**changes):
    p = parameters("plant_sensors", **changes)
    sensors.check(p)
    return p


def truth(**changes):
    return inputs("plant_sensors", **{**TRUTH, **changes})


def vectors(y) -> np.ndarray:
    """All measurements in a row."""
    return np.concatenate([np.ravel(getattr(y, f"{name}_measured")) for name in NAMES])


def run(p, h: float, n: int, u=truth) -> list:
    """The outputs after 0, 1, .. n steps; u(t) is the truth."""
    x = sensors.start(p, u(t=0.0) if u is not truth else u())
    found = [sensors.outputs(x, truth() if u is truth else u(t=0.0), p)]
    for i in range(1, n + 1):
        x, y = sensors.step(x, truth() if u is truth else u(t=i * h), p, h)
        found.append(y)
    return found


def test_without_noise_and_bias_the_outputs_are_the_inputs_to_the_bit():
    for y in run(checked(), 0.1, 3):
        for name in NAMES:
            assert np.array_equal(getattr(y, f"{name}_measured"), getattr(truth(), name)), name


def test_biases_add_to_rate_and_field_and_turn_the_attitude_in_body_axes():
    y = run(checked(**BIASED), 0.1, 2)[-1]
    turn = Rotation.from_rotvec(BIASED["attitude_bias_B"]).as_matrix()
    assert pytest.approx(R @ turn, abs=1e-15) == y.R_NB_measured
    assert y.omega_B_measured == pytest.approx(np.add(TRUTH["omega_B"], BIASED["rate_bias_B"]), rel=1e-15)
    assert y.b_B_measured == pytest.approx(np.add(TRUTH["b_B"], BIASED["field_bias_B"]), rel=1e-15)
    for name in ("r_N", "v_N", "h_w"):
        assert np.array_equal(getattr(y, f"{name}_measured"), TRUTH[name])


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-160, 1e-9, 1e-4, 1.0, math.pi - 1e-9, math.pi, 6.0])
def test_the_attitude_s_error_is_the_exponential_at_any_size(angle):
    bias = angle * np.array([2.0, -1.0, 2.0]) / 3.0
    y = run(checked(attitude_bias_B=bias), 0.1, 1)[-1]
    assert pytest.approx(R @ Rotation.from_rotvec(bias).as_matrix(), abs=1e-15) == y.R_NB_measured


def errors(ys) -> dict[str, np.ndarray]:
    """What each measurement is off by, (n, axes); of the attitude the rotation vector in body axes."""
    found = {}
    for name in NAMES[1:]:
        found[name] = np.array([np.atleast_1d(getattr(y, f"{name}_measured") - np.array(TRUTH[name])) for y in ys])
    found["R_NB"] = np.array([Rotation.from_matrix(R.T @ y.R_NB_measured).as_rotvec() for y in ys])
    return found


SIGMAS = {
    "R_NB": "attitude_noise",
    "omega_B": "rate_noise",
    "b_B": "field_noise",
    "h_w": "wheel_momentum_noise",
    "r_N": "position_noise",
    "v_N": "velocity_noise",
}


def test_each_axis_of_each_sensor_has_normal_noise_of_its_sigma_about_its_bias():
    found = errors(run(checked(**NOISY, **BIASED, seed=5), 0.1, 2000)[1:])
    bias = {"R_NB": [0.0] * 3, "omega_B": BIASED["rate_bias_B"], "b_B": BIASED["field_bias_B"]}
    turn = Rotation.from_rotvec(BIASED["attitude_bias_B"]).as_matrix()
    plain = errors(run(checked(**NOISY, seed=5), 0.1, 2000)[1:])
    for name, sigma in SIGMAS.items():
        x = (plain if name == "R_NB" else found)[name] - bias.get(name, 0.0)
        for axis in x.T:
            assert stats.kstest(axis / NOISY[sigma], "norm").pvalue > RARE / 16, name
        chi2 = float((x**2).sum()) / NOISY[sigma] ** 2
        assert 2.0 * min(stats.chi2.cdf(chi2, x.size), stats.chi2.sf(chi2, x.size)) > RARE / 6, name
    # With a bias the noise adds to its rotation vector.
    both = [Rotation.from_matrix(turn.T @ Rotation.from_rotvec(e).as_matrix()).magnitude() for e in found["R_NB"]]
    assert np.sqrt(np.mean(np.square(both)) / 3.0) == pytest.approx(NOISY["attitude_noise"], rel=0.05)


def test_the_axes_of_all_sensors_are_uncorrelated():
    found = errors(run(checked(**NOISY, seed=9), 0.1, 2000)[1:])
    together = np.hstack([found[name] / NOISY[sigma] for name, sigma in SIGMAS.items()])
    n, k = together.shape
    assert k == 16
    # Bartlett's test of sphericity.
    statistic = -(n - 1 - (2 * k + 5) / 6) * np.log(np.linalg.det(np.corrcoef(together.T)))
    assert stats.chi2.sf(statistic, k * (k - 1) / 2) > RARE


def test_the_measured_attitude_is_a_rotation():
    for y in run(checked(attitude_noise=0.5, attitude_bias_B=[1.0, 2.0, -1.0]), 0.1, 300):
        assert np.abs(y.R_NB_measured.T @ y.R_NB_measured - np.eye(3)).max() < 3e-15
        assert np.linalg.det(y.R_NB_measured) > 0.9


def test_noise_of_one_sensor_does_not_change_with_the_parameters_of_another():
    alone = run(checked(field_noise=5e-8), 0.1, 20)
    for a, b in zip(alone, run(checked(**NOISY), 0.1, 20), strict=True):
        assert np.array_equal(a.b_B_measured, b.b_B_measured)
        assert not np.array_equal(a.omega_B_measured, b.omega_B_measured)


def test_a_seed_gives_one_run_and_another_seed_another():
    one, again, other = (run(checked(**NOISY, seed=s), 0.1, 5)[-1] for s in (3, 3, 4))
    assert np.array_equal(vectors(one), vectors(again))
    assert (vectors(one) != vectors(other)).all()


def test_a_step_repeated_from_its_state_gives_the_same_numbers():
    p = checked(**NOISY, sensor_period=0.3)
    x = sensors.start(p, truth())
    for i in range(7):
        first, second = (sensors.step(x, truth(h_w=0.001 * i), p, 0.1) for _ in range(2))
        assert np.array_equal(vectors(first[1]), vectors(second[1]))
        x = first[0]


def test_outputs_commit_nothing_and_follow_the_inputs_where_nothing_is_held():
    p = checked(**NOISY)
    x, y = sensors.step(sensors.start(p, truth()), truth(), p, 0.1)
    moved = sensors.outputs(x, truth(h_w=0.02, omega_B=[0.0, 0.0, 0.0]), p)
    assert moved.h_w_measured - y.h_w_measured == pytest.approx(0.008, rel=1e-12)
    assert y.omega_B_measured - moved.omega_B_measured == pytest.approx(TRUTH["omega_B"], rel=1e-9)
    assert np.array_equal(vectors(sensors.outputs(x, truth(), p)), vectors(y))


def ramp(t: float):
    return truth(h_w=t)


def test_measurements_are_held_for_their_period():
    ys = run(checked(sensor_period=0.3), 0.1, 12, ramp)
    found = [y.h_w_measured for y in ys]
    assert found == pytest.approx([0.0, 0.0, 0.0, 0.3, 0.3, 0.3, 0.6, 0.6, 0.6, 0.9, 0.9, 0.9, 1.2], abs=1e-15)


def test_where_steps_and_period_do_not_coincide_the_next_step_measures():
    ys = run(checked(sensor_period=0.25), 0.1, 10, ramp)
    assert [round(y.h_w_measured, 9) for y in ys] == [0.0, 0.0, 0.0, 0.3, 0.3, 0.5, 0.5, 0.5, 0.8, 0.8, 1.0]


def test_a_step_longer_than_the_period_takes_the_latest_measurement():
    long = run(checked(**NOISY, sensor_period=0.1), 0.5, 4, ramp)
    short = run(checked(**NOISY, sensor_period=0.1), 0.1, 20, ramp)
    for a, b in zip(long, short[::5], strict=True):
        assert vectors(a) == pytest.approx(vectors(b), rel=1e-14)


@pytest.mark.parametrize("h", [0.05, 0.1, 0.125, 0.25])
def test_with_a_period_results_do_not_depend_on_the_communication_step(h):
    fine = run(checked(**NOISY, sensor_period=0.5), 0.025, 400, ramp)
    coarse = run(checked(**NOISY, sensor_period=0.5), h, round(10.0 / h), ramp)
    stride = round(h / 0.025)
    for a, b in zip(coarse, fine[::stride], strict=True):
        assert vectors(a) == pytest.approx(vectors(b), rel=1e-14)


def test_rounding_of_many_steps_delays_no_measurement():
    """A hundred thousand steps of 0.1: their sum is off by 1.9e-8."""
    p, u = checked(sensor_period=1.0), truth()
    x = sensors.start(p, u)
    for i in range(1, 100001):
        x, _ = sensors.step(x, u, p, 0.1)
        assert (x.sample == i // 10).all()


REFUSED = {
    "negative noise": ({"rate_noise": -1e-9}, "rate_noise", "-1e-09", "at least 0"),
    "noise without end": ({"field_noise": math.inf}, "field_noise", "inf", "finite"),
    "a bias that is no number": ({"field_bias_B": [0.0, math.nan, 0.0]}, "field_bias_B", "nan", "finite"),
    "a negative period": ({"sensor_period": -0.1}, "sensor_period", "-0.1", "0 (every step) or at least 1e-06 s"),
    "a period of nothing": ({"sensor_period": 1e-7}, "sensor_period", "1e-07", "0 (every step) or at least 1e-06 s"),
    "a negative seed": ({"seed": -1}, "seed", "-1", "0 to 2147483647"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_is_refused_by_name_value_and_expectation(case):
    changes, name, *parts = REFUSED[case]
    said = "".join(f"(?=.*{re.escape(part)})" for part in parts)
    with pytest.raises(ValueError, match=rf"^{re.escape(name)}: {said}expected .*, found "):
        checked(**changes)


def test_a_step_of_more_than_a_thousand_million_periods_is_refused():
    p = checked(sensor_period=1e-6)
    with pytest.raises(
        ValueError, match=r"sensor_period: expected at least 1e-09 of the step, 2000\.0 s, found 1e-06 s"
    ):
        sensors.step(sensors.start(p, truth()), truth(), p, 2000.0)
