"""The paper's two manoeuvres in numbers: orbit, scenarios, what is claimed, and three readings of its units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

Array = NDArray[Any]

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "results" / "evidence"
"""Where the runs of studies are kept."""
SCENARIOS = {
    "V.B": ROOT / "scenarios" / "paper_no_singularity.yaml",
    "V.C": ROOT / "scenarios" / "paper_singularity.yaml",
}
TITLES = {"V.B": "detumble to LVLH hold (paper, V.B)", "V.C": "detumble through b₁ = 0 (paper, V.C)"}
"""What the figures call the manoeuvres."""
ORBIT = 2.0 * math.pi / math.sqrt(3.986004418e14 / 6971e3**3)
"""The paper's orbital period, s."""
STEP, DURATION = 0.1, ORBIT / 15.0
"""Control step and duration of a manoeuvre, s."""
LIMITS = {"V.B": (15.0, ORBIT / 30.0), "V.C": (20.0, ORBIT / 20.0)}
"""Dipole that the paper says each rod stays within, A m2, and the time it says the manoeuvre takes, s."""
ATTITUDE_TOLERANCE, RATE_TOLERANCE = math.radians(2.0), 1e-3
"""Settled: attitude error, rad, and rate error, rad/s, below these from then to the end of the run."""

INERTIA = (2.13, 3.04, 3.09)
"""Principal moments, kg m2."""
K0, L0, MASS = 0.65, 0.9, 50.0
"""Scales of K0, N m, and L0, N m s, which are ours since the paper gives neither; the satellite's mass, kg."""


def constants(k: float = K0, l: float = L0, mass: float = MASS, spread: float = 0.1) -> dict[str, Any]:  # noqa: E741
    """Start values of inertia, gains and drag by `block.parameter`, divided by `mass`; 1 for SI units."""
    J = [[INERTIA[i] / mass if i == j else 0.0 for j in range(3)] for i in range(3)]
    return {
        "plant.J_B": J,
        "controller.J_B": J,
        "controller.K0": [k * (1.0 - spread) / mass, k / mass, k * (1.0 + spread) / mass],
        "controller.L0": [[l / mass if i == j else 0.0 for j in range(3)] for i in range(3)],
        "plant.drag_factor": 1.0 / mass,
    }


@dataclass(frozen=True)
class Reading:
    """A way to read the paper's units: start values over those of the scenarios."""

    letter: str
    text: str
    changes: Mapping[str, Any]


_UNLIMITED = {
    f"{block}.{name}": 1e9
    for block in ("plant", "allocator")
    for name in ("dipole_max", "wheel_torque_max", "wheel_momentum_max")
} | {"allocator.hold_fraction": 1.0}
READINGS = {
    "a": Reading("a", "per unit of mass: J, K₀, L₀ and drag divided by 50", {}),
    "b": Reading("b", "SI units, actuators without limits", {**constants(mass=1.0), **_UNLIMITED}),
    "c": Reading("c", "SI units, the real limits", constants(mass=1.0)),
}


def node(degrees: float) -> dict[str, Any]:
    """The start value of a longitude of the ascending node, deg east."""
    return {"plant.node_longitude": math.radians(degrees)}
