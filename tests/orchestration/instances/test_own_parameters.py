"""Parameters that a law's file states: start values like others, told with file and line where they are none."""

import numpy as np
import pytest

from orchestration.errors import InputError
from orchestration.instances.own_parameters import with_own
from tests.orchestration.mocks import model, real

from .test_law import flown

LAW = """
PARAMETERS = {"gain": 0.02, "weights": [[1.0, 0, 0], [0, 2.0, 0], [0, 0, 3.0]]}


def step(inputs, parameters, t, h):
    return {"tau_cmd_B": -parameters.gain * parameters.weights @ parameters.J_B @ inputs.omega_B}
"""
J = np.diag([0.0426, 0.0608, 0.0618])


@pytest.mark.parametrize(("start", "gain"), [(None, 0.02), ({"gain": 0.05}, 0.05)])
@pytest.mark.parametrize("isolation", ["none", pytest.param("process", marks=pytest.mark.isolate)])
def test_a_law_has_its_own_parameters_with_the_scenarios_values(tmp_path, start, gain, isolation):
    result = flown(tmp_path, LAW, 1.0, start=start, isolation=isolation)
    expected = -gain * result["plant.omega_B"] @ J @ np.diag([1.0, 2.0, 3.0])
    assert result["controller.tau_cmd_B"] == pytest.approx(expected, rel=1e-12)


def test_its_values_are_in_the_manifest_and_unknown_ones_are_refused(tmp_path):
    assert flown(tmp_path, LAW, 1.0).manifest["parameters"]["controller"]["gain"] == 0.02
    with pytest.raises(InputError, match="has no parameter 'gian'; did you mean 'gain'"):
        flown(tmp_path, LAW, 1.0, start={"gian": 1.0})


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("PARAMETERS = {'u': 1.0}", r"law\.py:1: PARAMETERS: 'u' is a port of kind; expected another name"),
        ("x = 1\nPARAMETERS = {'a': x}", r"law\.py:2: PARAMETERS: expected a name with a number .* found x"),
        ("PARAMETERS = {'a': [[1], [1, 2]]}", r"law\.py:1: PARAMETERS: expected a name with a number"),
        ("PARAMETERS = {'a b': 1}", "expected a name with a number"),
        ("PARAMETERS = dict(a=1)", r"law\.py:1: PARAMETERS: expected names with numbers"),
    ],
)
def test_what_is_no_parameter_is_told_with_its_line(tmp_path, text, expected):
    (tmp_path / "law.py").write_text(text, "utf-8")
    with pytest.raises(InputError, match=expected):
        with_own(model("kind", real("u", "input"), real("y", "output")), tmp_path / "law.py")
