"""Flies cases through the FMUs and keeps a row of what the plant's truth says of each.

Rows go to results/flight/rows.jsonl as they come, each under a key of its whole scenario and of the FMUs that flew it: a study
that was interrupted goes on, and what other FMUs flew is never mixed in. The FMUs are copied first, so that a build
during a study changes nothing in it.
"""

from __future__ import annotations

import atexit
import ctypes
import hashlib
import json
import math
import os
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from orchestration import BlockError, InputError, Result

from .claims import ORBIT, ROOT
from .flight_cases import Case, Data
from .vectors import Array, angle

FOLDER = ROOT / "results" / "flight"
RATE = 1e-3
"""Settled: below the angle and this rate, rad/s, from then to the end of the run."""
HOLD = 2000.0
"""The hold's error is that of so many last seconds."""
BLOCKS = ("plant", "plant_sensors", "controller", "controller_planned", "allocator", "allocator_bounded")
Row = dict[str, Any]


# ---------------------------------------------------------------- the truth


def truth(R_NB: Array, omega_B: Array, r_N: Array, v_N: Array) -> tuple[Array, Array]:
    """Angle between attitude and LVLH, rad, and size of the rate error, rad/s, each (n,), from rows of the plant's outputs.

    LVLH is made here from position and velocity: Z to nadir, Y against the orbit's normal, turning at |r x v|/r^2 about it.
    """
    normal = np.cross(r_N, v_N)
    z = -r_N / np.linalg.norm(r_N, axis=1)[:, None]
    y = -normal / np.linalg.norm(normal, axis=1)[:, None]
    target = np.stack((np.cross(y, z), y, z), axis=2)
    Q = np.einsum("nji,njk->nik", target, R_NB)
    turning = normal / (r_N * r_N).sum(axis=1)[:, None]
    rate = omega_B - np.einsum("nji,nj->ni", R_NB, turning)
    return angle(np.moveaxis(Q, 0, -1)), np.asarray(np.linalg.norm(rate, axis=1))


def settled(time: Array, error: Array, rate: Array, degrees: float) -> float | None:
    """From when on both errors stay within tolerance, s; None where they do not at the end."""
    bad = np.flatnonzero(~((error < math.radians(degrees)) & (rate < RATE)))
    if not len(bad):
        return float(time[0])
    return None if bad[-1] + 1 == len(time) else float(time[bad[-1] + 1])


def seen(result: Result) -> Row:
    """What a run shows."""
    names = ("R_NB", "omega_B", "r_N", "v_N")
    error, rate = truth(*(result[f"plant.{name}"] for name in names))
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
        "wall": result.wall,
    }
    if "controller.phase" in result:
        phase = result["controller.phase"]
        row["steered"] = float(t[np.argmax(phase > 1)]) if (phase > 1).any() else None
        row["phase"] = int(phase[-1])
    if t[-1] > 5.0 * ORBIT:  # a long hold: what it is after an orbit
        late = t > ORBIT
        row["late_rms"] = float(np.sqrt((error[late] ** 2).mean()))
        row["late_max"] = float(error[late].max())
        row["late_wheel"] = float(np.abs(h_w[late]).max())
    return row


# ---------------------------------------------------------------- the FMUs


def pin(blocks: Iterable[str] = BLOCKS) -> dict[str, Path]:
    """Builds the FMUs where need be, and copies them to where no build reaches; by block, named by what they do."""
    from fmus.build import ensure

    kept = FOLDER / "fmus"
    kept.mkdir(parents=True, exist_ok=True)
    found = {}
    for block in blocks:
        content = ensure(block, "native").read_bytes()
        found[block] = kept / f"{block}-{identity(block)}.fmu"
        if not found[block].exists():
            part = found[block].with_suffix(f".{os.getpid()}")
            part.write_bytes(content)
            part.replace(found[block])
    return found


def identity(block: str) -> str:
    """What a block does, as a hash: its C and tables, and its variables but for how they are described in words."""
    from fmus.build import Block
    from fmus.interface import load
    from fmus.native import sources

    folder = Block.named(block).folder
    tables = sorted(path for path in (folder / "tables").rglob("*") if path.suffix in (".py", ".csv"))
    digest = hashlib.sha256()
    for path in (*sources(folder), *tables):
        digest.update(path.name.encode() + path.read_bytes())
    for v in load(block).variables.values():
        digest.update(repr(replace(v, description="")).encode())
    return digest.hexdigest()[:16]


@cache
def opened(path: Path) -> tuple[Any, Path]:
    """An FMU and where it is unpacked, once a process."""
    from orchestration.fmu.archive import open_fmu

    fmu = open_fmu(path)
    folder = Path(tempfile.mkdtemp(prefix="flight-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    fmu.extract(folder)
    return fmu, folder


def run(data: Data, duration: float, fmus: Mapping[str, Path]) -> Result:
    """Runs a scenario of the project's blocks with these FMUs."""
    from contextlib import ExitStack

    from orchestration import load
    from orchestration.instances.slave import Slave
    from orchestration.runner.plan import plan
    from orchestration.runner.run import run_blocks

    scenario = load({**data, "duration": duration})
    parts = {name: opened(fmus[entry.fmu]) for name, entry in scenario.blocks.items()}
    ready = plan(scenario, {name: fmu.model for name, (fmu, _) in parts.items()})
    with ExitStack() as stack:
        slaves = {}
        for name, (fmu, folder) in parts.items():
            slaves[name] = Slave(name, fmu, folder)
            stack.callback(slaves[name].close)
        result = run_blocks(ready, slaves, compiled=True)
    if result.failure is not None:
        raise result.failure
    return result


def memory(component: Any) -> int | None:
    """Bytes of an instance, which the native FMUs allocate as a whole; None where the C library does not tell."""
    size = getattr(ctypes.CDLL(None), "malloc_usable_size", None) if os.name == "posix" else None
    if size is None:
        return None
    size.restype, size.argtypes = ctypes.c_size_t, [ctypes.c_void_p]
    return int(size(component))


def fly(case: Case, fmus: Mapping[str, Path]) -> Row:
    """Flies a case, longer where it has not settled."""
    row: Row = {}
    for duration in case.lengths:
        try:
            row = seen(run(case.data, duration, fmus))
        except (BlockError, InputError) as error:
            return {"failed": str(error)}
        if row["settled5"] is not None and row["settled1"] is not None:
            break
    return row


# ---------------------------------------------------------------- the momentum bound


def bound(data: Data) -> float | None:
    """The least time for a case that the balance of momentum allows, s, proven; with the tolerances of `settled` at 5 deg."""
    from orchestration.scenario.source import Source

    from .momentum_bound import MomentumBalance, Tolerance
    from .setup import read

    wires = {
        "plant": {"R_NB": "controller", "omega_B": "controller", "r_N": "controller", "v_N": "controller"},
        "controller": {"tau_cmd_B": "allocator"},
        "allocator": {"dipole_cmd": "plant", "wheel_torque_cmd": "plant"},
    }
    connections = [f"{a}.{port} -> {b}.{port}" for a, ports in wires.items() for port, b in ports.items()]
    connections += [f"plant.{port} -> allocator.{port}" for port in ("b_B", "omega_B", "h_w")]
    blocks = {name: {"fmu": name} for name in wires} | {"plant": data["blocks"]["plant"]}
    loop = read(
        Source({"name": "bound", "step": 0.1, "duration": 1.0, "blocks": blocks, "connections": connections})
    ).loop
    rods = loop.plant.dipole_max * float(np.max(loop.plant.rod_gain))
    balance = MomentumBalance(loop.plant, loop.controller, rods, Tolerance(math.radians(5.0), RATE), 3000.0)
    return balance.least_time().least


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
    return _digest([case.data, case.lengths, used])


def bound_key(data: Data) -> str:
    sources = [*sorted((ROOT / "plant").glob("*.py")), Path(__file__).with_name("momentum_bound.py")]
    return _digest(["bound", data["blocks"]["plant"], [hashlib.sha256(p.read_bytes()).hexdigest() for p in sources]])


def _digest(what: Any) -> str:
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:24]


def compute(cases: list[Case], bounded: set[str], processes: int) -> tuple[dict[str, Row], dict[str, float | None]]:
    """Rows of all cases by name, and the momentum bounds, s, of those whose group is `bounded`; with a progress bar."""
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    os.environ.setdefault("OMP_NUM_THREADS", "1")  # BLAS threads would only get in the processes' way
    fmus = pin()
    rows = Rows(FOLDER / "rows.jsonl")
    keys = {case.name: key(case, fmus) for case in cases}
    bounds = {case.name: bound_key(case.data) for case in cases if case.group in bounded}
    columns = (TextColumn("{task.description:28}"), BarColumn(), MofNCompleteColumn())
    with (
        Progress(*columns, TimeElapsedColumn(), TimeRemainingColumn()) as progress,
        ProcessPoolExecutor(processes) as pool,
    ):
        flights = [case for case in cases if keys[case.name] not in rows.rows]
        balances = [case for case in cases if case.name in bounds and bounds[case.name] not in rows.rows]
        total = len(cases) + len(bounds)
        task = progress.add_task("flights", total=total, completed=total - len(flights) - len(balances))
        futures: dict[Any, tuple[str, str]] = {}
        for case in flights:
            futures[pool.submit(fly, case, fmus)] = keys[case.name], case.name
        for case in balances:
            futures[pool.submit(_bound_row, case.data)] = bounds[case.name], f"bound of {case.name}"
        try:
            for future in as_completed(futures):
                place, name = futures[future]
                rows.add(place, name, future.result())
                progress.update(task, advance=1, description=name)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return (
        {name: rows.rows[place] for name, place in keys.items()},
        {name: rows.rows[place]["bound"] for name, place in bounds.items()},
    )


def _bound_row(data: Data) -> Row:
    return {"bound": bound(data)}
