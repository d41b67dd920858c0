"""The figures of docs/use/sensors.md: sunlight over an orbit, and the Allan deviation of the gyros of two sensor
sets."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from orchestration import Result, load, run
from orchestration.quantities import parse_unit, value_in

from . import plots
from .paper import Array

ROOT = Path(__file__).parents[1]
FIGURES = ROOT / "docs" / "figures"
GYROS = {"cubesat": ("CubeSat: BMG160", plots.RED), "paper_satellite": ("paper's satellite: STIM210", plots.BLUE)}
RECORD = 40.0 * 3600.0
"""s, of the gyros at rest."""
TRUTH = ("R_NB", "omega_B", "r_N", "v_N", "b_B", "h_w", "sun_N", "sunlight")
DEG_PER_HOUR = np.pi / 180.0 / 3600.0


def make() -> str:
    """Flies the runs and draws the figures; returns the names of the files."""
    figures = {"sensors-eclipse": _eclipse(_orbit()), "sensors-allan": _allan()}
    plots.save(figures, FIGURES)
    return ", ".join(f"docs/figures/{name}.png" for name in figures)


def _extends(*files: str) -> list[str]:
    return [str(ROOT / "scenarios" / f"{file}.yaml") for file in files]


def _orbit() -> Result:
    """The paper's orbit at rest in LVLH, with the sun sensors of the CubeSat."""
    return run(
        {
            "name": "eclipse",
            "extends": _extends("satellites/paper_50kg", "sensors/cubesat"),
            "step": 0.5,
            "duration": 5800.0,
            "blocks": {
                "plant": {"fmu": "plant", "start": {"dipole_cmd": [0, 0, 0], "wheel_torque_cmd": 0}},
                "sensors": {"start": {"rate_period": 0.5}},
            },
            "connections": [
                *(f"plant.{name} -> sensors.{name}" for name in TRUTH),
                "plant.dipole_mean -> sensors.dipole",
            ],
            "record": {"signals": ["plant.sunlight", "sensors.sun_sensors"]},
        }
    )


def _eclipse(result: Result) -> Any:
    """Signals of the six faces over the orbit, and the sunlight in the first penumbra."""
    figure, ((left, right),) = plots.panels(1, 2, width=5.4)
    t, light = result.time, result["plant.sunlight"]
    for i, face in enumerate(("+X", "-X", "+Y", "-Y", "+Z", "-Z")):
        left.plot(t, result["sensors.sun_sensors"][:, i], linewidth=0.8, label=face)
    left.plot(t, light, color="black", linewidth=1.2, label="sunlight")
    left.set_ylim(None, 1.45)  # room for the legend above the curves
    left.legend(fontsize=7, ncols=4, loc="upper center")
    plots.name_axes(left, "time, s", "1: full light", "Coarse sun sensors over an orbit, at rest in LVLH")
    entry = int(np.flatnonzero(np.diff(light) < 0.0)[0])
    near = slice(entry - 10, entry + 40)
    right.plot(t[near], light[near], "o-", color=plots.BLUE, markersize=3)
    plots.name_axes(right, "time, s", "sunlight", "Penumbra at the entry")
    return figure


def _allan() -> Any:
    figure, ((ax,),) = plots.panels(1, 1, width=6.4, height=4.2)
    for name, (label, colour) in GYROS.items():
        start, T = load(_at_rest(name, 0.1)).source.data["blocks"]["sensors"]["start"], 1.0
        rates = run(_at_rest(name, T))["sensors.omega_B_measured"][1:]
        tau = T * np.unique(np.geomspace(1, len(rates) // 12, 40).astype(int))
        ax.loglog(tau, _deviation(rates, tau, T) / DEG_PER_HOUR, "o", color=colour, markersize=3, label=label)
        ax.loglog(tau, _expected(start, tau) / DEG_PER_HOUR, color=colour, linewidth=1.0)
    ax.legend(fontsize=8)
    plots.name_axes(ax, "averaging time, s", "Allan deviation, deg/h", "Gyros at rest for 40 h; lines: IEEE Std 952")
    return figure


def _at_rest(name: str, T: float) -> dict[str, Any]:
    """A scenario of the sensors alone, the gyro without constant bias and resolution, T s between its measurements."""
    start = {
        "rate_period": T,
        "rate_bias_B": [0, 0, 0],
        "rate_quantum": 0,
        "seed": 7,
        "field_rod_coupling": np.zeros((3, 3)).tolist(),
    }
    truth = {
        "R_NB": np.eye(3).tolist(),
        "omega_B": [0, 0, 0],
        "r_N": [7e6, 0, 0],
        "v_N": [0, 7.5e3, 0],
        "b_B": [0, 0, 0],
        "h_w": 0,
    }
    return {
        "name": "gyro",
        "extends": _extends(f"sensors/{name}"),
        "step": T,
        "duration": RECORD,
        "blocks": {"sensors": {"start": start | truth}},
        "record": {"signals": ["sensors.omega_B_measured"]},
    }


def _deviation(rates: Array, tau: Array, T: float) -> Array:
    """Overlapping Allan deviation (IEEE Std 952, Annex C) of rates (n,3), T s apart, at averaging times tau, the axes
    together."""
    angle = T * np.vstack((np.zeros(3), np.cumsum(rates, axis=0)))
    found = []
    for m in np.rint(tau / T).astype(int):
        second = angle[2 * m :] - 2.0 * angle[m:-m] + angle[: -2 * m]
        found.append(np.sqrt(0.5 * np.mean(second**2)) / (m * T))
    return np.array(found)


def _expected(start: dict[str, Any], tau: Array) -> Array:
    """Angle random walk N/sqrt(tau), rate random walk K sqrt(tau/3) and Markov noise, as a root of the sum of
    squares."""
    N = value_in(start.get("angle_random_walk", 0.0), parse_unit("rad"))
    K = value_in(start.get("rate_random_walk", 0.0), parse_unit("rad/s"))
    sigma = value_in(start["rate_instability"], parse_unit("rad/s"))
    x = tau / value_in(start["rate_instability_time"], parse_unit("s"))
    markov = 2.0 * sigma**2 / x * (1.0 - (3.0 - 4.0 * np.exp(-x) + np.exp(-2.0 * x)) / (2.0 * x))
    return np.asarray(np.sqrt(N**2 / tau + K**2 * tau / 3.0 + markov))
