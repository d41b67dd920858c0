"""Floquet multipliers of the paper's loop of FMUs, against a variational integration by SciPy.

The witness integrates the rigid body with its wheel and its first variation between the samples, under held commands;
of the law it takes the difference quotients of the reference in Python. The field and the orbit are those that the
plant reports."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import allocator
import controller
from design.loop import read
from orchestration import run
from orchestration.margins.floquet import coordinates, orbit
from orchestration.margins.inject import Rig
from orchestration.margins.site import site
from orchestration.session.open import open_scenario
from orchestration.session.session import Session

SCENARIO = "scenarios/paper_no_singularity.yaml"
RATE = 0.001084719
PORTS, STATE = ("plant.dipole_cmd", "plant.wheel_torque_cmd"), ("plant.R_NB", "plant.omega_B", "plant.h_w")
SIZE = 1e-2 * np.array([0.02, 0.02, 0.02, 1e-6])
FEWER = {(-1, -1, 1): np.array([0.3, 0.3, 0.3, 10.0])}
"""Where the wheel moves the body least: it is given more, and the rods less, since gains grow with |rate error|."""
MU = 3.986004418e14


def at(turn: tuple[int, int, int]) -> dict:
    """The equilibrium of the law at R_LVLH^T R = diag(turn)."""
    return {
        "plant.Q0": np.diag(turn).tolist(),
        "plant.omega_B0": [0.0, -RATE * turn[1], 0.0],
        "plant.drag": False,
    }


def measured(turn: tuple[int, int, int], seconds: float, segment: int = 200):
    setup = read(SCENARIO, at(turn))
    with Session(open_scenario(setup.scenario)) as session:
        plan = session.opened.plan
        rig = Rig(session, site(plan, PORTS), 0)
        size = SIZE * FEWER.get(turn, 1.0)
        return setup, orbit(rig, coordinates(plan, STATE), round(seconds / rig.period), size, segment, more=12)


def hat(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


class Witness:
    def __init__(self, setup, turn, seconds: float) -> None:
        self.p, self.loop = setup.loop.plant, setup.loop
        flown = run(SCENARIO, at(turn), duration=seconds)
        t, R = flown.time, np.asarray(flown["plant.R_NB"]).reshape(-1, 3, 3)
        self.b = CubicSpline(t, np.einsum("nij,nj->ni", R, flown["plant.b_B"]))
        self.r, self.v = (CubicSpline(t, np.asarray(flown[f"plant.{name}"])) for name in ("r_N", "v_N"))
        self.R, self.Omega, self.h = R, np.asarray(flown["plant.omega_B"]), np.asarray(flown["plant.h_w"])
        u = self._inputs(0.0, self.R[0], self.Omega[0])
        self.latched = controller.start(self.loop.controller, u)

    def _inputs(self, t, R, Omega):
        return controller.Inputs(R, Omega, self.r(t), self.v(t))

    def command(self, t, R, Omega, h):
        """Body dipole and wheel torque by the reference in Python."""
        tau = controller.outputs(self.latched, self._inputs(t, R, Omega), self.loop.controller).tau_cmd_B
        u = allocator.Inputs(tau, R.T @ self.b(t), Omega, h)
        out = allocator.outputs(allocator.start(self.loop.allocator, u), u, self.loop.allocator)
        return np.array([*(self.loop.allocator.U.T @ out.dipole_cmd), out.wheel_torque_cmd])

    def quotients(self, t, R, Omega, h):
        """d command/d (rotation, rate, wheel momentum), (4, 7)."""
        columns = []
        for i, e in enumerate((1e-7,) * 7):
            x = np.zeros(7)
            x[i] = e
            ends = []
            for sign in (1, -1):
                turned = R @ _rotation(sign * x[:3])
                ends.append(self.command(t, turned, Omega + sign * x[3:6], h + sign * x[6]))
            columns.append((ends[0] - ends[1]) / (2 * e))
        return np.array(columns).T

    def transition(self, first: int, samples: int, step: float = 0.1):
        J, axis = self.p.J_B, np.asarray(self.p.wheel_axis, float)
        inverse, X = np.linalg.inv(J), np.eye(7)
        R, Omega, h = self.R[first], self.Omega[first], float(self.h[first])
        for k in range(first, first + samples):
            c, dc = self.command(k * step, R, Omega, h), self.quotients(k * step, R, Omega, h) @ X

            def slope(t, y, c=c, dc=dc):
                R, Omega, h, X = y[:9].reshape(3, 3), y[9:12], y[12], y[13:].reshape(7, 7)
                b, r = R.T @ self.b(t), R.T @ self.r(t)
                g = 3 * MU / np.linalg.norm(r) ** 5
                angle, rate, wheel = X[:3], X[3:6], X[6:]
                moment = -np.cross(Omega, J @ Omega + h * axis) - c[3] * axis + np.cross(c[:3], b)
                moment = moment + g * np.cross(r, J @ r)
                H = J @ Omega + h * axis
                d = hat(H) @ rate - hat(Omega) @ (J @ rate + np.outer(axis, wheel)) - np.outer(axis, dc[3])
                d = d - hat(b) @ dc[:3] + hat(c[:3]) @ hat(b) @ angle
                d = d + g * (hat(r) @ J - hat(J @ r)) @ hat(r) @ angle
                dX = np.vstack([-hat(Omega) @ angle + rate, inverse @ d, dc[3:4]])
                return np.concatenate([(R @ hat(Omega)).ravel(), inverse @ moment, [c[3]], dX.ravel()])

            y = np.concatenate([R.ravel(), Omega, [h], X.ravel()])
            y = solve_ivp(slope, (k * step, (k + 1) * step), y, "DOP853", rtol=1e-11, atol=1e-16).y[:, -1]
            R, Omega, h, X = y[:9].reshape(3, 3), y[9:12], float(y[12]), y[13:].reshape(7, 7)
        return X


def _rotation(v):
    K, angle = hat(v), np.linalg.norm(v)
    return np.eye(3) + np.sinc(angle / np.pi) * K + (1 - np.cos(angle)) / max(angle**2, 1e-300) * K @ K


@pytest.mark.parametrize(
    ("turn", "unstable"),
    [
        ((1, 1, 1), 0),
        ((-1, 1, -1), 2),
        pytest.param((1, -1, -1), 3, marks=pytest.mark.thorough),
        pytest.param((-1, -1, 1), 1, marks=pytest.mark.thorough),
    ],
)
def test_multipliers_of_the_four_equilibria_are_those_of_a_variational_integration(turn, unstable):
    setup, found = measured(turn, 10.0, segment=100)
    assert found.rest < 1e-5
    exact = np.linalg.eigvals(Witness(setup, turn, 45.0).transition(300, 100))
    multipliers = np.exp(found.logs)
    for one in exact:
        assert np.abs(multipliers - one).min() < 1e-6
    # The wheel's momentum is kept, and its multiplier is 1 but for the turn of the field.
    assert (np.abs(multipliers) > 1.01).sum() == unstable
    assert (np.abs(np.abs(multipliers) - 1) < 0.005).sum() == 1
