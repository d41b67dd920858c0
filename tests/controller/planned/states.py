"""What the tests of the motion and of the plan share: a satellite, what surrounds it and how it moves, and its motion
by SciPy."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from . import core, motion

R0, V0 = np.array([6.971e6, 0.0, 0.0]), np.array([0.0, -1052.3891, 7488.1109])
FULL_J = np.array([[2.13, 0.11, -0.07], [0.11, 3.04, 0.19], [-0.07, 0.19, 3.09]])
SATELLITE = core.Satellite(J=FULL_J, disturbance_B=np.array([1e-5, -2e-5, 3e-5]), residual_B=np.array([0.1, 0.2, -0.3]))
AHEAD = core.Ahead(R0, V0)


def turned(seed):
    return Rotation.random(random_state=seed).as_matrix()


def around(seed=0):
    rng = np.random.default_rng(seed)
    r = rng.normal(size=3)
    return core.Around(rng.normal(size=3) * 3e-5, r / np.linalg.norm(r), core.MU / 6.971e6**3)


def state(seed=0, rate=0.05):
    rng = np.random.default_rng(seed)
    return core.Motion(turned(seed), rng.normal(size=3) * rate, rng.uniform(-0.02, 0.02))


def reference(satellite, a):
    return motion.Surroundings(satellite.J, a.B_N, a.r_hat_N, a.rate_squared, satellite.disturbance_B)


def flown(satellite, a, x, u, h):
    """The motion after h by SciPy, in the quaternion of R."""
    s = reference(satellite, a)
    m_B, dl = np.asarray(u[:3]) @ satellite.rods + satellite.residual_B, u[3] * satellite.wheel_torque_max

    def rates(t, y):
        q, Omega, h_w = y[:4], y[4:7], y[7]
        R = Rotation.from_quat(q).as_matrix()
        dq = 0.5 * (Rotation.from_quat(q).as_quat() @ _right(Omega))
        return [*dq, *motion.rate_of_change(s, R, Omega, h_w, m_B, dl), dl]

    start = [*Rotation.from_matrix(x.R).as_quat(), *x.Omega, x.h_w]
    end = solve_ivp(rates, (0.0, h), start, rtol=1e-11, atol=1e-13, method="DOP853").y[:, -1]
    return core.Motion(Rotation.from_quat(end[:4]).as_matrix(), end[4:7], end[7])


def _right(w):
    """q (x, y, z, s) times (w, 0), as a row times a matrix."""
    x, y, z = w
    return np.array([[0, -z, y, -x], [z, 0, -x, -y], [-y, x, 0, -z], [x, y, z, 0]], float)


def errors(x, y):
    """Of y from x: attitude in the body axes of x, rate, wheel momentum."""
    return np.array([*Rotation.from_matrix(x.R.T @ y.R).as_rotvec(), *(y.Omega - x.Omega), y.h_w - x.h_w])


def differences(x, a, u, h, satellite=SATELLITE):
    """A (7, 7) and G (7, 4) of a stage by differences of its motion."""

    def shifted(d):
        return core.Motion(x.R @ Rotation.from_rotvec(d[:3]).as_matrix(), x.Omega + d[3:6], x.h_w + d[6])

    def motion_of(d, v):
        return core.advanced(satellite, a, shifted(d), v, h)

    size, none = 1e-5, np.zeros(7)
    A = [errors(motion_of(-size * e, u), motion_of(size * e, u)) for e in np.eye(7)]
    G = [errors(motion_of(none, u - size * e), motion_of(none, u + size * e)) for e in np.eye(4)]
    return np.column_stack(A) / (2 * size), np.column_stack(G) / (2 * size)
