"""Plays the reference data that an FMU carries (FMI-LS-REF) and holds its outputs against those of its maker."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..fmu.model import TYPES, Floats, Model
from ..instances.slave import asks_to_end
from ..quantities import suffix
from ..swap.findings import Finding
from . import experiments, playback
from .difference import ROUNDING
from .experiments import Experiment, Table

_TOPIC = "reference"
_TIMEOUT = "10 s"
"""That a call may take."""


def look(path: Path, model: Model, default: Any, tolerance: float, findings: list[Finding]) -> None:
    """Plays every experiment, in a process of its own. `tolerance` counts where an experiment has none."""
    try:
        found, notes = experiments.read(path, model, default)
    except InputError as error:
        findings.append(Finding("error", _TOPIC, str(error), "correct the reference data of the FMU"))
        return
    findings += [
        Finding("warning", _TOPIC, f"not played: {note}", "play it in the tool that wrote it") for note in notes
    ]
    for experiment in found:
        findings += play(path, model, experiment, tolerance)


def play(
    path: Path, model: Model, experiment: Experiment, tolerance: float, isolation: str = "process"
) -> list[Finding]:
    """Returns a finding for each output beyond its tolerance, or one that all are as expected."""
    name = experiment.name
    steps = int(experiment.stop / experiment.step * (1.0 + 1e-12))
    time = np.asarray(experiment.step * np.arange(steps + 1), np.float64)
    entry = {"fmu": str(path.resolve()), "start": experiment.start, "isolation": isolation}
    if isolation == "process":
        entry["timeout"] = _TIMEOUT
    try:
        played = run(entry, model, time, experiment.stimuli)
    except InputError as error:
        return [Finding("error", _TOPIC, f"{name}: {error}", "correct the reference data of the FMU")]
    expected_to = min(experiment.stop, float(experiment.references.time[-1]))
    time = time[: len(next(iter(played.outputs.values()), time))]
    ended = ""
    if played.failure is not None:
        if not asks_to_end(played.failure):
            return [Finding("error", _TOPIC, f"{name}: {played.failure}", "see what the FMU logged")]
        ended = f"it ends the simulation after {time[-1]:.10g} s"
        if expected_to > (time[-1] + experiment.step) * (1.0 + 1e-9):
            text = f"{name}: {ended}; its reference data go on to {expected_to:.10g} s"
            return [Finding("error", _TOPIC, text, "see whether FMU and reference data are of one version")]
    wrong, shares = [], []
    chosen = experiment.references.time <= min(experiment.stop, time[-1]) * (1.0 + 1e-12)
    instants, places = np.unique(experiment.references.time[chosen], return_inverse=True)
    for element, expected in experiment.references.columns.items():
        variable = model.variables[element.variable]
        if variable.name not in played.outputs:
            continue
        wanted = expected[chosen]
        given = played.outputs[variable.name][:, element.position]
        given = _at(instants, time, given, between=variable.type == "real")[places]
        difference = np.full(
            len(instants), np.inf
        )  # of two rows at one time, before and after an event, either will do
        np.minimum.at(difference, places, np.where(np.isnan(given), np.inf, np.abs(given - wanted)))
        peak = float(np.abs(wanted).max())
        share = experiment.tolerance if experiment.tolerance is not None else tolerance
        limit = experiment.tolerances.get(element, share * peak if variable.type == "real" else 0.0) + ROUNDING
        row = int(difference.argmax())
        shares.append((float(difference[row]) / limit, variable.label(element.position)))
        if difference[row] > limit:
            label, largest = variable.label(element.position), float(difference[row])
            text = f"{name}: {label} differs by {largest:.3g}{suffix(variable.unit)} at {instants[row]:.10g} s"
            text += f"; expected at most {limit:.3g}"
            wrong.append(Finding("error", _TOPIC, text, "see whether FMU and reference data are of one version"))
    if wrong:
        return wrong
    if not shares:
        return [
            Finding("warning", _TOPIC, f"{name}: none of its signals is an output", "name outputs in its references")
        ]
    largest, label = max(shares)
    text = f"{name}: {len(shares)} outputs as expected over {time[-1]:.10g} s"
    text += f"; the largest difference is {largest:.2g} of its tolerance ({label})" if largest else ", to the last bit"
    tables = (experiment.references, experiment.stimuli)
    left = [f"{label} is left out" for table in tables if table is not None for label in table.left_out]
    return [Finding("ok", _TOPIC, "; ".join(filter(None, (text, ended, *left))))]


def run(entry: dict[str, Any], model: Model, time: Floats, stimuli: Table | None) -> playback.Played:
    """Plays the block of a scenario's entry, the inputs of each instant being set before the step that begins there.

    That is how FMI's importers read a file of inputs; a run of this project sets those of the step's end.
    """
    inputs: dict[str, Floats] = {}
    start = dict(entry["start"])
    for variable in model.of("input"):
        columns = stimuli.columns if stimuli is not None else {}
        given = {p: columns[e] for p, e in enumerate(variable.elements) if e in columns}
        if stimuli is None or not given or variable.type not in TYPES:
            items: dict[Any, Any] = {number: item for item, number in variable.items}
            for position, element in enumerate(variable.elements):  # a scenario asks for what feeds every input
                own = model.starts.get(element)
                start.setdefault(variable.label(position).replace("][", ","), items.get(own, own))
            continue
        values = np.empty((len(time), variable.size))
        for position, element in enumerate(variable.elements):
            if position not in given:
                values[:, position] = float(model.starts.get(element, 0.0))
            else:
                between = variable.type == "real" and variable.variability == "continuous"
                values[:, position] = _at(time, stimuli.time, given[position], between)
        before = np.concatenate([values[:1], values[:-1]]).reshape(len(time), *variable.shape)
        inputs[variable.name] = before.astype(variable.dtype)
    return playback.play("block", {**entry, "start": start}, ".", time, inputs)


def _at(instants: Floats, time: Floats, values: Floats, between: bool) -> Floats:
    """Returns values at instants: those of the same time but for rounding; else a line `between` two, or the last."""
    last = np.searchsorted(time, instants * (1.0 + 1e-9) + 1e-12, side="right") - 1
    exact = np.abs(time[last] - instants) <= 1e-9 * instants + 1e-12
    found: Floats = np.where(exact | (not between), values[last], np.interp(instants, time, values))
    return found
