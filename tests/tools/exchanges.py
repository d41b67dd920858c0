"""Every shipped scenario, exported and flown by a plain C host (ssd_host.c) to its end: what differs from our run.

python -m tests.tools.exchanges [SCENARIO ...] prints the table of docs/use/tools.md; about ten minutes for all.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.ssp import ssd
from numpy.typing import NDArray

import orchestration
from orchestration import Scenario, load

Floats = NDArray[np.float64]
ROOT = Path(__file__).parents[2]
SCENARIOS = sorted((ROOT / "scenarios").glob("*.yaml"))
SEEN = ("judge.attitude_error", "estimate_judge.attitude_error", "plant.h_w", "plant.omega_B")
"""What is compared, where a scenario has it; the first is that of the table."""
_LEFT_OUT = ("expect", "figures", "holds", "consistency", "record", "live")
_TYPES = {"Real": "r", "Integer": "i", "Enumeration": "i", "Boolean": "b", "String": "s"}


@cache
def host() -> Path:
    """The C host, compiled for this machine."""
    out = Path(tempfile.mkdtemp(prefix="ssd-host-")) / "ssd_host"
    shell = ROOT / "fmus" / "native" / "shell"
    command = [sys.executable, "-m", "ziglang", "cc", "-std=gnu11", "-O2", "-I", str(shell), "-o", str(out)]
    subprocess.run([*command, str(Path(__file__).with_name("ssd_host.c")), "-ldl"], check=True, capture_output=True)
    return out


class _Part:
    def __init__(self, component: Any, folder: Path) -> None:
        file = folder / component.source
        about = fmpy.read_model_description(str(file))
        unpacked = Path(fmpy.extract(str(file)))
        self.variables = {v.name: v for v in about.modelVariables}
        library = unpacked / "binaries" / "linux64" / f"{about.coSimulation.modelIdentifier}.so"
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


def planned(archive: Path, signals: list[str], folder: Path) -> Path:
    """The plan of an archive for the C host."""
    system = ssd.read_ssd(str(archive)).system
    unpacked = Path(fmpy.extract(str(archive), unzipdir=str(folder / "unpacked")))
    parts = {component.name: _Part(component, unpacked) for component in system.elements}
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


def flown(archive: Path, step: float, count: int, signals: list[str], interval: int, exchange: str) -> Floats:
    """The signals at the start and after each `interval` steps, by the C host. Raises AssertionError with its words."""
    with tempfile.TemporaryDirectory() as folder:
        plan = planned(archive, signals, Path(folder))
        words = [str(host()), str(plan), repr(step), str(count), str(interval), exchange]
        run = subprocess.run(words, capture_output=True, check=False)
    assert run.returncode == 0, run.stderr.decode()[-2000:]
    return np.frombuffer(run.stdout).reshape(-1, len(signals))


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


def main(names: list[str]) -> None:
    print("| scenario | one after the other, whole flight | all at once, first 120 s |\n|---|---|---|", flush=True)
    for path in SCENARIOS:
        if names and path.stem not in names:
            continue
        with tempfile.TemporaryDirectory() as folder:
            whole = max(d.max() for d in compared(plain(path), Path(folder)).values())
            at_once = next(iter(compared(plain(path), Path(folder), "parallel").values())).max()
        print(f"| `{path.stem}` | {'same bits' if whole == 0.0 else f'{whole:.2g}'} | {at_once:.2g} rad |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
