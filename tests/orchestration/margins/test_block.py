"""Linear models of single blocks, beside the matrices of which they are made, and the derivatives that an FMU gives."""

import json

import numpy as np
import pytest
from scipy.io import loadmat

from orchestration.margins.block import linearized
from orchestration.session.open import open_scenario
from orchestration.session.read import load
from orchestration.session.session import Session
from tests.commands import orchestrate
from tests.native.test_fmi3 import ROOT, three

from .loops import STEP, static, toy

LAGGING = """\
class Lagging:
    def __init__(self):
        self.x = 0.0

    def step(self, inputs, parameters, t, h):
        self.x = 0.7 * self.x - 0.2 * inputs.omega_B[0]
        return {"tau_cmd_B": [self.x, 0.0, 0.0]}
"""
TORQUE = "controller.tau_cmd_B[1]"


@pytest.fixture
def loop(tmp_path):
    return toy(tmp_path, LAGGING)


def test_an_integrator_has_its_matrices_with_its_output_as_the_state(loop):
    options = ("--model", "plant", "--state", "plant.omega_B", "--window", "1 s")
    result = orchestrate("margins", loop, *options, "--out", loop.parent / "out")
    assert result.exit_code == 0, result.output
    for read in (np.load(loop.parent / "out" / "model.npz"), loadmat(loop.parent / "out" / "model.mat")):
        states = [str(np.squeeze(name).item()) for name in np.ravel(read["states"])]
        outputs = [str(np.squeeze(name).item()) for name in np.ravel(read["outputs"])]
        assert states == [f"plant.omega_B[{i}]" for i in (1, 2, 3)]
        assert "plant.wheel_torque_cmd" in str(read["inputs"])
        at = outputs.index("plant.omega_B[1]")
        np.testing.assert_allclose([read["A"][0, 0], read["B"][0, 0], read["C"][at, 0]], [1.0, STEP, 1.0], atol=1e-7)
        np.testing.assert_allclose(read["D"], 0.0, atol=1e-7)


def test_a_law_with_a_hidden_state_has_its_pole_and_its_direct_part(loop):
    """y = -0.2 u z/(z - 0.7): the pole 0.7, D = -0.2, and C (z - A)^-1 B at z = 1 is -0.2/0.3 + 0.2."""
    options = ("--model", "controller", "--window", "2 s", "--json", "--out", loop.parent / "out")
    result = orchestrate("margins", loop, *options)
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    A, B, C, D = (np.array(found[name]) for name in "ABCD")
    y, u = found["outputs"].index(TORQUE), found["inputs"].index("controller.omega_B[1]")
    gain = (C[y] @ np.linalg.solve(np.eye(len(A)) - A, B[:, u])).item()
    np.testing.assert_allclose([A.item(), D[y, u], gain], [0.7, -0.2, 0.2 - 2 / 3], rtol=1e-5)
    assert (found["states"], found["error"] < 1e-5, found["refused"]) == (["x1"], True, None)


def test_the_closed_loop_has_its_matrices_with_the_rate_as_the_state(tmp_path):
    """x+ = x + h (d - g x)"""
    loop, options = toy(tmp_path, static("-g * w")), ("--state", "plant.omega_B", "--out", tmp_path / "out")
    result = orchestrate("margins", loop, "--at", "plant.wheel_torque_cmd", *options)
    assert result.exit_code == 0, result.output
    assert "Closed loop from sample to sample, |eigenvalues| 0.92" in result.output
    for read in (np.load(tmp_path / "out" / "loop.npz"), loadmat(tmp_path / "out" / "loop.mat")):
        np.testing.assert_allclose([read["A"][0, 0], read["B"][0, 0], read["C"][0, 0]], [0.92, STEP, 1.0], atol=1e-6)
        assert "plant.omega_B[1]" in str(read["states"])
        assert "plant.wheel_torque_cmd" in str(read["inputs"])


def test_a_closed_loop_whose_state_is_not_seen_whole_has_no_model(tmp_path):
    loop = toy(tmp_path, LAGGING.replace("0.7", "0.95").replace("0.2", "0.05"))
    options = ("--at", "plant.wheel_torque_cmd", "--state", "plant.omega_B", "--json", "--out", loop.parent / "out")
    said = json.loads(orchestrate("margins", loop, *options).stdout)
    assert said["together"] is not None
    assert said["loop"]["error"] > 0.05
    assert said["loop"]["refused"] == said["loop"]["verdict"]
    assert not (loop.parent / "out" / "loop.npz").exists()


def test_an_output_that_switches_is_left_out(tmp_path):
    loop = toy(tmp_path, static("-0.5 * abs(w - 1.0)"))
    result = orchestrate("margins", loop, "--model", "controller", "--json", "--out", tmp_path / "out")
    said = json.loads(result.stdout)
    assert TORQUE not in said["outputs"]
    assert "controller.tau_cmd_B[1] is not linear here" in " ".join(said["notes"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--model", "plont"), "--model plont: there is no block 'plont'; did you mean 'plant'?"),
        (("--model", "plant", "--state", "controller.tau_cmd_B"), "expected states of plant, found one of controller"),
        (("--model", "plant", "--state", "plant.omiga_B"), "--state plant.omiga_B: plant has no output 'omiga_B'"),
        (("--model", "controller", "--state", "controller.tau_cmd_B"), "follows the inputs at once: it is no state"),
        ((), "expected --at BLOCK.PORT or --model BLOCK, found none"),
    ],
)
def test_a_wrong_model_is_refused(loop, options, message):
    result = orchestrate("margins", loop, *options, "--window", "1 s")
    assert (result.exit_code, message in result.output) == (2, True), result.output


def test_the_direct_part_is_by_directional_derivatives_where_an_fmu_gives_them():
    scenario = {
        "extends": str(ROOT / "scenarios" / "paper_no_singularity.yaml"),
        "name": "three",
        "isolation": "none",
        "blocks": {"allocator": {"fmu": str(three("allocator"))}},
    }
    models = {}
    for given in (scenario, {**scenario, "blocks": {}}):
        with Session(open_scenario(load(given))) as session:
            found = linearized(session, "allocator", 300, window=1.0)
        models["derivatives" in " ".join(found.notes)] = found.model
    exact, apart = models[True], models[False]
    dipoles = [i for i, name in enumerate(exact.outputs) if "dipole_cmd" in name]
    assert len(dipoles) == 3
    assert (exact.inputs, exact.outputs) == (apart.inputs, apart.outputs)
    apart_by = np.abs(apart.D - exact.D)[dipoles].max(axis=1)
    assert (apart_by < 1e-3 * np.abs(exact.D[dipoles]).max(axis=1)).all()
