"""The linear model of a loop of mocks, beside the matrices of which it was made."""

import numpy as np
import pytest
from scipy.io import loadmat

from orchestration.margins.linear import realized
from orchestration.margins.measure import measure

from .loops import STEP, rig
from .test_measure import GAINS, A, lagging


@pytest.fixture(scope="module")
def model():
    return realized(measure(rig(lagging)))


def test_the_open_loop_has_the_poles_of_the_plant(model):
    assert len(model.A) == 3
    poles = np.sort_complex(np.linalg.eigvals(model.A))
    np.testing.assert_allclose(poles, np.sort_complex(np.linalg.eigvals(A)), atol=0.02)  # two of them are 1
    assert model.error < 0.005
    assert model.verdict.startswith("3 states are seen")


def test_the_object_of_python_control_has_names_and_the_closed_loop(model):
    system = model.system()
    assert (system.input_labels, system.dt) == (["plant_u"], STEP)
    closed = np.linalg.eigvals(model.A - model.B @ np.linalg.inv(np.eye(1) + model.D) @ model.C)
    B = np.array([[0], [0], [0.2]])
    exact = np.linalg.eigvals(A - B @ GAINS[None, :])
    np.testing.assert_allclose(np.sort_complex(closed), np.sort_complex(exact), atol=0.003)


@pytest.mark.parametrize("suffix", ["npz", "mat"])
def test_files_have_matrices_and_names(model, tmp_path, suffix):
    path = tmp_path / f"model.{suffix}"
    model.save(path)
    read = np.load(path) if suffix == "npz" else loadmat(path)
    np.testing.assert_array_equal(read["A"], model.A)
    assert "plant.u" in str(read["inputs"])
    assert float(np.squeeze(read["step"])) == STEP
