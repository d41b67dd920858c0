"""Every shipped scenario, exported and flown by a plain C host (ssd_host.c) and other tools: what differs from our run.

python -m tests.tools.exchanges [SCENARIO ...] writes docs/evidence/exchange.csv; about a quarter of an hour for all.
"""

from __future__ import annotations

import csv
import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from fmpy.ssp import ssd
from numpy.typing import NDArray

import orchestration
from orchestration import Scenario, load

mpl.use("Agg")
Floats = NDArray[np.float64]
ROOT = Path(__file__).parents[2]
SCENARIOS = sorted((ROOT / "scenarios").glob("*.yaml"))
SEEN = ("judge.attitude_error", "estimate_judge.attitude_error", "plant.h_w", "plant.omega_B")
"""What is compared, where a scenario has it; the first is that of the table."""
SOON = {"fault_failed_rod": 40.0, "fault_lost_magnetometer": 100.0, "fault_stuck_wheel": 110.0}
"""How long is flown, s, so that the fault is in it; 40 s of the others."""
TOOLS = {"fmpy": "parallel", "libcosim": "parallel", "ecos": "exchanged"}
"""All step all blocks at once; the C host shows its signals as each of them does."""
ARM = Path("/usr/aarch64-linux-gnu")
"""Where Debian's libc6-arm64-cross has the C library that the host asks for."""
EMULATED = ["qemu-aarch64", "-L", str(ARM)]
HEADER = ("scenario", "seconds", "in order - ours", "at once - ours", *(f"{tool} - at once" for tool in TOOLS))
_LEFT_OUT = ("expect", "figures", "holds", "consistency", "record", "live")
_TYPES = {"Real": "r", "Integer": "i", "Enumeration": "i", "Boolean": "b", "String": "s"}


@cache
def host(target: str | None = None) -> Path:
    """The C host, compiled for this machine or another of zig's targets."""
    out = Path(tempfile.mkdtemp(prefix="ssd-host-")) / "ssd_host"
    shell = ROOT / "fmus" / "native" / "shell"
    command = [sys.executable, "-m", "ziglang", "cc", "-std=gnu11", "-O2", "-I", str(shell), "-o", str(out)]
    command += [] if target is None else ["-target", target]
    subprocess.run([*command, str(Path(__file__).with_name("ssd_host.c")), "-ldl"], check=True, capture_output=True)
    return out


class _Part:
    def __init__(self, component: Any, folder: Path, platform: str) -> None:
        file = folder / component.source
        about = fmpy.read_model_description(str(file))
        unpacked = Path(fmpy.extract(str(file)))
        self.variables = {v.name: v for v in about.modelVariables}
        library = unpacked / "binaries" / platform / f"{about.coSimulation.modelIdentifier}.so"
        self.lines = [component.name, str(library), about.guid, (unpacked / "resources").as_uri()]
        for binding in component.parameterBindings:
            self.lines += [self._value(p) for values in binding.parameterValues for p in values.parameters]
        self.lines.append(".")

    def _value(self, parameter: Any) -> str:
        v, text = self.variables[parameter.name], str(parameter.value)
        if v.type == "Enumeration":
            text = {item.name: str(item.value) for item in v.declaredType.items}.get(text, text)
        text = {"true": "1", "false": "0", "True": "1", "False": "0"}.get(text, text)
        return f"{_TYPES[v.type]} {v.valueReference} {text}"

    def end(self, name: str) -> str:
        v = self.variables[name]
        return f"{_TYPES[v.type]} {v.valueReference}"


def planned(archive: Path, signals: list[str], folder: Path, platform: str = "linux64") -> Path:
    """The plan of an archive for the C host, with the FMUs' libraries for a platform."""
    system = ssd.read_ssd(str(archive)).system
    unpacked = Path(fmpy.extract(str(archive), unzipdir=str(folder / "unpacked")))
    parts = {component.name: _Part(component, unpacked, platform) for component in system.elements}
    place = {name: i for i, name in enumerate(parts)}
    wires = []
    for c in system.connections:
        start, end = parts[c.startElement].end(c.startConnector), parts[c.endElement].end(c.endConnector)
        wires.append(f"{place[c.startElement]} {start} {place[c.endElement]} {end} 1 0")
    ends = (signal.partition(".") for signal in signals)
    columns = [f"{place[block]} {parts[block].end(name)} 0 r 0 1 0" for block, _, name in ends]
    lines = [f"{len(parts)} {len(wires)} {len(columns)}", *(line for part in parts.values() for line in part.lines)]
    path = folder / "plan.txt"
    path.write_text("\n".join([*lines, *wires, *columns]) + "\n", "utf-8")
    return path


def flown(
    archive: Path, step: float, count: int, signals: list[str], interval: int, exchange: str, arm: bool = False
) -> Floats:
    """The signals at the start and after each `interval` steps, by the C host. `arm`: the host and the FMUs' libraries
    are those of Linux on Arm, in an emulator. Raises AssertionError with its words.
    """
    with tempfile.TemporaryDirectory() as folder:
        plan = planned(archive, signals, Path(folder), "aarch64-linux" if arm else "linux64")
        words = [*EMULATED, str(host("aarch64-linux-gnu.2.17"))] if arm else [str(host())]
        words += [str(plan), repr(step), str(count), str(interval), exchange]
        run = subprocess.run(words, capture_output=True, check=False)
    assert run.returncode == 0, run.stderr.decode()[-2000:]
    return np.frombuffer(run.stdout).reshape(-1, len(signals))


def by_tool(tool: str, archive: Path, step: float, count: int, signal: str) -> Floats:
    """A signal after each step, by the recipe of the page on tools for a loop in FMPy, libcosim or ecos.

    Raises AssertionError with the last words of the tool.
    """
    block, _, name = signal.partition(".")
    text = (Path(__file__).parent / "recipes" / f"{tool}_ssp.py").read_text("utf-8")
    end = (count - 0.5 if tool == "fmpy" else count) * step  # FMPy adds up times and goes on below its end
    for old, new in {
        "step = 0.1": f"step = {step!r}",
        "120": repr(end),
        "controller.attitude_error": signal,
        "controller::attitude_error": f"{block}::{name}",
        '"controller"': f'"{block}"',
        'b"attitude_error"': f'b"{name}"',
    }.items():
        text = text.replace(old, new)
    text += "\nimport json\n\nprint('\\n@' + json.dumps([float(each) for each in error]))\n"
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(archive, Path(folder, "adcs.ssp"))
        command = [sys.executable, "-c", text]
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert "\n@" in run.stdout, (run.stderr or run.stdout).strip().splitlines()[-1:]
    return np.array(json.loads(run.stdout.rpartition("\n@")[2]))


def plain(path: Path, duration: float | None = None) -> Scenario:
    """A scenario without what judges or records it."""
    source = load(path).source.without([(key,) for key in _LEFT_OUT])
    return load(source if duration is None else source.with_value("duration", duration, "--duration"))


def compared(scenario: Scenario, folder: Path, exchange: str = "sequential") -> dict[str, Floats]:
    """The difference of each signal from our run over time: of the whole flight, or of 120 s where all step at once."""
    archive = folder / f"{scenario.name}.ssp"
    if not archive.exists():
        orchestration.export_loop(scenario, archive)
    step = float(scenario.step)
    count = round(scenario.duration / step)
    if exchange == "parallel":
        count = min(count, round(120.0 / step))
    interval = max(count // 5000, 1)
    source = scenario.source.with_value("record", {"interval": interval * step}, "")
    source = source.with_value("duration", count * step, "--duration")
    ours = orchestration.run(load(source))
    labels = [f"{s}{i}" for s in SEEN for i in ("", "[1]", "[2]", "[3]") if f"{s}{i}" in ours.labels]
    own = np.column_stack([ours.samples[:, ours.labels.index(label)] for label in labels])[: count // interval + 1]
    theirs = flown(archive, step, count, labels, interval, exchange)
    return dict(zip(labels, np.abs(theirs - own).T, strict=True))


def in_tools(path: Path, duration: float, tools: Sequence[str] = tuple(TOOLS)) -> list[str]:
    """The row of a scenario: s, and the largest differences of the first of SEEN in rad, `refused` where it ends."""
    scenario = plain(path, duration)
    step, count = float(scenario.step), round(scenario.duration / scenario.step)
    ours = orchestration.run(load(scenario.source.with_value("record", {"interval": step}, "")))
    signal = next(each for each in SEEN if each in ours.labels)
    own = ours.samples[1:, ours.labels.index(signal)]
    with tempfile.TemporaryDirectory() as folder:
        archive = orchestration.export_loop(scenario, Path(folder, "adcs.ssp"), numbers=True)
        by_host = {
            exchange: flown(archive, step, count, [signal], 1, exchange)[1:, 0]
            for exchange in ("sequential", "parallel", *{TOOLS[tool] for tool in tools} - {"parallel"})
        }
        found = [np.abs(by_host[exchange] - own).max() for exchange in ("sequential", "parallel")]
        for tool in tools:
            try:
                theirs = by_tool(tool, archive, step, count, signal)
            except AssertionError as error:
                print(f"{path.stem}: {tool}: {error}", file=sys.stderr)
                found.append(np.nan)
                continue
            found.append(np.abs(theirs - by_host[TOOLS[tool]]).max())
    return [path.stem, f"{scenario.duration:g}", *("refused" if np.isnan(x) else f"{x:.2g}" for x in found)]


def drawn(rows: Sequence[Sequence[str]]) -> None:
    """docs/figures/exchange.png: how far each scenario is from our run where a host steps all blocks at once."""
    names, apart = [row[0] for row in rows], [float(row[3]) for row in rows]
    figure, axes = plt.subplots(figsize=(7.0, 4.6), layout="constrained")
    axes.barh(names, [max(value, 1e-5) for value in apart], color="#0072b2")
    axes.set(xscale="log", xlim=(1e-5, 1.0), xlabel="difference of the attitude error from our run, rad")
    axes.set_title("All blocks stepped at once: each scenario's first seconds", fontsize=10)
    axes.invert_yaxis()
    axes.tick_params(axis="y", labelsize=7)
    figure.savefig(ROOT / "docs" / "figures" / "exchange.png", dpi=150)
    plt.close(figure)


def main(names: list[str]) -> None:
    """Writes docs/evidence/exchange.csv a row at a time, for the scenarios named, and its figure."""
    table = ROOT / "docs" / "evidence" / "exchange.csv"
    rows = {row[0]: row for row in csv.reader(table.read_text("utf-8").splitlines())} if table.exists() else {}
    for path in SCENARIOS:
        if not names or path.stem in names:
            rows[path.stem] = in_tools(path, SOON.get(path.stem, 40.0))
            print(*rows[path.stem], flush=True)
            listed = [rows[each.stem] for each in SCENARIOS if each.stem in rows]
            with table.open("w", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows([HEADER, *listed])
            drawn(listed)


if __name__ == "__main__":
    main(sys.argv[1:])
