"""Test vectors: inputs over time, and the outputs that our block gives for them, as two tables.

`parameters.csv` has a parameter's element and its value in each row, items of enumerations as numbers;
`vector.csv` has time, inputs and outputs in columns, in the units of our interface.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fmus import kit

from ..errors import InputError
from ..fmu.archive import shown
from ..fmu.interfaces import reference
from ..fmu.model import Floats
from ..scenario.references import Name
from ..scenario.scenario import Scenario
from ..scenario.source import Source
from ..session.read import load
from ..session.run import whole
from ..swap.findings import Finding, Fit
from ..system.values import values_of
from ..system.wiring import fed
from . import playback
from .difference import difference
from .tables import columns_of, csv_text, parameters_of, read_table
from .tolerances import Bound, both

ROWS_MAX = 400
"""Steps of a scenario that become a test vector, at most."""


def record(scenario: Path, block: str, folder: Path) -> int:
    """Runs a scenario and writes what `block` was given and what it gave. Returns the number of instants."""
    loaded = load(scenario)
    name = name_of(loaded, block)
    if name is None:
        raise InputError(f"{shown(scenario)} has no block {block!r} that is the project's own; expected 'fmu: {block}'")
    source = loaded.source.without([(key,) for key in ("expect", "figures", "holds", "faults", "timeline", "phases")])
    step = loaded.step * loaded.blocks[name].every
    changes = {
        "duration": step * min(ROWS_MAX, int(loaded.duration / step + 1e-6)),
        "record": {"interval": step, "signals": [f"{name}.{port}" for port in _ports(loaded, name, block)]},
    }
    for key, value in changes.items():
        source = source.with_entry((key,), value)
    result = whole(load(source))
    if result.failure is not None:
        raise InputError(f"{shown(scenario)}: {result.failure}")
    ours = [i for i, node in enumerate(result.columns) if node.block == name]  # flags of the others are recorded, too
    folder.mkdir(parents=True, exist_ok=True)
    header = ["time", *(result.labels[i].partition(".")[2] for i in ours)]
    pairs = zip(result.time.tolist(), result.samples[:, ours].tolist(), strict=True)
    rows = [[repr(time), *map(repr, row)] for time, row in pairs]
    (folder / "vector.csv").write_text(csv_text([header, *rows]), "utf-8", newline="")
    model, parameters = result.models[name], []
    for key, value in result.manifest["scenario"]["blocks"][name].get("start", {}).items():
        for element, number in values_of(name, model, Name(key), value).items():
            if model.variables[element.variable].causality == "parameter":
                text = int(number) if isinstance(number, bool) else number
                parameters.append([model.variables[element.variable].label(element.position), text])
    (folder / "parameters.csv").write_text(csv_text([["name", "value"], *parameters]), "utf-8", newline="")
    return len(result.time)


def scenario_of(block: str) -> Path:
    """Returns a run of the project in which a block has a part: the kits' own, else the shortest. Raises InputError."""
    if name_of(load(kit.SCENARIO), block):
        return kit.SCENARIO
    runs = {run: load(run) for run in sorted(kit.SCENARIO.parent.glob("*.yaml"))}
    found = min((run for run in runs if name_of(runs[run], block)), key=lambda run: runs[run].duration, default=None)
    if found is None:
        remedy = f"remedy: --scenario FILE with 'fmu: {block}'"
        raise InputError(f"no scenario of the project has the block {block!r}; {remedy}")
    return found


def part_of(path: Path, block: str) -> tuple[Source, str]:
    """Returns a run, and how a block of the project is called in it. Raises InputError where it has no part in it."""
    scenario = load(path)
    name = name_of(scenario, block)
    if name is None:
        raise InputError(f"{shown(path)} has no block with the interface {block!r}")
    return scenario.source, name


def name_of(scenario: Scenario, block: str) -> str | None:
    """Returns how a block of the project is called in a scenario; None where it has no part in it."""
    return next((name for name, entry in scenario.blocks.items() if entry.fmu == block), None)


def _ports(scenario: Scenario, name: str, block: str) -> list[str]:
    """Outputs, and the inputs that the scenario feeds."""
    model = reference(block, Path.cwd()).model
    return [v.name for v in (*fed(scenario, name, model.of("input")), *model.of("output")) if v.type != "string"]


def play(fmu: Path, fitted: Fit, interface: str, folder: Path, tolerance: float) -> list[Finding]:
    """Returns how far an FMU's outputs are from those of a test vector, one finding an output.

    `interface`: the block of the project, or the FMU, in whose place it stands.
    """
    if fitted.fed:
        names = ", ".join(f"{signal} for {name}" for name, signal in fitted.fed.items())
        text = f"not run, since a test vector holds the ports of {fitted.reference.name} only, "
        text += f"and the mapping needs {names}"
        return [Finding("error", "vector", text, "orchestrate compare, which takes them from a run of the scenario")]
    model = fitted.reference.model
    header, table = read_table(folder / "vector.csv")
    columns = columns_of(model, header, folder)
    time = table[:, 0]
    inputs = {
        v.name: table[:, columns[v.name]].reshape(len(table), *v.shape).astype(v.dtype)
        for v in model.of("input")
        if v.name in columns
    }
    expected = {n: table[:, c] for n, c in columns.items() if model.variables[n].causality == "output"}
    if not expected:
        raise InputError(f"{folder / 'vector.csv'}:1: expected a column of an output of {model.name}, found none")
    start = parameters_of(model, folder, {*fitted.missing, *fitted.ignored})
    return compared(fmu, fitted, interface, time, inputs, expected, start, dict.fromkeys(expected, tolerance), "vector")


def compared(
    fmu: Path,
    fitted: Fit,
    interface: str,
    time: Floats,
    inputs: Mapping[str, Floats],
    expected: Mapping[str, Floats],
    start: Mapping[str, Any],
    tolerances: Mapping[str, float],
    topic: str,
) -> list[Finding]:
    """Returns how far an FMU's outputs on inputs (instants, *shape) are from those expected, one finding an output.

    `expected` are (instants, elements), NaN where nothing is; `tolerances` are relative to an output's largest value.
    """
    model = fitted.reference.model
    entry: dict[str, Any] = {"fmu": str(fmu.resolve()), "interface": interface, "start": dict(start)}
    if fitted.mapping is not None:
        entry["map"] = fitted.mapping.model_dump(exclude_none=True)
    played = playback.play("block", entry, ".", time, inputs)
    if played.failure is not None:
        return [Finding("error", topic, str(played.failure), "see what the FMU logged")]
    findings = []
    for name, wanted in expected.items():
        if name not in played.outputs:
            continue
        peak = float(np.nanmax(np.abs(wanted))) or 1.0
        bound = both(Bound(absolute=tolerances[name] * peak))
        at = played.rows
        apart = difference(model.variables[name], wanted[at], played.outputs[name], time[at], bound)
        text = f"{name}: as expected"
        if apart.largest:
            size = f"{apart.largest:.3g} {apart.unit}".rstrip()
            text = f"{name}: differs by at most {size}, {apart.largest / peak:.2g} of its largest value"
            text += "" if apart.time is None else f", at {apart.time:.10g} s"
        findings.append(Finding("ok", topic, text) if apart.passed else Finding("error", topic, text, _OTHER))
    return findings


_OTHER = "with the same equations: look at the units and signs, then at --tolerance; others give other outputs"
