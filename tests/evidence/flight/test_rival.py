"""The controller from the literature: its dipole against an optimiser, its second law, and that it flies."""

import copy
import pickle

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from evidence.flight import cases, rival, schemes
from evidence.flight.rival.block import detumble
from evidence.paper import ROOT
from fmus.interface import parse
from orchestration import run

FOLDER = ROOT / "evidence" / "flight" / "rival"
STARTS = {
    v.name: v.start for v in parse((FOLDER / "interface.toml").read_text("utf-8"), "interface.toml").of("parameter")
}
P = rival.Parameters(**{k: np.array(v) if isinstance(v, list) else v for k, v in STARTS.items()})
R, V = np.array([6.971e6, 0.0, 0.0]), np.array([0.0, -1052.4, 7488.1])


def inputs(**given):
    usual = {"R_NB": np.eye(3), "omega_B": np.zeros(3), "r_N": R, "v_N": V, "b_B": np.array([2e-5, 1e-5, -2e-5])}
    return rival.Inputs(**(usual | given))


def test_the_dipole_is_that_of_the_least_momentum_after_two_steps():
    """Witness: BFGS on the cost, without the look ahead, so that the second field is the first."""
    p = rival.Parameters(**{**vars(P), "look_ahead": 0.0, "detumble_gain": 1e-3})
    u = inputs(omega_B=np.array([0.03, -0.05, 0.02]))
    b, h = u.b_B / np.linalg.norm(u.b_B), p.J_B @ u.omega_B

    def cost(m):
        first = h - np.cross(b, m[:3])
        second = first - np.cross(b, m[3:])
        return first @ first + p.alpha * second @ second + m @ m

    best = minimize(cost, np.zeros(6), tol=1e-12).x[:3]
    np.testing.assert_allclose(detumble(u, p) / (p.dipole_max * 1e-3), best, atol=1e-6)


def test_the_rods_take_momentum_out_and_keep_within_their_limit():
    u = inputs(omega_B=np.array([0.03, -0.05, 0.02]))
    found = rival.outputs(rival.start(P, u), u, P)
    assert found.detumbling
    assert found.tau_cmd_B @ (P.J_B @ u.omega_B) < 0.0
    assert np.abs(detumble(u, P)).max() <= P.dipole_max


def test_a_field_that_turns_ahead_changes_the_dipole():
    u = inputs(omega_B=np.array([0.03, -0.05, 0.02]))
    now, later = (rival.Parameters(**{**vars(P), "detumble_gain": 5.0, "look_ahead": t}) for t in (0.0, 600.0))
    assert np.abs(detumble(u, later) - detumble(u, now)).max() > 0.02 * P.dipole_max


@pytest.mark.parametrize("degrees", [5.0, 170.0])
def test_once_slow_it_turns_towards_lvlh(degrees):
    h = np.cross(R, V)
    z, y = -R / np.linalg.norm(R), -h / np.linalg.norm(h)
    lvlh = np.array((np.cross(y, z), y, z)).T
    turned = Rotation.from_rotvec(np.radians(degrees) * np.eye(3)[0]).as_matrix()
    u = inputs(R_NB=lvlh @ turned, omega_B=turned.T @ lvlh.T @ h / (R @ R))
    found = rival.outputs(rival.State(0.0, False), u, P)
    assert not found.detumbling
    assert found.tau_cmd_B[0] < -0.05 * P.K


def test_it_flies_in_the_place_of_the_planned_controller_and_slows_the_tumble():
    group = cases.tumbles("rival", 7, 1, scheme="literature")
    data = schemes.change(copy.deepcopy(group.scenario), {**group.drawn()[0], "plant.omega_B0": [0.03, -0.05, 0.02]})
    result = run(
        {**data, "duration": 100.0, "record": {"interval": 100.0, "signals": ["plant.omega_B", "plant.dipole"]}}
    )
    first, last = np.linalg.norm(result["plant.omega_B"], axis=1)
    assert last < 0.9 * first


def test_a_campaign_with_a_foreign_fmu_in_our_blocks_place_reaches_its_workers():
    group = cases.tumbles("rival", 7, 2, scheme="literature")
    job = pickle.loads(pickle.dumps(group.case.job))
    first = job.draws.texts(job.draws.at(job.design.points(range(2)).tolist()[0]))
    assert first["plant.omega_B0"] == pytest.approx(group.drawn()[0]["plant.omega_B0"])
