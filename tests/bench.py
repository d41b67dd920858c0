"""`make bench`: how fast the loop is on this machine. Prints figures; asserts nothing.

The first rows time work that never changes, so that figures of other days and machines can be compared by ratio. One
orbit (5800 s at 0.1 s) of manoeuvre V.B with everything on: field, drag, gravity gradient, wheel and rods; recorded at
1 s. Beside it, where `pip install bsk` has been done, Basilisk flies the same orbit, and 20 of them by its Monte Carlo.
"""

from __future__ import annotations

import argparse
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import orchestration
from orchestration.session.open import locate

from . import bench_campaign, bench_pages, bench_telemetry

ROOT = Path(__file__).parents[1]
SCENARIO = ROOT / "scenarios" / "paper_no_singularity.yaml"
ORBIT = 5800.0
"""s"""


def orbit(flavour: str, order: int, parts: int = 1) -> dict[str, Any]:
    """The scenario of an orbit, or of its first of so many parts."""
    overrides = {"flavour": flavour, "duration": ORBIT / parts, "plant.integrator_order": order}
    data = orchestration.load(SCENARIO, overrides).source.data
    loop = {name: entry for name, entry in data["blocks"].items() if name != "judge"}  # which stands outside the loop
    wires = [wire for wire in data["connections"] if "judge." not in wire]
    data = {**data, "blocks": loop, "connections": wires}
    return {**data, "record": {"interval": 1.0}, "expect": [], "figures": [], "holds": []}


def row(what: str, time: str, rate: str) -> None:
    """Printed as soon as it is measured."""
    print(f"  {what:<44}{time:>12}{rate:>20}", flush=True)


def machine(runs: int) -> None:
    """What this machine takes at the moment for fixed work of two kinds."""
    angles = np.linspace(0.0, 1e3, 10**6)
    for name, work in (
        ("a million sums in Python", lambda: sum(i * i for i in range(10**6))),
        ("a million sines in C", lambda: np.sin(angles)),
    ):
        walls = []
        for _ in range(runs + 5):
            begun = time.perf_counter()
            work()
            walls.append(time.perf_counter() - begun)
        row(f"calibration: {name}", f"{1e3 * min(walls):.1f} ms", "least")


def loops(runs: int) -> None:
    """Wall time and steps a second of the orbit, for each flavour and each loop; of Python FMUs from a quarter of
    it."""
    for flavour, order, compiled, repeats, parts in (
        ("native", 4, True, runs, 1),
        ("native", 4, False, runs, 1),
        ("native", 2, True, runs, 1),
        ("python", 4, True, 1, 4),
        ("python", 4, False, 1, 4),
        ("python", 2, True, 1, 4),
        ("python", 2, False, 1, 4),
    ):
        results = [orchestration.run(orbit(flavour, order, parts), compiled=compiled) for _ in range(repeats)]
        wall = statistics.median(result.wall for result in results)
        name = f"{flavour} FMUs, order {order}, {'compiled' if compiled else 'Python'} loop"
        row(name, f"{parts * wall:.3f} s", f"{results[0].steps / wall:,.0f} steps/s")


def again(runs: int) -> None:
    """What a run of V.B in a process that has run it before takes beside its loop."""
    walls = []
    for _ in range(2 * runs + 1):
        begun = time.perf_counter()
        result = orchestration.run(SCENARIO)
        walls.append(time.perf_counter() - begun - result.wall)
    row("run() of V.B, the first, beside its loop", f"{1e3 * walls[0]:.1f} ms", "")
    row("run() of V.B, later ones, beside their loop", f"{1e3 * statistics.median(walls[1:]):.1f} ms", "")


def versions(runs: int) -> None:
    """The orbit with plant, controller and allocator of FMI 3.0, which are those of FMI 2.0 behind as_fmi3.c, turn by
    turn."""
    from tests.orchestration import as_fmi3

    with tempfile.TemporaryDirectory() as folder:
        scenarios = {"2.0": orbit("native", 4), "3.0": orbit("native", 4)}
        for name, entry in scenarios["3.0"]["blocks"].items():
            path = as_fmi3.write(Path(folder, f"{name}.fmu"), locate(name, ROOT, "native"))
            scenarios["3.0"]["blocks"][name] = {**entry, "fmu": str(path), "isolation": "none"}
        for compiled in (True, False):
            walls: dict[str, list[float]] = {version: [] for version in scenarios}
            for _ in range(3 * runs if compiled else runs):
                for version, scenario in scenarios.items():
                    walls[version].append(orchestration.run(scenario, compiled=compiled).wall)
            two, three = (min(walls[version]) for version in scenarios)
            name = f"FMI 3.0 beside 2.0, {'compiled' if compiled else 'Python'} loop, quickest run"
            row(name, f"{three:.3f} s", f"{100 * (three / two - 1):+.1f} %")


def of_four() -> dict[str, Any]:
    """The orbit with four wheels, each with the command of the one."""
    data = orbit("native", 4)
    limits = {name: data["shared"].pop(name) for name in WHEEL}
    plant, allocator = (data["blocks"][name] for name in ("plant", "allocator"))
    axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.64, 0.48]]
    plant |= {"fmu": "plant_wheels", "differs": [*WHEEL[:2], "wheel_axis"]}
    plant["start"] |= {"wheels": 4, "wheel_axis": axes, **{name: [value] * 4 for name, value in limits.items()}}
    allocator.setdefault("start", {}).update({name: limits[name] for name in WHEEL[:2]})
    allocator["differs"] = list(WHEEL[:2])
    wires = [wire for wire in data["connections"] if ".h_w" not in wire and ".wheel_torque_cmd" not in wire]
    wires += [f"allocator.wheel_torque_cmd -> plant.wheel_torque_cmd[{i}]" for i in range(1, 5)]
    return data | {"connections": [*wires, "plant.h_w[1] -> allocator.h_w"]}


WHEEL = ("wheel_torque_max", "wheel_momentum_max", "wheel_inertia")


def wheels(runs: int) -> None:
    """The orbit with four wheels beside that with one, turn by turn."""
    scenarios = {1: orbit("native", 4), 4: of_four()}
    walls: dict[int, list[float]] = {n: [] for n in scenarios}
    for _ in range(3 * runs):
        for n, scenario in scenarios.items():
            walls[n].append(orchestration.run(scenario).wall)
    row("four wheels beside one, quickest run", f"{min(walls[4]):.3f} s", f"{min(walls[4]) / min(walls[1]):.2f} times")


LAW = """
import numpy as np


def step(inputs, parameters, t, h):
    R, w, r, v, J = inputs.R_NB, inputs.omega_B, inputs.r_N, inputs.v_N, parameters.J_B
    z, x = R.T @ (r / np.sqrt(r @ r)), R.T @ (v / np.sqrt(v @ v))  # 8
    e = np.array([z[1], -z[0], 0.0]) - np.array([0.0, x[2], x[1]])  # 11
    momentum = J @ w  # 12
    turned = np.array([w[1] * momentum[2], w[2] * momentum[0], w[0] * momentum[1]])  # 13
    tau = turned - 1e-4 * e - 0.02 * (J @ w) - 1e-3 * w  # 20
    return {"tau_cmd_B": np.clip(tau, -1.0, 1.0)}
"""
"""Of twenty operations of NumPy and a clip; np.cross would count as ten."""


def laws(runs: int) -> None:
    """V.B with a law in Python in the controller's place, asked at each step: in this process and in its own."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "law.py")
        path.write_text(LAW, "utf-8")
        for where in ("none", "process"):
            data = orbit("native", 4, 20)
            data["blocks"]["controller"] = {"python": str(path), "isolation": where}
            data["shared"] = {**data.get("shared", {}), "J_B": {"diagonal": [0.0426, 0.0608, 0.0618]}}
            rates = [(result := orchestration.run(data)).steps / result.wall for _ in range(runs)]
            name = "in this process" if where == "none" else "in its own process"
            row(f"loop with a law of 20 NumPy operations, {name}", "", f"{max(rates):,.0f} steps/s")


def calls(flavour: str, count: int) -> None:
    """What each FMU's doStep costs, called in a row without exchange."""
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    for block in ("plant", "controller", "allocator"):
        path = locate(block, ROOT, flavour)
        description = read_model_description(str(path))
        with tempfile.TemporaryDirectory() as folder:
            identifier = description.coSimulation.modelIdentifier
            extract(str(path), folder)
            fmu = FMU2Slave(
                guid=description.guid, unzipDirectory=folder, modelIdentifier=identifier, instanceName=block
            )
            fmu.instantiate()
            fmu.setupExperiment(startTime=0.0)
            fmu.enterInitializationMode()
            fmu.exitInitializationMode()
            step, component = fmu.fmi2DoStep, fmu.component
            begun = time.perf_counter()
            for i in range(count):
                step(component, i * 0.1, 0.1, 1)
            each = (time.perf_counter() - begun) / count
            fmu.terminate()
            fmu.freeInstance()
        row(f"doStep of {block}.fmu, {flavour}", f"{1e6 * each:.2f} us", "through ctypes")


def process(runs: int) -> None:
    """`orchestrate` as a whole process, FMUs built: start, V.B, results written, table printed.

    Python keeps its compiled modules, as it does unless it is told not to; the first run, which compiles them, is not
    counted.
    """
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    with tempfile.TemporaryDirectory() as out:
        command = [sys.executable, "-m", "orchestration.cli.main", str(SCENARIO), "--out", out]
        for name, arguments in (("whole process, V.B", []), ("whole process, one step", ["--duration", "0.1"])):
            walls = []
            for _ in range(runs + 1):
                begun = time.perf_counter()
                subprocess.run([*command, *arguments], cwd=ROOT, env=environment, check=False, capture_output=True)
                walls.append(time.perf_counter() - begun)
            row(f"orchestrate as a {name}", f"{statistics.median(walls[1:]):.3f} s", f"{min(walls[1:]):.3f} s least")


def isolation() -> None:
    """What a step costs more when a block runs in a process of its own."""
    from orchestration.fmu.archive import open_fmu
    from tests.orchestration.instances.bench_isolation import measure

    for block in ("controller", "plant"):
        found = measure(open_fmu(locate(block, ROOT, "native")))
        name = f"whole step of {block}.fmu"
        row(f"{name}, in this process", f"{found['none'][0]:.1f} us", "Python loop")
        row(f"{name}, in its own process", f"{found['process'][0]:.1f} us", "Python loop")


def basilisk(runs: int) -> None:
    """The same orbit by Basilisk, once and in its own Monte Carlo, in processes of their own."""
    if find_spec("Basilisk") is None:
        row("Basilisk", "not installed", "pip install bsk")
        return
    if (figures := _basilisk()) is not None:
        imports, setup, wall = figures
        row("Basilisk, the same orbit", f"{wall:.3f} s", f"{ORBIT / 0.1 / wall:,.0f} steps/s")
        row("Basilisk, imports and set-up", f"{imports + setup:.3f} s", "")
    processes = os.cpu_count() or 1
    if (figures := _basilisk(runs, processes)) is not None:
        wall, failed = figures
        row(
            f"Basilisk Monte Carlo: {runs} orbits, {processes} processes",
            f"{wall:.1f} s",
            f"{runs / wall:.2f} orbits/s",
        )
        if failed:
            row("Basilisk Monte Carlo: runs that failed", f"{failed:.0f}", "")


def _basilisk(*arguments: int) -> list[float] | None:
    """The figures that bench_basilisk prints; None where it fails, and a row says so."""
    run = subprocess.run(
        [sys.executable, "-m", "tests.bench_basilisk", str(ORBIT), *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if run.returncode:
        row("Basilisk", "failed", run.stderr.strip().splitlines()[-1])
        return None
    return [float(text) for text in run.stdout.splitlines()[-1].split()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5, help="runs of which the median is taken (native and processes)")
    runs = max(parser.parse_args().runs, 1)
    print(f"One orbit, {ORBIT:.0f} s at 0.1 s; {platform.machine()}, Python {platform.python_version()}", flush=True)
    for flavour in ("native", "python"):
        for block in ("plant", "controller", "allocator"):
            locate(block, ROOT, flavour)
    machine(runs)
    loops(runs)
    again(runs)
    laws(runs)
    versions(runs)
    wheels(runs)
    bench_pages.pages(runs, row)
    calls("native", 20000)
    calls("python", 2000)
    process(runs)
    isolation()
    bench_telemetry.rows(row)
    bench_campaign.rows(orbit("native", 4), 400, row)
    basilisk(20)


if __name__ == "__main__":
    main()
