"""The sensor sets that scenarios extend: flown in both flavours, with the errors that their data sheets give."""

from __future__ import annotations

import numpy as np
import pytest

from orchestration import run
from tests.plant.sensors.test_loop import MEASURED, SCENARIO

SETS = sorted(path.stem for path in (SCENARIO.parent / "sensors").glob("*.yaml"))
WIRES = [
    *(f"plant.{name} -> sensors.{name}" for name in (*MEASURED, "sun_N", "sunlight")),
    "plant.dipole_mean -> sensors.dipole",
]


def flown(name: str, duration: float, flavour: str = "native"):
    """A satellite at rest in LVLH with this set, its rods at 5 A m2 for half of each second."""
    files = ("satellites/paper_50kg.yaml", f"sensors/{name}.yaml")
    start = {"dipole_cmd": [5, -5, 5], "wheel_torque_cmd": 0, "rod_period": 1.0, "rod_duty": 0.5}
    return run(
        {
            "name": name,
            "extends": [str(SCENARIO.parent / file) for file in files],
            "flavour": flavour,
            "step": 0.1,
            "duration": duration,
            "blocks": {"plant": {"fmu": "plant", "start": start}},
            "connections": WIRES,
        }
    )


@pytest.mark.parametrize("name", SETS)
def test_a_set_measures_in_both_flavours_alike(name):
    native, python = (flown(name, 5.0, flavour) for flavour in ("native", "python"))
    for signal in native.signals:
        # A rounded measurement may fall on either side of half a step.
        quantum = {"sensors.omega_B_measured": 7e-5, "sensors.b_B_measured": 1.4e-8}.get(signal, 0.0)
        off = np.abs(np.asarray(native[signal], dtype=float) - np.asarray(python[signal], dtype=float)).max()
        assert off <= 1e-9 * np.abs(native[signal]).max() + 1e-20 or off == pytest.approx(quantum, rel=0.1), signal


def test_the_tracker_has_its_arc_seconds_and_the_fine_sensor_its_tenth_of_a_degree():
    result = flown("50kg_star_tracker", 300.0)
    new = np.flatnonzero(np.diff(result["sensors.attitude_sample"])) + 1
    assert len(new) > 300
    turns = np.swapaxes(result["plant.R_NB"][new], 1, 2) @ result["sensors.R_NB_measured"][new]
    angles = np.array([[R[2, 1], R[0, 2], R[1, 0]] for R in turns]) - np.radians([10, -10, 10]) / 3600.0
    boresight = np.array([0.0, -0.6427876, -0.7660444])
    about = angles @ boresight
    across = angles - about[:, None] * boresight
    assert np.degrees(about.std()) * 3600.0 == pytest.approx(16.0, rel=0.2)
    assert np.degrees(np.sqrt((across**2).mean() * 1.5)) * 3600.0 == pytest.approx(3.2, rel=0.2)
    s_B = np.einsum("nij,ni->nj", result["plant.R_NB"], result["plant.sun_N"])
    off = np.linalg.norm(np.cross(s_B, result["sensors.sun_B_measured"]), axis=1)
    assert np.degrees(np.sqrt((off**2).mean())) == pytest.approx(0.1, rel=0.1)


def test_the_paper_s_magnetometer_is_right_only_while_the_rods_are_off():
    result = flown("paper_satellite", 100.0)
    off = result["sensors.b_B_measured"] - result["plant.b_B"]
    tenth = np.rint(10.0 * result.time).astype(int) % 10
    rods = np.array([[-4.62e-7, -4.62e-7, 0.0], [-4.62e-7, 4.62e-7, 0.0], [-9.24e-7, 9.24e-7, 1.6e-6]]) @ [
        5.0,
        -5.0,
        5.0,
    ]
    later = result.time > 1.0
    # Taken at the full second, when they have been off for half of one; and at the half second, to which they were on.
    assert np.abs(off[(tenth == 0) & later]).max() < 0.3e-6
    assert np.abs(off[(tenth == 5) & later] - rods).max() < 0.3e-6
    assert np.abs(rods).max() > 4e-6
