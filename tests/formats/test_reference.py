"""An attitude ephemeris as a moving reference: against a coning motion in closed form, and flown."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from formats.convert import convert, reference
from formats.recorded import Recorded
from orchestration import run
from orchestration.errors import InputError
from orchestration.session.read import load

SCENARIO = Path("scenarios/paper_no_singularity.yaml")
EPOCH = "2009-08-10T00:00:00Z"
CONE, ROUND, SPIN = 0.4, 0.02, 0.05
"""A body that spins at SPIN rad/s about its Z axis, which goes round at ROUND rad/s on a cone of CONE rad."""


def coning(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """R = Rz(ROUND t) Rx(CONE) Rz(SPIN t), its rate in the body's axes, and the derivative of that."""
    turns = (Rotation.from_euler("z", np.asarray(angle).reshape(-1, 1)) for angle in (ROUND * t, SPIN * t))
    first, last = turns
    s, c = ROUND * np.sin(CONE) * np.sin(SPIN * t), ROUND * np.sin(CONE) * np.cos(SPIN * t)
    rate = np.column_stack([s, c, np.full(len(t), SPIN + ROUND * np.cos(CONE))])
    change = SPIN * np.column_stack([c, -s, np.zeros(len(t))])
    return (first * Rotation.from_euler("x", CONE) * last).as_matrix(), rate, change


def ephemeris(folder: Path, t: np.ndarray) -> Path:
    signals = {"plant.R_NB": coning(t)[0]}
    data = Recorded("coning", t, signals, parameters={"plant": {"epoch": EPOCH}})
    (path,) = convert(data, "aem", folder / "coning.aem", frame="N")
    return path


def test_the_controller_gets_attitude_rate_and_acceleration_of_the_ephemeris(tmp_path: Path) -> None:
    path = ephemeris(tmp_path, np.arange(-2.0, 20.1, 0.5))
    rows = reference(path, SCENARIO, tmp_path / "followed.yaml", "plant.epoch")
    result = run(tmp_path / "followed.yaml")
    assert (rows, result.time[-1]) == (201, 20.0)
    R, rate, change = coning(result.time)
    inner = slice(30, -30)  # a spline's ends know less
    np.testing.assert_allclose(result["reference.R_ref"][inner], R[inner], atol=5e-9)
    np.testing.assert_allclose(result["reference.Omega_ref"][inner], rate[inner], atol=1e-7)
    np.testing.assert_allclose(result["reference.dOmega_ref"][inner], change[inner], atol=1e-6)
    apart = Rotation.from_matrix(R.transpose(0, 2, 1) @ result["plant.R_NB"]).magnitude()
    np.testing.assert_allclose(result["controller.attitude_error"][inner], apart[inner], atol=1e-7)


def test_what_fed_a_reference_before_feeds_it_no_more(tmp_path: Path) -> None:
    path = ephemeris(tmp_path, np.arange(0.0, 30.0))
    reference(path, Path("scenarios/track_ground_station.yaml"), tmp_path / "followed.yaml", EPOCH)
    connections = load(tmp_path / "followed.yaml").source.data["connections"]
    fed = {text.partition("->")[2].strip(): text.partition("->")[0].strip() for text in connections}
    assert fed["controller.R_ref"] == fed["judge.R_d"] == "reference.R_ref"
    assert fed["controller.dOmega_ref"] == "reference.dOmega_ref"
    targets = [text.partition("->")[2].partition("[")[0].strip() for text in connections]
    assert [targets.count(name) for name in ("controller.R_ref", "judge.R_d", "judge.Omega_d")] == [1, 1, 1]
    assert not {"controller.t_ahead", "controller.turn_ahead", "controller.Omega_ahead"} & set(targets)
    assert fed["supervisor.R_NB"] == "sensors.R_NB_measured"


@pytest.mark.parametrize(
    ("times", "scenario", "expected"),
    [
        (np.arange(5.0, 30.0), SCENARIO, "three attitudes or more, from t = 0 or before"),
        (np.arange(0.0, 2.0), SCENARIO, "three attitudes or more, from t = 0 or before"),
    ],
)
def test_an_ephemeris_that_does_not_cover_the_start_is_refused(
    times: np.ndarray, scenario: Path, expected: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=expected):
        reference(ephemeris(tmp_path, times), scenario, tmp_path / "followed.yaml", "plant.epoch")
