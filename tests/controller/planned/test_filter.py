"""The planner's Kalman filter a step at a time, against the textbook's in NumPy and differences of the motion; and what
it rejects, widens and counts, the second time as the first."""

from dataclasses import replace

import numpy as np
import pytest

from . import core
from .states import SATELLITE, around, differences, state

TURN, RATE, BIAS, INERTIA, GAINS, TORQUE, DIPOLE = (slice(*at) for at in (
    (0, 3), (3, 6), (6, 9), (9, 15), (15, 18), (18, 21), (21, 24)
))  # fmt: skip
SIZES = np.repeat([1e-3, 1e-4, 1e-5, 0.05, 0.1, 1e-5, 0.1], [3, 3, 3, 6, 3, 3, 3])
"""Deviations: rad, rad/s, rad/s, kg m2, 1, N m, A m2."""
UNITS = np.outer(SIZES, SIZES)
DT = 0.05


def covariance(seed):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(24, 24))
    return A @ A.T / 24.0 * UNITS


def transition(satellite, a, x, u):
    """F (24, 24) by differences of the motion."""

    def rate_by(changed):
        one, two = (core.advanced(changed(sign), a, x, np.asarray(u), DT) for sign in (-1.0, 1.0))
        return 0.5 * (two.Omega - one.Omega)

    def inertia(i, sign):
        row, column = ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1))[i]
        J = satellite.J.copy()
        J[row, column] += 1e-4 * sign
        J[column, row] = J[row, column]
        return replace(satellite, J=J)

    def rods(i, sign):
        changed = satellite.rods.copy()
        changed[i] *= 1.0 + 1e-3 * sign
        return replace(satellite, rods=changed)

    F = np.eye(24)
    F[:6, :6] = differences(x, a, np.asarray(u, float), DT, satellite)[0][:6, :6]
    F[TURN, BIAS] = 0.0
    e = np.eye(3)
    F[RATE, INERTIA] = np.column_stack([rate_by(lambda s, i=i: inertia(i, s)) / 1e-4 for i in range(6)])
    F[RATE, GAINS] = np.column_stack([rate_by(lambda s, i=i: rods(i, s)) / 1e-3 for i in range(3)])
    F[RATE, TORQUE] = np.column_stack(
        [rate_by(lambda s, i=i: replace(satellite, disturbance_B=satellite.disturbance_B + 1e-5 * s * e[i])) / 1e-5
         for i in range(3)])  # fmt: skip
    F[RATE, DIPOLE] = np.column_stack(
        [rate_by(lambda s, i=i: replace(satellite, residual_B=satellite.residual_B + 0.1 * s * e[i])) / 0.1
         for i in range(3)])  # fmt: skip
    return F


@pytest.mark.parametrize("seed", range(3))
def test_the_covariance_after_a_sample_is_that_of_the_motion_linearised(seed):
    """Of what torques do, the turn within the sample is left out: half of DT of the rate's change."""
    a, x, u = around(seed), state(seed, 0.2), [0.7, -0.5, 0.3, 0.4]
    F, P = transition(SATELLITE, a, x, u), covariance(seed)
    assert np.abs(F[RATE, INERTIA]).max() > 1e-4
    F[TURN, INERTIA] = F[TURN, GAINS] = F[TURN, TORQUE] = F[TURN, DIPOLE] = 0.0
    for j in range(24):
        one = np.zeros((24, 24))
        one[j, j] = SIZES[j] ** 2
        expected, found = F @ one @ F.T / UNITS, core.propagated(SATELLITE, a, x, u, DT, one) / UNITS
        assert np.abs(found - expected).max() < 0.02 * np.abs(expected).max(), j
    found = core.propagated(SATELLITE, a, x, u, DT, P)
    assert found == pytest.approx(found.T, abs=0.0)
    assert np.abs((found - F @ P @ F.T) / UNITS).max() < 0.02


@pytest.mark.parametrize("seed", range(3))
def test_a_measurement_corrects_as_the_textbook_has_it(seed):
    P, rng = covariance(seed), np.random.default_rng(seed)
    variance, excess, innovation = np.array([2e-7, 3e-9]), np.array([1.5, 4.0]), 1e-3 * rng.normal(size=6)
    H = np.zeros((6, 24))
    H[:, :6], H[RATE, BIAS] = np.eye(6), np.eye(3)
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + np.diag(np.repeat(variance * excess, 3)))
    found, p, gain = core.corrected(variance, excess, np.zeros(3), innovation, P)
    assert found / UNITS == pytest.approx((P - K @ H @ P) / UNITS, abs=1e-9)
    assert p == pytest.approx((K @ innovation)[6:], rel=1e-9)
    assert gain == pytest.approx(K[:6], rel=1e-6, abs=1e-9)


def test_of_an_estimated_attitude_the_rate_alone_corrects_and_the_attitude_is_taken_as_it_is():
    P, variance, excess, sigma = covariance(5), np.array([2e-7, 3e-9]), np.array([1.5, 4.0]), np.array([1, 2, 3]) * 1e-4
    innovation = 1e-3 * np.random.default_rng(5).normal(size=6)
    found, p, gain = core.corrected(variance, excess, sigma, innovation, P)
    P[TURN], P[:, TURN] = 0.0, 0.0
    P[TURN, TURN] = np.diag(sigma**2)
    H = np.zeros((3, 24))
    H[:, RATE] = H[:, BIAS] = np.eye(3)
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + variance[1] * excess[1] * np.eye(3))
    assert found / UNITS == pytest.approx((P - K @ H @ P) / UNITS, abs=1e-9)
    assert p == pytest.approx((K @ innovation[RATE])[6:], rel=1e-9)
    assert gain[:3] == pytest.approx(np.eye(3, 6))
    assert gain[3:, 3:] == pytest.approx(K[RATE], rel=1e-6, abs=1e-9)


PLAIN = {"attitude_noise": 1e-4, "rate_noise": 1e-5, "identify": False, "rate_bias_max": 0.0}


def learned(rate, turn=None, nominal=None, **parameters):
    rate, none = np.asarray(rate, float), np.zeros((len(rate), 3))
    nominal = rate if nominal is None else nominal
    return core.learned(0.5, none if turn is None else np.asarray(turn), rate, nominal, **{**PLAIN, **parameters})


@pytest.mark.parametrize("kind", ["turn", "rate"])
def test_one_rejection_changes_nothing_a_second_takes_what_is_measured_and_a_good_sample_ends_both_each_time(
    kind,
):
    wrong = np.isin(np.arange(40), (10, 12, 13, 20, 21, 22, 30, 32))
    seen = np.outer(wrong, [0.0, 0.05, 0.0])
    found = learned(seen) if kind == "rate" else learned(0.0 * seen, seen)
    expected = np.zeros(40)
    expected[[10, 12, 20, 30, 32]], expected[[13, 21, 22]] = 1, 2
    assert found.rejected.tolist() == expected.tolist()
    assert not found.gain[expected == 1].any()
    assert (found.gain[expected == 2] == 1.0).all()
    assert ((found.gain > 0.0) & (found.gain < 1.0))[expected == 0].all()


@pytest.mark.parametrize("kind", [0, 1], ids=["turn", "rate"])
def test_innovations_that_are_alike_widen_the_model_and_others_the_noise_and_both_end_again_each_time(kind):
    """Too large for their variances for 60 s, then next to none, twice; the mean cosine follows over 2 T."""
    n, quiet = 480, np.arange(480) // 120 % 2 == 1
    size = np.array([1e-4, 1e-5])[kind] * np.where(quiet, 0.1, 3.0)
    same = np.outer(size, [0.6, 0.0, -0.8])
    turning = same * np.where(np.arange(n) % 2, -1.0, 1.0)[:, None]
    for given, cosine in ((same, 1.0), (turning, -1.0)):
        found = learned(0.0 * given, given) if kind == 0 else learned(given)
        share = 0.5 / (2.0 * found.T)
        expected = cosine * (1.0 - (1.0 - share) ** np.arange(n))
        assert found.alike[:, kind] == pytest.approx(expected, abs=1e-9)
        assert not found.alike[:, 1 - kind].any()
        assert (found.excess[:, 1 - kind] == 1.0).all()
        noise, model = found.excess[:, kind], found.excess[:, 2]
        if cosine < 0.0:
            assert (model == 1.0).all()
            assert noise[[119, 359]].min() > 1.5
            assert (noise[[239, 479]] < 0.7 * noise[[119, 359]]).all()
        else:
            assert model[[119, 359]].min() > 1.5
            assert (model[[239, 479]] < 0.7 * model[[119, 359]]).all()
            assert noise[[239, 359, 479]].max() == 1.0


def test_evidence_for_the_start_is_counted_never_below_zero_and_begins_anew_each_time_that_it_is_enough():
    """Half the difference of squared deviations; beyond 25 the properties are those of the start again."""
    n = 300
    rate = np.outer(np.full(n, 2e-5), [0.0, 1.0, 0.0])
    nominal = np.where((np.arange(n) < 50)[:, None], 2.0 * rate, 0.0)
    found = learned(rate, nominal=nominal, identify=True)
    assert not found.evidence[:50].any()
    ends = np.flatnonzero(np.diff(found.evidence[50:]) < 0.0)
    assert len(ends) > 2
    grows = np.diff(found.evidence[50:])
    assert grows[np.delete(np.arange(n - 51), ends)].min() > 0.0
    assert found.evidence[50:][ends + 1] == pytest.approx(0.0)
    assert found.evidence.max() <= 25.0


def test_before_the_flight_and_after_a_suspicion_each_unknown_has_the_deviation_of_the_page_and_depends_on_no_other():
    """docs/how/planned-estimates.md, Estimates and Failures. The rate's error is that of noise and bias."""
    J, gains = np.array([[2.0, 0.1, -0.2], [0.1, 3.0, 0.3], [-0.2, 0.3, 4.0]]), np.array([0.9, -1.1, 1.3])
    parameters = {"identify": True, "identify_spread": 0.2, "rod_gains0": gains, "J_B": J, "rate_bias_max": 2e-4}
    parameters |= {"disturbance_max": 3e-5, "residual_dipole_max": 0.7, "attitude_noise": 1e-4, "rate_noise": 1e-5}
    parameters |= {"dipole_max": 30.0, "rod_limits": [0.5, 0.4, 0.3]}
    before, suspected, noise = core.filter_start(**parameters)
    bias = np.full(3, (0.25 * 2e-4) ** 2)
    inertia = 0.2 * np.array([2.0, 3.0, 4.0, 1.5, 1.5, 1.5])
    variances = [np.full(3, 1e-8), 1e-10 + bias, bias, inertia**2, (0.2 * gains) ** 2]
    torques = [np.full(3, (0.25 * 3e-5) ** 2), np.full(3, (0.4 * 0.7) ** 2)]
    expected = np.diag(np.concatenate(variances + torques))
    expected[RATE, BIAS] = expected[BIAS, RATE] = -np.diag(bias)
    assert before == pytest.approx(expected, rel=1e-12)
    expected[GAINS, GAINS] = np.eye(3)
    expected[DIPOLE, DIPOLE] = (0.1 * 0.5 * 30.0) ** 2 * np.eye(3)
    assert suspected == pytest.approx(expected, rel=1e-12)
    assert noise == pytest.approx([2.5e-4**2, 0.25**2 * 2e-4**2 / 1e5, 1.0])


def test_a_rod_has_failed_that_is_known_to_be_far_from_its_gain_the_farthest_of_several():
    """docs/how/planned-estimates.md, Failures: by 0.4, known to 0.15, four deviations beyond 0.2; from `rod_gains0`."""
    before, well = np.array([0.9, -1.1, 1.2]), np.full(3, 0.02)
    known = {"rod_gains0": before, "residual_dipole_max": 0.5}

    def failed(by, sigma=well, wide=True):
        return core.failed_rod(before + by, sigma, np.zeros(3), 0.01, wide, **known)[0]

    for i in range(3):
        one = np.eye(3)[i]
        for sign in (-1.0, 1.0):
            assert failed(0.41 * sign * one) == i + 1
            assert failed(0.39 * sign * one) == 0
            assert failed(0.9 * sign * one, 0.149 * one + 0.01 * (1.0 - one)) == i + 1
            assert failed(0.9 * sign * one, 0.151 * one + 0.01 * (1.0 - one)) == 0
            assert failed(0.6 * sign * one, 0.101 * one + 0.01) == 0, "less than four deviations beyond 0.2"
        assert failed(0.9 * one, wide=False) == 0
        assert failed(0.5 + 0.4 * one) == i + 1


def test_a_rod_is_stuck_on_where_the_dipole_is_surely_larger_than_a_sound_one():
    """By four deviations of all axes together."""
    known = {"residual_dipole_max": 0.5}
    direction, sigma = np.array([0.6, 0.0, -0.8]), 0.1
    limit = 0.5 + 4.0 * sigma * np.sqrt(3.0)
    for share, wide, stuck in ((1.01, True, True), (0.99, True, False), (1.01, False, False)):
        found = core.failed_rod(np.ones(3), np.full(3, 0.1), share * limit * direction, sigma, wide, **known)
        assert found == (0, stuck)
