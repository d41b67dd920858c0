"""Telemetry of one wheel that fails, and wheels that fail, of satellites as `orchestrate new satellite` writes them:
docs/evidence/wheels_telemetry.csv. Tests: tests/evidence/wheels/test_telemetry.py.

The requirement, stated before the flights: with three and with four wheels, 3U, 12U and 50 kg, the telemetry of one
wheel frozen, zero, biased or noisy, beginning in a tumble, a hold or a slew, the attitude error is below 15 deg from
ten minutes after the failure on (in a tumble from LATE on, by which the healthy ones have settled) for three orbits,
by the plant's truth; the wheel that works is not named failed in 95% of the flights; and a wheel that fails is found
as before.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from design.new_satellite import fill, templates
from orchestration import run
from orchestration.scenario.text import parse

from .. import files
from ..crew import crew
from ..flight.schemes import Data
from ..paper import FOLDER, ROOT
from ..satellites.classes import CLASSES

FILE = ROOT / "docs" / "evidence" / "wheels_telemetry.csv"
SATELLITES = ("3U", "12U", "50 kg")
SETS = {3: "three axes", 4: "pyramid 35 deg"}
TELEMETRY = ("frozen", "zero", "biased", "noisy")
FAILED = ("dead", "gives 0.3", "reversed", "drags")
BEGINS = ("tumble", "hold", "slew")
ORBITS, PERIOD = 3.0, 5738.993
"""Of flight after the failure, at 550 km; s."""
BELOW, TEN_MINUTES, LATE = 15.0, 600.0, 4000.0
"""deg; s from the failure and from the tumble's begin."""
BIAS, NOISE, FRICTION = 0.2, 0.1, 0.3
"""Of the momentum's limit, and of the torque's."""
SEED = 20


@dataclass(frozen=True)
class Failure:
    """A flight: deg and s; NaN where the wheel is not named."""

    wheels: int
    satellite: str
    failure: str
    begin: str
    run: int
    at: float
    largest: float
    """From ten minutes after the failure on."""
    named: float
    """From the failure until the wheel is named failed."""
    others: int
    """Wheels beside it that are named failed."""

    @property
    def of_telemetry(self) -> bool:
        return self.failure in TELEMETRY

    @property
    def held(self) -> bool:
        return self.largest < BELOW


def generated(satellite: str, wheels: int) -> Path:
    """The scenario of a satellite with a set of wheels, made by `orchestrate new satellite`."""
    it = CLASSES[satellite]
    folder = FOLDER / "wheels" / f"{satellite} {wheels}".replace(" ", "_")
    if not (folder / "tumble.yaml").exists():
        fill(
            templates(),
            folder,
            {
                "inertia": np.diag(it.moments).tolist(),
                "body_width": it.size[0],
                "body_length": it.size[1],
                "body_axis": it.axis,
                "dipole_max": it.dipole_max,
                "rod_axes": it.rod_axes,
                "wheels": SETS[wheels],
                "wheel_torque_max": it.wheel_torque_max,
                "wheel_momentum_max": it.wheel_momentum_max,
                "sensors": "star tracker",
                "altitude": "550 km",
                "inclination": "97.6 deg",
            },
        )
    return folder / "tumble.yaml"


def _faults(failure: str, wheel: int, at: float, satellite: str, sign: float) -> list[Data]:
    it, measured = CLASSES[satellite], f"sensors.h_w_measured[{wheel}]"
    faults: dict[str, Data] = {
        "frozen": {"freeze": measured},
        "zero": {"cut": measured},
        "biased": {"bias": measured, "by": sign * BIAS * it.wheel_momentum_max},
        "noisy": {"set": f"noisy.wheel_momentum_noise = {NOISE * it.wheel_momentum_max}"},
        "dead": {"set": f"plant.wheel_gain[{wheel}] = 0"},
        "gives 0.3": {"set": f"plant.wheel_gain[{wheel}] = 0.3"},
        "reversed": {"set": f"plant.wheel_gain[{wheel}] = -1"},
        "drags": {"set": f"plant.wheel_coulomb_friction[{wheel}] = {FRICTION * it.wheel_torque_max}"},
    }
    return [{"at": at, **faults[failure]}]


def _noisy(data: Data, wheels: int, wheel: int) -> Data:
    """The telemetry of the wheel comes from sensors of its own, whose noise the failure sets; in place."""
    blocks, connections = data["blocks"], []
    blocks["noisy"] = {**blocks["sensors"], "start": {"seed": 99}}
    for line in data["connections"]:
        source, _, target = line.partition(" -> ")
        if source == "sensors.h_w_measured":
            names = ["noisy" if i == wheel else "sensors" for i in range(1, 5)]
            connections += [f"{name}.h_w_measured[{i}] -> {target}[{i}]" for i, name in enumerate(names, 1)]
        else:
            connections.append(line)
            connections += [line.replace("-> sensors.", "-> noisy.")] if "-> sensors." in line else []
    data["connections"] = connections
    return data


def scenario(satellite: str, wheels: int, failure: str, begin: str, number: int) -> tuple[Data, int, float]:
    """The scenario of a flight, the wheel whose part fails, and when, s."""
    it = CLASSES[satellite]
    rng = np.random.default_rng([SEED, number])
    file = generated(satellite, wheels)
    data: Data = parse(file.read_text("utf-8"), str(file)).data
    for key in ("live", "figures", "expect"):
        data.pop(key, None)
    data["extends"] = [str(file.parent / name) for name in data["extends"]]
    q = rng.normal(size=4)
    spin = rng.normal(size=3)
    rate = math.radians(rng.uniform(1.0, 6.0)) * spin / np.linalg.norm(spin)
    at = {"tumble": rng.uniform(20.0, 300.0), "hold": rng.uniform(4000.0, 7000.0), "slew": rng.uniform(4.0, 30.0)}[
        begin
    ]
    at = round(2.0 * at) / 2.0
    wheel = int(rng.integers(1, wheels + 1))
    plant = data["blocks"]["plant"]["start"]
    del plant["Q0"], plant["omega_B0"]
    plant |= {
        "initial_attitude": "q_NB0",
        "q_NB0": (q / np.linalg.norm(q)).tolist(),
        "omega_B0": rate.tolist() if begin == "tumble" else [0.0] * 3,
        "node_longitude": float(rng.uniform(0.0, 360.0)) * math.pi / 180.0,
        "inclination": math.radians(rng.uniform(30.0, 98.0)),
        "wheel_gain": rng.uniform(0.95, 1.05, 4).tolist(),
        "wheel_coulomb_friction": (rng.uniform(0.0, 0.02, 4) * it.wheel_torque_max).tolist(),
    }
    data["blocks"]["sensors"].setdefault("start", {})["seed"] = int(rng.integers(1, 2**31 - 1))
    if failure == "noisy":
        data = _noisy(data, wheels, wheel)
    data["faults"] = _faults(failure, wheel, at, satellite, rng.choice([-1.0, 1.0])) if failure != "none" else []
    data["duration"] = math.ceil(at + ORBITS * PERIOD)
    data["record"] = {
        "interval": 1.0,
        "signals": ["judge.attitude_error", "allocator.wheel_failed", "allocator.h_w_failed"],
    }
    return data, wheel, at


def fly(which: tuple[str, int, str, str, int]) -> Failure:
    """Flies one: satellite, wheels, failure, begin and number."""
    satellite, wheels, failure, begin, number = which
    data, wheel, at = scenario(*which)
    result = run(data)
    time = result.time
    after = max(at + TEN_MINUTES, LATE if begin == "tumble" else 0.0)
    told = np.stack([result[f"allocator.wheel_failed[{i + 1}]"] > 0.5 for i in range(wheels)])
    first = [float(time[one & (time >= at)][0]) - at if (one & (time >= at)).any() else math.nan for one in told]
    largest = math.degrees(float(result["judge.attitude_error"][time >= after].max()))
    others = sum(bool(one.any()) for i, one in enumerate(told) if i != wheel - 1)
    return Failure(wheels, satellite, failure, begin, number, at, largest, first[wheel - 1], others)


def flights(cases: int) -> list[tuple[str, int, str, str, int]]:
    """So many of telemetry for each number of wheels, and as many of wheels that fail in all."""
    found: list[tuple[str, int, str, str, int]] = []
    for wheels in SETS:
        found += [
            (SATELLITES[i % 3], wheels, TELEMETRY[i % 4], BEGINS[(i // 3 + i // 12) % 3], 1000 * wheels + i)
            for i in range(cases)
        ]
    return found + [
        (SATELLITES[i % 3], 3 + i % 2, FAILED[i % 4], BEGINS[(i // 3 + i // 12) % 3], 9000 + i) for i in range(cases)
    ]


def make(cases: int, jobs: int) -> Iterator[str]:
    """Flies them and writes the file."""
    with crew(jobs) as hands:
        found: list[Any] = hands.each("telemetry", fly, flights(cases))
    files.save(Failure, FILE, found)
    told = [one for one in found if one.of_telemetry]
    yield f"{sum(one.held for one in told)} of {len(told)} held, {sum(math.isnan(one.named) for one in told)} not named"


def load() -> list[Failure]:
    return files.load_if_any(Failure, FILE, "python -m evidence wheels --part telemetry")
