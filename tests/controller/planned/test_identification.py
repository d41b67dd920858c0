"""What the filter learns of the satellite: full inertia, rods' gains, bias of the rate, friction of the wheel, with its
deviations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.native.driver import Instance

from . import core
from .block import BLOCK, E1, RODS, J, feed, lvlh, run, tumbling
from .truth import DAYS, Truth, orbit

DT, SAMPLES = 0.5, 160
DRAWS = 24
RATE_NOISE, ATTITUDE_NOISE = 1e-5, 1.75e-4
UPPER = np.array([(0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)])


class Tumbles:
    """Bodies (n,) that tumble, flown side by side by Runge and Kutta's method, with commands of their own drawing."""

    def __init__(self, seed, n, friction=(0.0, 0.0)):
        rng = np.random.default_rng(seed)
        self.rng, self.n, self.coefficients = rng, n, friction
        products = rng.normal(0.0, 0.04 * J.trace() / 3.0, (n, 3))
        self.J = np.array([np.diag(d) for d in np.diag(J) * (1.0 + 0.08 * rng.normal(size=(n, 3)))])
        for (i, j), p in zip(UPPER[3:], products.T, strict=True):
            self.J[:, i, j] = self.J[:, j, i] = p
        self.gains = 1.0 + 0.08 * rng.normal(size=(n, 3))
        self.bias = 1e-4 * rng.normal(size=(n, 3))
        self.R = Rotation.random(n, random_state=rng).as_matrix()
        self.Omega = 0.08 * np.array([v / np.linalg.norm(v) for v in rng.normal(size=(n, 3))])
        self.h_w, self.t = np.full(n, 5e-3), 0.0
        self.command()

    def command(self):
        """New commands: rods (n, 3) and motor (n,)."""
        self.u = self.rng.uniform(-1, 1, (self.n, 3))
        dl = self.rng.uniform(-1e-3, 1e-3, self.n)
        self.dl = np.where(np.abs(self.h_w + 10.0 * dl - 0.012) < 0.011, dl, -dl)  # which never comes to rest

    def friction(self):
        """What the motor gives against it in the sample that has ended, N m (n,)."""
        middle = self.h_w - 0.5 * DT * self.dl
        return self.coefficients[0] * np.sign(middle) + self.coefficients[1] * middle

    def fly(self, steps=4):
        """On by DT."""
        r = orbit(self.t + 0.5 * DT)[0]
        B_N = core.field_at("igrf14", DAYS, 10, r, self.t + 0.5 * DT)
        m_B = (self.u * self.gains) @ RODS
        unit, square = r / np.linalg.norm(r), 3.0 * core.MU / np.linalg.norm(r) ** 3

        def rate(R, w, l):  # noqa: E741
            rho = unit @ R
            tau = np.cross(m_B, B_N @ R) + square * np.cross(rho, np.einsum("nij,nj->ni", self.J, rho))
            tau[:, 0] -= self.dl
            H = np.einsum("nij,nj->ni", self.J, w)
            H[:, 0] += l
            return np.linalg.solve(self.J, (tau + np.cross(H, w))[..., None])[..., 0]

        h = DT / steps
        for _ in range(steps):

            def turned(w):
                return self.R @ Rotation.from_rotvec(0.5 * h * w).as_matrix()

            a = rate(self.R, self.Omega, self.h_w)
            b = rate(turned(self.Omega), self.Omega + 0.5 * h * a, self.h_w + 0.5 * h * self.dl)
            c = rate(turned(self.Omega + 0.25 * h * a), self.Omega + 0.5 * h * b, self.h_w + 0.5 * h * self.dl)
            middle = self.Omega + 0.25 * h * (a + b)
            self.R = self.R @ Rotation.from_rotvec(h * middle).as_matrix()
            self.Omega = self.Omega + h * c
            self.h_w = self.h_w + h * self.dl
        self.t += DT


def measured(truth):
    """What the sensors show of all bodies, and the commands of the sample that ends."""
    turn = Rotation.from_rotvec(ATTITUDE_NOISE * truth.rng.normal(size=(truth.n, 3))).as_matrix()
    r, v = orbit(truth.t)
    return {
        "R_NB": truth.R @ turn,
        "omega_B": truth.Omega + truth.bias + RATE_NOISE * truth.rng.normal(size=(truth.n, 3)),
        "b_B": core.field_at("igrf14", DAYS, 10, r, truth.t) @ truth.R,
        "h_w": truth.h_w.copy(),
        "u_applied": np.column_stack((25.0 * truth.u, truth.dl + truth.friction())),
        "r_N": np.tile(r, (truth.n, 1)),
        "v_N": np.tile(v, (truth.n, 1)),
    }


def flown(truth, spoil=lambda i, sample: sample, samples=SAMPLES, **changes):
    """What was measured, sample by sample, and the last outputs (n) of controllers that looked at it, spoiled."""
    found, record = [], [measured(truth)]
    for i in range(samples):
        if i % 20 == 0:
            truth.command()
        truth.fly()
        record.append(spoil(i, measured(truth)))
    for k in range(truth.n):
        with Instance(BLOCK) as it:
            feed(it, {"rate_noise": RATE_NOISE, "attitude_noise": ATTITUDE_NOISE, **changes})
            for i, sample in enumerate(record):
                feed(it, {name: values[k] for name, values in sample.items()})
                it.initialize() if i == 0 else it.step((i - 1) * DT, DT)
            found.append(it.outputs())
    return record, found


@pytest.fixture(scope="module")
def tumbles():
    truth = Tumbles(1, DRAWS)
    return truth, *flown(truth)


def estimated(found, name):
    return np.array([y[name] for y in found])


def test_the_full_inertia_lies_within_its_stated_deviations(tumbles):
    """Of each element, the mean square of the errors over their deviations: 1 for a filter that knows all noise; this
    one counts on errors of its model that are not there."""
    truth, _, found = tumbles
    i, j = UPPER.T
    errors, sigmas = (estimated(found, name)[:, i, j] for name in ("J_estimate_B", "J_estimate_sigma_B"))
    squares = ((errors - truth.J[:, i, j]) / sigmas) ** 2
    assert squares.mean() < 1.0
    assert squares.max() < 9.0
    before = estimated(flown(Tumbles(2, 1), identify_spread=0.0)[1], "J_estimate_sigma_B")
    assert not before.any()
    assert (sigmas[:, :3] < 0.5 * 0.08 * np.diag(J)).all()  # half of what they were before
    assert sigmas[:, 3:].mean() < 0.4 * 0.04 * J.trace() / 3.0


def test_the_inertia_is_that_of_least_squares_on_the_balance_of_momentum(tumbles):
    """NumPy solves for J and the rods' gains at once, from R (J Omega + l e1) at the ends of windows of 5 s, in N."""
    truth, record, found = tumbles
    i, j = UPPER.T
    for k, y in enumerate(found[:6]):
        R, b = (np.array([s[name][k] for s in record]) for name in ("R_NB", "b_B"))
        Omega = np.array([s["omega_B"][k] for s in record]) - truth.bias[k]
        x, e, z = Omega.T, np.zeros(len(Omega)), record
        columns = np.array(
            [[x[0], e, e], [e, x[1], e], [e, e, x[2]], [e, x[2], x[1]], [x[2], e, x[0]], [x[1], x[0], e]]
        )
        momentum = np.einsum("tij,cjt->tic", R, columns)
        wheel = R[:, :, 0] * np.array([s["h_w"][k] for s in z])[:, None]
        u = np.array([s["u_applied"][k][:3] for s in record]) / 25.0
        torque = np.zeros((len(R), 3, 3))
        for m in range(3):
            ends = np.einsum("tij,tj->ti", R, np.cross(RODS[m], b))
            torque[1:, :, m] = np.cumsum(0.5 * DT * u[1:, m, None] * (ends[1:] + ends[:-1]), axis=0)
        ends = slice(0, None, 10)
        rows = np.concatenate((np.diff(momentum[ends], axis=0), -np.diff(torque[ends], axis=0)), axis=2)
        known = -np.diff(wheel[ends], axis=0)
        solved = np.linalg.lstsq(rows.reshape(-1, 9), known.ravel(), rcond=None)[0][:6]
        assert (np.abs(y["J_estimate_B"][i, j] - solved) < 2.0 * y["J_estimate_sigma_B"][i, j]).all()


def test_each_rod_s_gain_and_the_bias_of_the_rate_are_found(tumbles):
    truth, _, found = tumbles
    assert estimated(found, "rod_gains_estimate") == pytest.approx(truth.gains, abs=0.1)
    errors = estimated(found, "rod_gains_estimate") - truth.gains
    assert np.sqrt((errors**2).mean()) < 0.3 * np.sqrt(((truth.gains - 1.0) ** 2).mean())
    assert estimated(found, "rod_gain_estimate") == pytest.approx(estimated(found, "rod_gains_estimate").mean(axis=1))
    assert estimated(found, "rate_bias_estimate_B") == pytest.approx(truth.bias, abs=6e-6)


def test_the_wheel_s_friction_is_found_and_given_beside_the_wheel_s_torque():
    truth = Tumbles(3, 2, friction=(3e-4, 2e-3))
    _, found = flown(truth)
    assert estimated(found, "wheel_friction_estimate") == pytest.approx(3e-4, rel=0.05)
    assert estimated(found, "wheel_decay_estimate") == pytest.approx(2e-3, rel=0.2)
    without = flown(Tumbles(3, 2))[1]
    assert estimated(without, "wheel_friction_estimate") == pytest.approx(0.0, abs=1e-6)


def test_a_bias_is_not_estimated_where_an_estimator_has_removed_it():
    _, found = flown(Tumbles(4, 1), rate_bias_max=0.0)
    assert not estimated(found, "rate_bias_estimate_B").any()


def test_noise_that_is_stated_in_flight_counts_from_then_on():
    """The parameters are tunable: stated after the start, the estimate is nearly that of noise known before it."""
    truth = Tumbles(8, 1)
    record = flown(truth, samples=300)[0]
    biases = []
    for before, after in [(True, False), (False, True), (False, False)]:
        noise = {"rate_noise": RATE_NOISE, "attitude_noise": ATTITUDE_NOISE}
        with Instance(BLOCK) as it:
            feed(it, noise if before else {"rate_noise": 1e-3, "attitude_noise": 1e-2})
            for i, sample in enumerate(record):
                feed(it, {name: values[0] for name, values in sample.items()})
                it.initialize() if i == 0 else it.step((i - 1) * DT, DT)
                feed(it, noise if after else {})
            biases.append(np.array(it.outputs()["rate_bias_estimate_B"]))
    known, told, never = biases
    assert np.linalg.norm(told - known) < 0.1 * np.linalg.norm(never - known)


# ------------------------------------------------------------------------------------------- one satellite


def tumble(J_true, gain, seconds, seed=0, rate_noise=0.0, rods=True, wheel=True, d_B=(0.0, 0.0, 0.0), glitch=None):
    """The last outputs of a controller that looks at a tumbling satellite with commands that are not its own."""
    rng = np.random.default_rng(seed)
    truth = Truth(
        J_true,
        gain * RODS,
        np.array(d_B),
        Rotation.random(random_state=seed).as_matrix(),
        np.array([0.05, -0.04, 0.045]),
    )
    with Instance(BLOCK) as it:
        feed(it, {**truth.measured(), "rate_noise": max(rate_noise, 1e-6)})
        it.initialize()
        for i in range(int(2 * seconds)):
            if i % 20 == 0:
                u, dl = rng.uniform(-1, 1, 3) * rods, rng.uniform(-1e-3, 1e-3) * wheel
                dl = dl if abs(truth.h_w + 10 * dl) < 0.02 else -dl
            truth.fly(u, dl, 0.5)
            measured = truth.measured(rng, rate_noise)
            if i == glitch:
                measured["omega_B"] = measured["omega_B"] + np.array([0.2, -0.1, 0.3])
            feed(it, {**measured, "u_applied": [*(25.0 * u), dl]})
            it.step(0.5 * i, 0.5)
        return it.outputs()


SCALES = np.diag([1.06, 0.95, 1.04])


def test_inertia_and_rod_gain_are_found_in_a_tumble():
    found = tumble(J @ SCALES, 0.9, 400, rate_noise=1e-5)
    inertia = np.diag(found["J_estimate_B"]) / np.diag(J)
    assert inertia / inertia.mean() == pytest.approx(np.diag(SCALES) / np.diag(SCALES).mean(), abs=0.01)
    assert inertia == pytest.approx(np.diag(SCALES), abs=0.03)
    assert found["rod_gain_estimate"] == pytest.approx(0.9, abs=0.03)


def held(d_B, own, samples, **changes):
    """Outputs after samples near LVLH, and the field there, of a satellite with a torque and a dipole of its own."""
    rng = np.random.default_rng(1)
    truth = Truth(J, RODS, d_B, lvlh(0.0), np.array([0.0, -1.08e-3, 0.0]), own_dipole=own)
    with Instance(BLOCK) as it:
        feed(it, {**truth.measured(), **changes})
        it.initialize()
        for i in range(samples):
            # The test holds the satellite by what it knows itself: the block is only asked for its estimates.
            if i % 10 == 0:
                Q = lvlh(truth.t).T @ truth.R
                error = Rotation.from_matrix(Q).as_rotvec()
                rate = truth.Omega - Q.T @ np.array([0.0, -1.08e-3, 0.0])
                B = truth.R.T @ truth.field_N(truth.t)
                wanted = -2e-4 * error - 0.03 * rate - d_B - np.cross(own, B)
                A = np.column_stack((np.cross(RODS, B).T, -E1))
                u = np.linalg.pinv(A * [1.0, 1.0, 1.0, 0.03]) @ wanted
                u, dl = np.clip(u[:3], -1, 1), float(np.clip(0.03 * u[3], -1e-3, 1e-3))
            truth.fly(u, dl, 0.5)
            feed(it, {**truth.measured(rng, 1e-6), "u_applied": [*(25.0 * u), dl]})
            it.step(0.5 * i, 0.5)
        return it.outputs(), truth.R.T @ truth.field_N(truth.t)


def test_a_torque_of_the_satellites_own_is_found_whatever_it_is_of():
    """Steady torque and dipole together: which is which takes longer than this third of an orbit, their sum does
    not."""
    d_B, own = np.array([6e-6, -8e-6, 5e-6]), np.array([0.10, -0.15, 0.2])
    y, B = held(d_B, own, 4000)
    torque = d_B + np.cross(own, B)
    found = y["disturbance_B"] + np.cross(y["residual_dipole_estimate_B"], B)
    assert np.linalg.norm(found - torque) < 0.25 * np.linalg.norm(torque)


def test_a_dipole_of_the_satellites_own_is_found_slowly_where_there_is_no_other_torque():
    """Its torque shows little in a window of 5 s, so it takes orbits; after 1000 s a part of it, and of no other, is
    known."""
    own = np.array([0.10, -0.15, 0.2])
    y, _ = held(np.zeros(3), own, 2000, disturbance_max=0.0)
    found = y["residual_dipole_estimate_B"]
    assert 0.2 < found @ own / (own @ own) < 1.1
    assert np.linalg.norm(found - own) < 0.8 * np.linalg.norm(own)


def test_a_model_that_is_right_stays_right():
    found = tumble(J, 1.0, 200, seed=2)
    assert np.diag(found["J_estimate_B"]) == pytest.approx(np.diag(J), rel=0.005)
    assert found["rod_gain_estimate"] == pytest.approx(1.0, abs=0.005)
    assert np.linalg.norm(found["disturbance_B"]) < 5e-6


def test_noise_alone_does_not_draw_the_inertia_down():
    """Without rods and wheel only the ratios show: the scale of all must stay, whatever the noise."""
    found = tumble(J, 1.0, 300, seed=3, rate_noise=5e-5, rods=False, wheel=False)
    inertia = np.diag(found["J_estimate_B"]) / np.diag(J)
    assert inertia.mean() == pytest.approx(1.0, abs=0.04)  # half of its deviation before the flight
    assert inertia / inertia.mean() == pytest.approx(np.ones(3), abs=0.01)


def test_ratios_are_found_without_any_torque():
    found = tumble(J @ SCALES, 1.0, 300, seed=4, rods=False, wheel=False)
    inertia = np.diag(found["J_estimate_B"]) / np.diag(J)
    assert inertia / inertia.mean() == pytest.approx(np.diag(SCALES) / np.diag(SCALES).mean(), abs=0.01)


def test_a_measurement_beyond_belief_is_not_learned_from():
    with_glitch, without_it = (tumble(J, 1.0, 60, seed=5, glitch=g) for g in (59, None))
    assert np.abs(with_glitch["J_estimate_B"] - without_it["J_estimate_B"]).max() < 0.02


def test_identification_can_be_left_out():
    with Instance(BLOCK) as it:
        feed(it, {**tumbling(0.0), "identify": False})
        it.initialize()
        for y in run(it, 0.0, 60.0, inputs=tumbling):
            assert np.array_equal(y["J_estimate_B"], J)
            assert y["rod_gain_estimate"] == 1.0
