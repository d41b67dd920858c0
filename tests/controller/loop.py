"""A rigid body under the block's torque, integrated by SciPy: the witness for the law.

The body is written with quaternions and inertial vectors, sharing nothing with the law. Sizes are chosen so that
every term of [8] is of the order of the others: an eccentric orbit of 10 m about a small mass turns LVLH at 1 rad/s.
"""

from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import controller
from tests.blocks import parameters
from tests.controller.planned.motion import cross

MU = 1000.0
J = np.array([[2.9, 0.21, -0.34], [0.21, 3.6, 0.17], [-0.34, 0.17, 4.1]])
L0 = np.array([[2.2, 0.3, -0.2], [0.3, 1.7, 0.25], [-0.2, 0.25, 2.6]])
K0 = np.array([2.0, 3.1, 4.7])
KAPPA, LAMBDA = 1.3, 0.8
R_D0 = Rotation.from_rotvec([0.5, -0.8, 1.9])
RATE_D0 = np.array([0.5, -0.7, 0.4])
ORBIT = np.array([7.0, -5.0, 5.0, 4.2, 8.4, 4.1])


def law(**changes):
    """Parameters with constant gains, none equal to another."""
    values = {
        "J_B": J,
        "L0": L0,
        "K0": K0,
        "kappa0": KAPPA,
        "lambda0": LAMBDA,
        "gain_schedule": "constant",
        "gravitational_parameter": MU,
        "phi_scale": 3.0,
        "R_d0": R_D0.as_matrix(),
        "Omega_d0": RATE_D0,
    }
    given = changes.get("reference") == "given"
    p = parameters("controller", **(values | changes | ({"reference": "inertial"} if given else {})))
    controller.check(p)
    return replace(p, reference="given") if given else p  # by the ports, so that the block does not look at it


def given(t):
    """A reference whose rate changes in size and direction: R_d as a SciPy rotation, Omega_d and dOmega_d by
    differences."""

    def attitude(t):
        return Rotation.from_rotvec([0.7 * np.sin(1.3 * t), 0.4 * t, -0.9 * np.cos(0.8 * t)]) * R_D0

    def slope(difference, h):
        return (8 * difference(h) - difference(2 * h)) / (12 * h)  # of fourth order

    def rate(t):
        return slope(lambda h: (attitude(t - h).inv() * attitude(t + h)).as_rotvec(), 5e-3)

    return attitude(t), rate(t), slope(lambda h: rate(t + h) - rate(t - h), 5e-3)


def desired(p, t, r, v):
    """Desired attitude as a SciPy rotation and its rate in inertial axes, from geometry alone."""
    if p.reference == "inertial":
        return R_D0, np.zeros(3)
    if p.reference == "given":
        R_d, Omega_d, _ = given(t)
        return R_d, R_d.apply(Omega_d)
    if p.reference == "rate":
        R_d = R_D0 * Rotation.from_rotvec(t * RATE_D0)
        return R_d, R_d.apply(RATE_D0)
    w = cross(r, v) / (r @ r)
    x, z = cross(w, r), -r
    columns = [x / np.linalg.norm(x), cross(z, x) / np.linalg.norm(cross(z, x)), z / np.linalg.norm(z)]
    return Rotation.from_matrix(np.column_stack(columns)) * R_D0, w


def block_inputs(y, p, t):
    u = controller.Inputs(R_NB=Rotation.from_quat(y[:4]).as_matrix(), omega_B=y[4:7], r_N=y[7:10], v_N=y[10:13])
    if p.reference != "given":
        return u
    R_d, Omega_d, dOmega_d = given(t)
    return replace(u, R_ref=R_d.as_matrix(), Omega_ref=Omega_d, dOmega_ref=dOmega_d)


def torque(p, t, y):
    return controller.outputs(controller.State(t, 0.0, 0.0), block_inputs(y, p, t), p).tau_cmd_B


def state(rotation, Omega):
    return np.array([*rotation.as_quat(), *Omega, *ORBIT])


def acceleration(p, t, y):
    """dOmega/dt of the body [2]: gravity gradient of the plant's own making, and the block's torque."""
    R, Omega, r = Rotation.from_quat(y[:4]), y[4:7], y[7:10]
    rho = np.linalg.norm(r)
    J_N = R.as_matrix() @ J @ R.as_matrix().T
    M_g = R.inv().apply(3 * MU / rho**5 * cross(r, J_N @ r)) if p.compensate_gravity else np.zeros(3)
    return np.linalg.solve(J, M_g + torque(p, t, y) - cross(Omega, J @ Omega))


def derivative(p, t, y):
    q, Omega, r, v = y[:4], y[4:7], y[7:10], y[10:13]
    dq = 0.5 * np.array([*(q[3] * Omega + cross(q[:3], Omega)), -q[:3] @ Omega])
    return np.array([*dq, *acceleration(p, t, y), *v, *(-MU / np.linalg.norm(r) ** 3 * r)])


def rate_error(p, t, y):
    """omega = R^T (w - w_d), from inertial vectors."""
    R = Rotation.from_quat(y[:4])
    return y[4:7] - R.inv().apply(desired(p, t, y[7:10], y[10:13])[1])


PHI = {
    "linear": lambda x, s: x,
    "logarithm": lambda x, s: s * np.log(1 + x / s),
    "square_root": lambda x, s: 2 * s * (np.sqrt(1 + x / s) - 1),
}


def energy(p, t, y):
    """[11] from inertial vectors: tr(K - K Q) = sum k_i (1 - e_i . R_d^T R e_i)."""
    R_d, _ = desired(p, t, y[7:10], y[10:13])
    Q = (R_d.inv() * Rotation.from_quat(y[:4])).as_matrix()
    omega = rate_error(p, t, y)
    return 0.5 * omega @ J @ omega + PHI[p.phi](KAPPA * (K0 @ (1 - np.diag(Q))), p.phi_scale)


def fly(p, rotation, Omega, duration):
    """The solution with the dissipated energy, the integral of omega.L omega, as a last element."""

    def f(t, y):
        omega = rate_error(p, t, y)
        return [*derivative(p, t, y[:13]), LAMBDA * omega @ L0 @ omega]

    y0 = [*state(rotation, Omega), 0.0]
    return solve_ivp(f, (0.0, duration), y0, method="DOP853", rtol=1e-10, atol=1e-11, dense_output=True).sol
