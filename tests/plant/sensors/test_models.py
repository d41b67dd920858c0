"""Each sensor's model against closed forms, textbook formulas and integrals."""

from __future__ import annotations

import ctypes
import dataclasses
import math

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

import plant.sensors as sensors
from plant.sensors import gyro, noise, signal_loss, sun_sensors
from tests.blocks import inputs, parameters
from tests.native.driver import Instance, Refused

RARE = 1e-6
EARTH = 6378137.0
R = Rotation.from_rotvec([0.9, -0.7, 0.5]).as_matrix()
DIPOLE = [3.0, -2.0, 5.0]


def checked(**changes):
    p = parameters("plant_sensors", **changes)
    sensors.check(p)
    return p


def truth(**changes):
    known = {"R_NB": R, "omega_B": [0.05, -0.02, 0.03], "b_B": [2e-5, 1.5e-5, -3e-5], "r_N": [7e6, 0.0, 0.0]}
    return inputs("plant_sensors", **{**known, "sun_N": [0.0, 0.6, 0.8], "dipole": DIPOLE, **changes})


def first(u=None, **changes):
    """The outputs at t = 0."""
    p = checked(**changes)
    u = truth() if u is None else u
    return sensors.outputs(sensors.start(p, u), u, p)


# ---------------------------------------------------------------- gyro and magnetometer

SCALE = [[0.01, 0.002, -0.003], [0.001, -0.02, 0.004], [-0.005, 0.006, 0.03]]


def test_scale_factor_and_misalignment_are_the_rows_of_i_plus_s():
    y = first(rate_scale=SCALE, field_scale=SCALE, rate_bias_B=[0.1, 0.2, 0.3])
    assert y.omega_B_measured == pytest.approx((np.eye(3) + SCALE) @ truth().omega_B + [0.1, 0.2, 0.3], rel=1e-14)
    assert y.b_B_measured == pytest.approx((np.eye(3) + SCALE) @ truth().b_B, rel=1e-14)


def test_the_rods_disturb_the_magnetometer_in_proportion_to_their_dipole_and_not_while_they_are_off():
    coupling = 1e-7 * np.array([[1.0, 2.0, 3.0], [-4.0, 5.0, 6.0], [7.0, -8.0, 9.0]])
    for share in (0.0, 1.0, -2.5):
        y = first(truth(dipole=share * np.array(DIPOLE)), field_rod_coupling=coupling)
        assert y.b_B_measured - truth().b_B == pytest.approx(share * coupling @ DIPOLE, abs=1e-19)


def test_range_clips_and_resolution_rounds_to_the_nearest_multiple():
    y = first(truth(omega_B=[0.0374, -5.0, 0.0376]), rate_range=0.5, rate_quantum=0.001)
    assert y.omega_B_measured == pytest.approx([0.037, -0.5, 0.038], abs=1e-15)
    errors = [
        first(truth(omega_B=[w, -w, 0.0]), rate_quantum=0.01).omega_B_measured - [w, -w, 0.0]
        for w in np.linspace(0, 1, 199)
    ]
    assert np.abs(errors).max() <= 0.005 + 1e-15
    assert np.std(np.array(errors)[:, 0]) == pytest.approx(0.01 / math.sqrt(12.0), rel=0.05)


def series(n: int, T: float, **changes) -> np.ndarray:
    """(n,3) rates of a gyro at rest, T s apart."""
    p = checked(**changes, seed=21)
    walk, markov, found = np.zeros(3), gyro.correlated(np.zeros(3), p, 0, math.inf), []
    for k in range(1, n + 1):
        walk, markov = gyro.walked(walk, p, k, T), gyro.correlated(markov, p, k, T)
        found.append(gyro.measured(np.zeros(3), walk + markov, p, k, T))
    return np.array(found)


def allan_variance(rates: np.ndarray, m: int) -> tuple[float, int]:
    """Of clusters of m samples (IEEE Std 952, C.1), the mean over the axes, and how many differences it is made of."""
    clusters = rates[: len(rates) // m * m].reshape(-1, m, 3).mean(axis=1)
    differences = np.diff(clusters, axis=0)
    return 0.5 * float((differences**2).mean()), differences.size


def markov_variance(sigma: float, time: float, tau: float) -> float:
    """IEEE Std 952, C.1.5: (q T_c)^2/tau (1 - T_c/(2 tau) (3 - 4 e^(-tau/T_c) + e^(-2 tau/T_c))), sigma^2 = q^2
    T_c/2."""
    x = tau / time
    return 2.0 * sigma**2 / x * (1.0 - (3.0 - 4.0 * math.exp(-x) + math.exp(-2.0 * x)) / (2.0 * x))


def sampled_walk_variance(K: float, T: float, m: int) -> float:
    """K^2 tau/3 of a rate that wanders between samples; of samples T apart it is this by (2 m^2 + 1)/(2 m^2)."""
    return K**2 * m * T / 3.0 * (1.0 + 0.5 / m**2)


@pytest.mark.parametrize(
    ("changes", "variance"),
    [
        ({"angle_random_walk": 2e-4}, lambda m, T: (2e-4) ** 2 / (m * T)),
        ({"rate_random_walk": 3e-6}, lambda m, T: sampled_walk_variance(3e-6, T, m)),
        ({"rate_instability": 5e-5, "rate_instability_time": 10.0}, lambda m, T: markov_variance(5e-5, 10.0, m * T)),
    ],
    ids=["angle random walk", "rate random walk", "instability"],
)
def test_the_allan_variance_is_the_textbook_s(changes, variance):
    T = 0.5
    rates = series(12000, T, **changes)
    for m in (4, 20):
        found, count = allan_variance(rates, m)
        # Neighbouring differences share a cluster: fewer degrees of freedom than differences, by 3/2 for white noise.
        assert found == pytest.approx(variance(m, T), rel=5.0 * math.sqrt(2.0 * 2.0 / count))


def test_the_largest_allan_deviation_of_the_instability_is_where_the_interface_says():
    tau = np.linspace(0.5, 5.0, 4501)
    deviation = np.sqrt([markov_variance(1.0, 1.0, x) for x in tau])
    assert deviation.max() == pytest.approx(0.617, abs=5e-4)
    assert tau[deviation.argmax()] == pytest.approx(1.89, abs=5e-3)


def test_the_angle_random_walk_keeps_its_density_at_every_period_and_step():
    for changes, h, T in (({"rate_period": 0.5}, 0.1, 0.5), ({}, 0.1, 0.1), ({"sensor_period": 0.2}, 0.1, 0.2)):
        p = checked(angle_random_walk=1e-3, **changes)
        x, u = sensors.start(p, truth(omega_B=[0.0, 0.0, 0.0])), truth(omega_B=[0.0, 0.0, 0.0])
        for _ in range(5):
            x, y = sensors.step(x, u, p, h)
        xi = noise.normals(p.seed, int(x.sample[1]), noise.RATE, 3)
        assert y.omega_B_measured == pytest.approx(1e-3 / math.sqrt(T) * xi, rel=1e-12)


# ---------------------------------------------------------------- sun sensors


@pytest.mark.parametrize("angle", [0.0, 20.0, 59.9, 60.1, 89.0, 91.0, 180.0])
def test_a_coarse_sun_sensor_follows_the_cosine_within_its_field_of_view(angle):
    a = math.radians(angle)
    y = first(
        truth(R_NB=np.eye(3), sun_N=[math.cos(a), math.sin(a), 0.0], sunlight=0.8),
        sun_sensor_half_angle=math.radians(60.0),
    )
    assert y.sun_sensors[0] == pytest.approx(0.8 * math.cos(a) if angle < 60.0 else 0.0, abs=1e-15)
    assert y.sun_sensors[4] == 0.0


def test_six_sensors_on_the_faces_find_every_sun_and_none_in_the_shadow():
    for s in Rotation.random(50, random_state=3).as_matrix()[:, 0]:
        y = first(truth(sun_N=s))
        assert y.sun_B_measured == pytest.approx(R.T @ s, abs=2e-5)
        assert y.sun_sample == 1
    dark = first(truth(sunlight=0.0))
    assert not dark.sun_B_measured.any()
    assert dark.sun_sample == 0
    alone = first(truth(sun_N=[1e9] * 3))
    assert not alone.sun_sensors.any()
    assert alone.sun_sample == 0


def test_sensors_on_a_pyramid_find_the_sun_from_three_and_a_sensor_without_axis_stays_dark():
    turns = np.radians(72.0) * np.arange(5)
    axes = np.column_stack((0.6 * np.cos(turns), 0.6 * np.sin(turns), np.full(5, 0.8)))
    y = first(
        truth(R_NB=np.eye(3), sun_N=[0.2, -0.1, math.sqrt(0.95)]),
        sun_sensor_axes=np.vstack((axes, np.zeros(3))),
        sun_sensor_noise=0.0,
    )
    assert y.sun_B_measured == pytest.approx([0.2, -0.1, math.sqrt(0.95)], abs=2e-5)
    assert y.sun_sensors[5] == 0.0


def view_factor(c: float, H: float) -> float:
    """To the sphere by an integral over the plate's sky: cosine of the plate's normal over pi, where the sphere is."""
    sine = 1.0 / H
    limb = math.asin(min(sine, 1.0))
    theta = (np.arange(600) + 0.5) / 600 * limb  # from the sphere's centre
    phi = (np.arange(600) + 0.5) / 600 * 2.0 * np.pi
    tilt = math.acos(c)
    cosine = np.cos(theta)[:, None] * math.cos(tilt) + np.sin(theta)[:, None] * math.sin(tilt) * np.cos(phi)
    return float((np.maximum(cosine, 0.0) * np.sin(theta)[:, None]).sum() * limb / 600 * 2.0 * np.pi / 600 / np.pi)


@pytest.mark.parametrize("H", [1.02, 1.1, 1.5, 4.0])
def test_the_view_factor_of_the_earth_is_the_integral_s(H):
    for c in (-1.0, -0.9, -0.5, -0.1, 0.0, 0.2, 0.6, 0.95, 1.0):
        assert sun_sensors.view_factor(c, H) == pytest.approx(view_factor(c, H), abs=2e-5)
    assert sun_sensors.view_factor(1.0, H) == pytest.approx(H**-2)


def test_the_albedo_lights_the_nadir_face_by_day_only():
    for sun, expected in (
        ([1.0, 0.0, 0.0], 0.3 / (7e6 / EARTH) ** 2),
        ([0.6, 0.8, 0.0], 0.6 * 0.3 / (7e6 / EARTH) ** 2),
        ([-0.6, 0.8, 0.0], 0.6),
    ):
        y = first(truth(R_NB=np.eye(3), sun_N=sun), albedo=0.3)  # at +X of the Earth: -X looks down
        assert y.sun_sensors[1] == pytest.approx(expected, rel=1e-12)


def test_a_fine_sun_sensor_errs_by_its_noise_within_its_cone():
    changes = {
        "sun_sensor": "fine",
        "fine_sun_axis_B": [0.0, 0.0, 1.0],
        "fine_sun_half_angle": math.radians(60.0),
        "fine_sun_noise": 1e-3,
    }
    off = []
    for seed in range(300):
        y = first(truth(R_NB=np.eye(3), sun_N=[0.6, 0.0, 0.8]), **changes, seed=seed)
        off.append(np.cross([0.6, 0.0, 0.8], y.sun_B_measured))
    chi2 = float((np.array(off) ** 2).sum()) / 1e-6  # two of the three axes turn the vector
    assert 2.0 * min(stats.chi2.cdf(chi2, 600), stats.chi2.sf(chi2, 600)) > RARE
    for angle, seen in ((59.9, True), (60.1, False)):
        a = math.radians(angle)
        y = first(truth(R_NB=np.eye(3), sun_N=[math.sin(a), 0.0, math.cos(a)]), **changes)
        assert y.sun_B_measured.any() == seen


# ---------------------------------------------------------------- star tracker


def test_the_star_tracker_has_one_sigma_across_its_boresight_and_another_about_it():
    boresight = np.array([2.0, -1.0, 2.0]) / 3.0
    turns = []
    for seed in range(300):
        y = first(attitude_noise=1e-5, attitude_noise_about=1e-4, attitude_boresight_B=boresight, seed=seed)
        turns.append(Rotation.from_matrix(R.T @ y.R_NB_measured).as_rotvec())
    about = np.array(turns) @ boresight
    across = np.array(turns) - about[:, None] * boresight
    for chi2, n in ((float((about**2).sum()) / 1e-8, 300), (float((across**2).sum()) / 1e-10, 600)):
        assert 2.0 * min(stats.chi2.cdf(chi2, n), stats.chi2.sf(chi2, n)) > RARE


LIMB = math.degrees(math.asin(EARTH / 7e6))
BLIND = {
    "a rate at the limit": ({}, {"attitude_rate_max": 0.0617}, True),
    "a rate above the limit": ({}, {"attitude_rate_max": 0.0616}, False),
    "the Sun outside its exclusion": ({"sun": 40.1}, {"attitude_sun_exclusion": math.radians(40.0)}, True),
    "the Sun inside": ({"sun": 39.9}, {"attitude_sun_exclusion": math.radians(40.0)}, False),
    "the Sun inside, behind the Earth": (
        {"sun": 39.9, "sunlight": 0.0},
        {"attitude_sun_exclusion": math.radians(40.0)},
        True,
    ),
    "the limb outside its exclusion": ({"nadir": LIMB + 25.1}, {"attitude_earth_exclusion": math.radians(25.0)}, True),
    "the limb inside": ({"nadir": LIMB + 24.9}, {"attitude_earth_exclusion": math.radians(25.0)}, False),
}


@pytest.mark.parametrize("case", BLIND)
def test_the_star_tracker_is_blind_by(case):
    where, changes, seen = BLIND[case]
    sun, nadir = math.radians(where.get("sun", 90.0)), math.radians(where.get("nadir", 180.0))
    u = truth(
        R_NB=np.eye(3),  # the boresight is -Z
        sun_N=[math.sin(sun), 0.0, -math.cos(sun)],
        r_N=[7e6 * math.sin(nadir), 0.0, 7e6 * math.cos(nadir)],
        sunlight=where.get("sunlight", 1.0),
    )
    y = first(u, **changes)
    assert (y.attitude_sample, bool(y.R_NB_measured.any())) == (int(seen), seen)


# ---------------------------------------------------------------- drop-outs, periods, state


def test_drop_outs_have_the_mean_times_asked_for_at_any_span():
    for span in (0.1, 7.0):
        was, found = False, []
        for k in range(1, 8001):
            was = signal_loss.lost(was, 30.0, 10.0, span, 5, k, noise.ORBIT_LOSS)
            found.append(was)
        lost = np.array(found)
        e = math.exp(-span * (1.0 / 30.0 + 1.0 / 10.0))
        kept = lost[1:][lost[:-1]]  # P(lost, lost) = q + (1 - q) e, and P(found, lost) = q - q e with q = 1/4
        for sample, probability in ((kept, 0.25 + 0.75 * e), (lost[1:][~lost[:-1]], 0.25 * (1.0 - e))):
            low, high = stats.binom.ppf([RARE, 1.0 - RARE], sample.size, probability)
            assert low <= sample.sum() <= high


def test_a_fix_is_held_through_a_drop_out_and_no_number_counts_it():
    p = checked(orbit_outage_interval=1.0, orbit_outage_duration=1.0, position_noise=1.0)
    x, held, counts = sensors.start(p, truth()), [], []
    for _ in range(200):
        before = x
        x, y = sensors.step(x, truth(), p, 0.1)
        counts.append(y.orbit_sample - before.orbit_sample)
        held.append(np.array_equal(y.r_N_measured, before.r_N_measured))
        assert held[-1] == x.orbit_lost
    assert counts == [0 if same else 1 for same in held]
    assert 20 < sum(held) < 180


def test_each_sensor_has_its_own_period_and_number():
    periods = {"rate_period": 0.1, "field_period": 0.2, "attitude_period": 0.25, "orbit_period": 1.0, "sun_period": 0.5}
    p = checked(**periods, sensor_period=0.3)
    x = sensors.start(p, truth())
    for i in range(1, 21):
        x, y = sensors.step(x, truth(h_w=0.1 * i), p, 0.1)
    assert (y.rate_sample, y.field_sample, y.attitude_sample, y.orbit_sample, y.sun_sample) == (21, 11, 9, 3, 5)
    assert y.h_w_measured == pytest.approx(1.8)


def test_the_number_of_measurements_goes_on_at_one_behind_the_largest():
    p = checked()
    x = dataclasses.replace(sensors.start(p, truth()), rate_sample=2**31 - 1)
    assert sensors.step(x, truth(), p, 0.1)[1].rate_sample == 1


DRIFTING = {
    "rate_random_walk": 1e-4,
    "rate_instability": 1e-4,
    "attitude_outage_interval": 0.3,
    "attitude_outage_duration": 0.3,
    "orbit_outage_interval": 0.3,
    "orbit_outage_duration": 0.3,
    "rate_period": 0.2,
}


def test_drift_and_drop_outs_agree_in_both_flavours_are_restored_with_the_state_and_cleared_by_a_reset():
    p, u = checked(**DRIFTING), truth()
    x, expected = sensors.start(p, u), []
    for _ in range(40):
        x, y = sensors.step(x, u, p, 0.1)
        expected.append(np.concatenate([y.omega_B_measured, [y.attitude_sample, y.orbit_sample, y.rate_sample]]))

    def flown(it: Instance, steps: range) -> list[np.ndarray]:
        found = []
        for i in steps:
            it.step(0.1 * i, 0.1)
            y = it.outputs()
            found.append(
                np.concatenate([y["omega_B_measured"], [y[f"{n}_sample"] for n in ("attitude", "orbit", "rate")]])
            )
        return found

    with Instance("plant_sensors") as it:
        it.set_all(p)
        it.set_all(u)
        it.initialize()
        whole = flown(it, range(20))
        saved = ctypes.c_void_p()
        it.call("GetFMUstate", ctypes.byref(saved))
        whole += flown(it, range(20, 40))
        assert np.abs(np.array(whole) - expected).max() < 1e-15
        it.call("SetFMUstate", saved)
        assert np.array_equal(flown(it, range(20, 40)), whole[20:])
        it.call("FreeFMUstate", ctypes.byref(saved))
        it.call("Reset")
        it.set_all(p)
        it.set_all(u)
        it.initialize()
        assert np.array_equal(flown(it, range(40)), whole)


@pytest.mark.parametrize(
    ("changes", "missing", "name"),
    [
        ({"field_rod_coupling": 1e-7 * np.eye(3)}, "dipole", "field_rod_coupling"),
        ({"attitude_sun_exclusion": 0.5}, "sun_N", "attitude_sun_exclusion"),
    ],
)
def test_a_model_that_needs_an_input_refuses_a_step_without_it(changes, missing, name):
    p, u = checked(**changes), truth(**{missing: [1e9] * 3})
    with pytest.raises(ValueError, match=f"{missing}: expected to be connected, since {name} is not zero"):
        sensors.step(sensors.start(p, u), u, p, 0.1)
    with Instance("plant_sensors") as it:
        it.set_all(p)
        it.set_all(u)
        it.initialize()
        with pytest.raises(Refused, match=f"{missing}: expected to be connected, since {name} is not zero"):
            it.step(0.0, 0.1)
