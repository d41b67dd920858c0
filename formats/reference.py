"""An attitude ephemeris as a moving reference: attitude, rate and acceleration at each step, for every block that takes
them. Tests: tests/formats/test_reference.py."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from orchestration.errors import InputError, Place, Problem
from orchestration.scenario.scenario import Scenario
from orchestration.session.open import open_fmus
from orchestration.session.read import load

Floats = NDArray[np.float64]
BLOCK = "reference"
"""The name of the record in the scenario."""
SETS = (("R_ref", "Omega_ref", "dOmega_ref"), ("R_d", "Omega_d"))
"""Inputs that take attitude, rate and acceleration of a reference, as controllers and judges have them."""
AHEAD = ("t_ahead", "turn_ahead", "Omega_ahead")
"""Inputs for the reference to come, which an ephemeris of the past may not have."""


def moving(scenario: Path, out: Path, times: Floats, q: Floats, place: Place) -> tuple[str, str, int]:
    """Returns the scenario and the table (texts), and its number of rows, of a reference with these quaternions.

    times (n,) s, q (n, 4) scalar first, N from body. Between them a spline of rotations is taken, whose rate and
    acceleration are continuous. `place` is that of the ephemeris. Raises InputError where it does not begin by t = 0,
    or where no block takes a reference.
    """
    loaded = load(scenario)
    if len(times) < 3 or times[0] > 1e-9 or times[-1] < loaded.step:
        expected = "three attitudes or more, from t = 0 or before to a step or more after it"
        raise InputError(Problem(expected=expected, found=f"{times[0]:.10g} s to {times[-1]:.10g} s", place=place))
    end = min(loaded.duration, float(times[-1]))
    steps = np.arange(int(end / loaded.step + 1e-6) + 1)
    at = np.minimum(steps * loaded.step, times[-1])
    columns = np.column_stack([steps * loaded.step, *_motion(times, q, at)])
    header = ["t", *(f"R{i}{j}" for i in "123" for j in "123"), *(f"{v}{i}" for v in "wa" for i in "123")]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([header, *([repr(x) for x in row] for row in columns.tolist())])
    data: dict[str, Any] = {
        "extends": str(Path(scenario).resolve()),
        "name": out.stem,
        "duration": f"{steps[-1] * loaded.step:.10g} s",
        "expect": [],  # those of the scenario are about another reference
        "blocks": {BLOCK: {"telemetry": _telemetry(f"{out.stem}.csv", header)}},
        "connections": _connections(loaded),
    }
    return yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=120), text.getvalue(), len(steps)


def _motion(times: Floats, q: Floats, at: Floats) -> tuple[Floats, Floats, Floats]:
    """Attitude (m, 9), and rate and acceleration (m, 3) in the desired body's axes, rad/s and rad/s2."""
    from scipy.spatial.transform import Rotation, RotationSpline  # 0.2 s, for this alone  # noqa: PLC0415

    spline = RotationSpline(times, Rotation.from_quat(q[:, [1, 2, 3, 0]]))
    return spline(at).as_matrix().reshape(-1, 9), spline(at, 1), spline(at, 2)  # both in the turning axes


def _telemetry(file: str, header: Sequence[str]) -> dict[str, Any]:
    matrix = [list(header[i : i + 3]) for i in (1, 4, 7)]
    columns = {
        "R_ref": {"of": matrix},
        "Omega_ref": {"of": list(header[10:13]), "unit": "rad/s"},
        "dOmega_ref": {"of": list(header[13:]), "unit": "rad/s2"},
    }
    return {"file": file, "time": {"column": "t", "scale": "elapsed"}, "columns": columns}


def _connections(loaded: Scenario) -> list[str]:
    """Those of the scenario without what has fed a reference, and those from the record."""
    takes: dict[str, str] = {}
    for name, fmu in open_fmus(loaded).items():
        inputs = {v.name for v in fmu.model.of("input")}
        for ports in SETS:
            if set(ports) <= inputs:
                takes |= {f"{name}.{port}": f"{BLOCK}.{_source(port)}" for port in ports}
                takes |= {f"{name}.{port}": "" for port in AHEAD if port in inputs}
    if not takes:
        expected = "a block with the inputs R_ref, Omega_ref and dOmega_ref"
        raise InputError(Problem(expected=expected, found="none", place=Place("--scenario")))
    kept = [text for text in loaded.source.data.get("connections", []) if _target(text) not in takes]
    return [*kept, *(f"{source} -> {target}" for target, source in takes.items() if source)]


def _source(port: str) -> str:
    return {"R_d": "R_ref", "Omega_d": "Omega_ref"}.get(port, port)


def _target(connection: str) -> str:
    return connection.partition("->")[2].partition("[")[0].strip()
