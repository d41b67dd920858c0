"""Flies cases through the native FMUs and keeps a row of what the plant's truth says of each.

Rows go to results/studies/flight/rows.jsonl as they come, each under a key of its whole scenario and of the FMUs that flew it: a
study that was interrupted goes on, and what other FMUs flew is never mixed in.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from orchestration import BlockError, InputError, Result
from orchestration.scenario.source import Source

from .. import momentum_bound, native
from ..momentum_bound import MomentumBalance, Tolerance
from ..paper import ROOT, Array
from ..processes import Task, each
from ..settling import settling_time
from ..setup import read
from .cases import Case, Data

FOLDER = native.FOLDER / "flight"
RATE = 1e-3
"""Settled: below the angle and this rate, rad/s, from then to the end of the run."""
HOLD = 2000.0
"""The hold's error is that of so many last seconds."""
BLOCKS = ("plant", "plant_sensors", "plant_judge", "controller", "controller_planned", "allocator", "allocator_bounded")
Row = dict[str, Any]


def errors(result: Result) -> tuple[Array, Array]:
    """Angle to LVLH, rad, and rate error, rad/s, of a run, from the plant's truth; each (n,)."""
    return result["judge.attitude_error"], np.asarray(np.linalg.norm(result["judge.rate_error_B"], axis=1))


def settled(time: Array, error: Array, rate: Array, degrees: float) -> float | None:
    """From when on both errors stay within tolerance, s; None where they do not at the end."""
    at = settling_time(time, ~((error < math.radians(degrees)) & (rate < RATE)))
    return None if math.isnan(at) else at


def seen(result: Result, late: float | None = None) -> Row:
    """What a run shows; `late`: the time, s, after which errors are told apart."""
    error, rate = errors(result)
    t, h_w = result.time, result["plant.h_w"]
    last = t > t[-1] - HOLD
    row: Row = {
        "duration": float(t[-1]),
        "settled5": settled(t, error, rate, 5.0),
        "settled1": settled(t, error, rate, 1.0),
        "hold_rms": float(np.sqrt((error[last] ** 2).mean())),
        "hold_max": float(error[last].max()),
        "end_angle": float(error[-1]),
        "end_rate": float(rate[-1]),
        "rate": float(rate[0]),
        "wheel_max": float(np.abs(h_w).max()),
        "wheel_full": float(result["plant.wheel_momentum_saturated"].mean()),
    }
    if "controller.phase" in result:
        phase = result["controller.phase"]
        row["steered"] = float(t[np.argmax(phase > 1)]) if (phase > 1).any() else None
    if late is not None:
        after = t > late
        row["late_rms"] = float(np.sqrt((error[after] ** 2).mean()))
        row["late_max"] = float(error[after].max())
        row["late_wheel"] = float(np.abs(h_w[after]).max())
    return row


def fly(case: Case, fmus: Mapping[str, Path]) -> Row:
    """Flies a case, longer where it has not settled."""
    row: Row = {}
    for duration in case.lengths:
        try:
            row = seen(native.run({**case.data, "duration": duration}, fmus), case.late)
        except (BlockError, InputError) as error:
            return {"failed": str(error)}
        if row["settled5"] is not None and row["settled1"] is not None:
            break
    return row


# ---------------------------------------------------------------- the momentum bound


def bound(data: Data) -> float | None:
    """The least time for a case that the balance of momentum allows, s; with the tolerances of `settled` at 5 deg."""
    wires = {
        "plant": {"R_NB": "controller", "omega_B": "controller", "r_N": "controller", "v_N": "controller"},
        "controller": {"tau_cmd_B": "allocator"},
        "allocator": {"dipole_cmd": "plant", "wheel_torque_cmd": "plant"},
    }
    connections = [f"{a}.{port} -> {b}.{port}" for a, ports in wires.items() for port, b in ports.items()]
    connections += [f"plant.{port} -> allocator.{port}" for port in ("b_B", "omega_B", "h_w")]
    blocks = {name: {"fmu": name} for name in wires} | {"plant": data["blocks"]["plant"]}
    scenario = {"name": "bound", "step": 0.1, "duration": 1.0, "shared": data["shared"]}
    loop = read(Source({**scenario, "blocks": blocks, "connections": connections})).loop
    rods = loop.plant.dipole_max * float(np.max(loop.plant.rod_gain))
    balance = MomentumBalance(loop.plant, loop.controller, rods, Tolerance(math.radians(5.0), RATE), 3000.0)
    return balance.least_time().least


def _bound_row(data: Data) -> Row:
    return {"bound": bound(data)}


# ---------------------------------------------------------------- rows that are kept


class Rows:
    """Rows by key, in a file to which every new one is appended."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.rows: dict[str, Row] = {}
        if file.exists():
            for line in file.read_text("utf-8").splitlines():
                try:
                    entry = json.loads(line)
                except ValueError:  # cut off where a study was ended in the middle of a line
                    continue
                self.rows[entry["key"]] = entry["row"]

    def add(self, key: str, name: str, row: Row) -> None:
        """Keeps a row under its key; `name` is for readers of the file."""
        self.rows[key] = row
        self.file.parent.mkdir(parents=True, exist_ok=True)
        line = json.dumps({"key": key, "case": name, "row": row}) + "\n"
        with self.file.open("ab+") as out:
            if out.tell():  # a line that was cut off ends here
                out.seek(-1, os.SEEK_END)
                line = line if out.read(1) == b"\n" else "\n" + line
            out.write(line.encode())


def key(case: Case, fmus: Mapping[str, Path]) -> str:
    """Of everything that decides a case's row but this file."""
    used = {name: fmus[entry["fmu"]].name for name, entry in case.data["blocks"].items()}
    return _digest([case.data, case.lengths, case.late, used])


def bound_key(data: Data) -> str:
    """Of everything that decides a momentum bound."""
    sources = [*sorted((ROOT / "plant").glob("*.py")), Path(momentum_bound.__file__)]
    return _digest(
        [
            "bound",
            data["shared"],
            data["blocks"]["plant"],
            [hashlib.sha256(p.read_bytes()).hexdigest() for p in sources],
        ]
    )


def _digest(what: Any) -> str:
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:24]


def compute(cases: list[Case], bounded: set[str], processes: int) -> tuple[dict[str, Row], dict[str, float | None]]:
    """Rows of all cases by name, and the momentum bounds, s, of those whose group is `bounded`; with a progress bar."""
    fmus = native.pin(BLOCKS)
    rows = Rows(FOLDER / "rows.jsonl")
    keys = {case.name: key(case, fmus) for case in cases}
    bounds = {case.name: bound_key(case.data) for case in cases if case.group in bounded}
    tasks: dict[str, Task] = {case.name: (fly, (case, fmus)) for case in cases if keys[case.name] not in rows.rows}
    places = dict(keys)
    for case in cases:
        if case.name in bounds and bounds[case.name] not in rows.rows:
            tasks[name := f"bound of {case.name}"] = (_bound_row, (case.data,))
            places[name] = bounds[case.name]
    for name, row in each(tasks, processes, len(cases) + len(bounds) - len(tasks)):
        rows.add(places[name], name, row)
    return (
        {name: rows.rows[place] for name, place in keys.items()},
        {name: rows.rows[place]["bound"] for name, place in bounds.items()},
    )
