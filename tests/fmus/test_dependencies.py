"""Declared dependencies against what changes: each input and parameter is moved, and every output looked at."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from scipy.spatial.transform import Rotation

from fmus.build import ensure
from fmus.interface import BLOCKS, InterfaceError, element_name, load, parse
from tests.blocks import some

from .feedthrough import declared_pairs, real_pairs, settings

Q0 = Rotation.from_rotvec([0.9, -0.7, 0.5]).as_matrix()
EXCITED: dict[str, dict[str, float | bool | int | str]] = {
    "plant": {
        **{f"Q0[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0)},
        **{f"omega_B0[{i}]": 0.01 * i for i in (1, 2, 3)},
        **{f"dipole_cmd[{i}]": 2.0 + i for i in (1, 2, 3)},
        "wheel_torque_cmd": 1e-3,
        "h_w0": 2e-3,
        "argument_of_latitude": 0.6,
    },
    "controller": {
        **{f"R_NB[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0)},
        **{f"omega_B[{i}]": 0.01 * i for i in (1, 2, 3)},
    },
    "controller, given reference": {
        **{f"R_NB[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0)},
        **{f"R_ref[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0.T)},
        **{f"omega_B[{i}]": 0.01 * i for i in (1, 2, 3)},
        **{f"Omega_ref[{i}]": 0.02 * i for i in (1, 2, 3)},
        **{f"dOmega_ref[{i}]": 1e-4 * i for i in (1, 2, 3)},
    },
    "allocator": {
        **{f"tau_cmd_B[{i}]": 1e-5 * i for i in (1, 2, 3)},
        **{f"omega_B[{i}]": 0.01 * i for i in (1, 2, 3)},
        "h_w": 1e-3,
    },
    "controller_planned": {
        **{f"R_NB[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0)},
        **{f"omega_B[{i}]": 0.02 * i for i in (1, 2, 3)},
        **{f"b_B[{i}]": 1e-5 * i for i in (1, 2, 3)},
        **{f"u_applied[{i}]": 1e-4 * i for i in (1, 2, 3, 4)},
        **{f"attitude_sigma_B[{i}]": 1e-3 * i for i in (1, 2, 3)},
        "h_w": 1e-3,
    },
    "controller_planned, given reference": {
        **{f"R_NB[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0)},
        **{f"R_ref[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0.T)},
        **{f"omega_B[{i}]": 0.02 * i for i in (1, 2, 3)},
        **{f"Omega_ref[{i}]": 0.002 * i for i in (1, 2, 3)},
        **{f"dOmega_ref[{i}]": 1e-5 * i for i in (1, 2, 3)},
        **{f"t_ahead[{k}]": 90.0 * k for k in range(1, 17)},
        **{f"turn_ahead[{k},{i}]": 0.01 * k * i for k in range(1, 17) for i in (1, 2, 3)},
        **{f"Omega_ahead[{k},{i}]": 1e-4 * i for k in range(1, 17) for i in (1, 2, 3)},
        **{f"b_B[{i}]": 1e-5 * i for i in (1, 2, 3)},
        "h_w": 1e-3,
    },
    **{
        f"supervisor, {command}": {
            **{f"R_NB[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0)},
            **{f"R_goal[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0.T)},
            "sun_N[1]": 0.6,
            "sun_N[2]": -0.48,
            "sun_N[3]": 0.64,
            "sunlight": 1.0,
            "target_latitude": 0.5,
            "target_longitude": 0.4,
            "target_height": 300.0,
            "rate_time": 0.0,
            "settled_time": 0.0,
            "settled_angle": 4.0,
            "settled_rate": 10.0,
            "command": command,
        }
        for command in (3, 4, 6, 7)
    },
    "plant_sensors": {
        **{f"R_NB[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0)},
        **{f"omega_B[{i}]": 0.01 * i for i in (1, 2, 3)},
        **{f"{name}_bias_B[{i}]": 1e-3 * i for name in ("attitude", "rate", "field") for i in (1, 2, 3)},
        **{f"{name}_noise": 1e-3 for name in ("attitude", "rate", "field", "wheel_momentum", "position", "velocity")},
        "h_w": 1e-3,
    },
    "estimator": {
        **{f"R_NB_measured[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0)},
        **{f"omega_B_measured[{i}]": 0.01 * i for i in (1, 2, 3)},
        **{f"sun_B_measured[{i}]": 0.2 * i for i in (1, 2, 3)},
        **{f"dipole[{i}]": 1.0 * i for i in (1, 2, 3)},
        **{f"rod_field[{i},{j}]": 1e-7 * (i + 2 * j) for i in (1, 2, 3) for j in (1, 2, 3)},
        "field_bias_sigma": 1e-6,
        "gate": 1e12,
        "rate_bias_sigma": 1e-2,
    },
    "plant_judge": {
        **{f"R_NB[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0)},
        **{f"R_d0[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0.T)},
        **{f"omega_B[{i}]": 0.01 * i for i in (1, 2, 3)},
        **{f"Omega_d0[{i}]": 0.02 * i for i in (1, 2, 3)},
        "reference": 3,
    },
    "plant_judge, given reference": {
        **{f"R_NB[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0)},
        **{f"R_d[{i + 1},{j + 1}]": v for (i, j), v in np.ndenumerate(Q0.T)},
        **{f"omega_B[{i}]": 0.01 * i for i in (1, 2, 3)},
        **{f"Omega_d[{i}]": 0.02 * i for i in (1, 2, 3)},
    },
}
"""Values under which every output has something to show; a block, and where it has several, the case."""
ROUNDING = 1e-11
"""Relative: a change below it is rounding, as of R_NB with the radius of the orbit."""


class Host:
    def __init__(self, path: Path, folder: Path, excited: dict[str, float | bool | int | str]) -> None:
        self.excited = excited
        self.description = read_model_description(str(path))
        self.variables = {v.name: v for v in self.description.modelVariables}
        extract(str(path), str(folder))
        identifier = self.description.coSimulation.modelIdentifier
        arguments = {"guid": self.description.guid, "modelIdentifier": identifier, "unzipDirectory": str(folder)}
        self.fmu = FMU2Slave(**arguments, instanceName="it")
        self.fmu.instantiate()

    def set(self, name: str, value: Any) -> None:
        v = self.variables[name]
        kind = {"Enumeration": "Integer"}.get(v.type, v.type)
        getattr(self.fmu, f"set{kind}")([v.valueReference], [value])

    def outputs(self, values: dict[str, Any]) -> dict[str, float] | None:
        """All outputs in initialization under these values; None where the block refuses them."""
        self.fmu.reset()
        try:
            for name, value in values.items():
                self.set(name, value)
            self.fmu.setupExperiment(startTime=0.0)
            self.fmu.enterInitializationMode()
            found = {}
            for v in self.description.modelVariables:
                if v.causality == "output":
                    kind = {"Enumeration": "Integer"}.get(v.type, v.type)
                    found[v.name] = float(getattr(self.fmu, f"get{kind}")([v.valueReference])[0])
            return found
        except Exception:
            return None

    def others(self, name: str) -> list[Any]:
        """Values to move a variable to."""
        v = self.variables[name]
        if v.type == "Real":
            start = float(self.excited.get(name, v.start))
            share = 3e-5 if name.startswith("R_") else 3e-3  # a rotation stays one to the blocks' tolerance
            return [start * (1.0 + share) + (1e-4 if start == 0.0 else 0.0), start * (1.0 - share)]
        if v.type == "Boolean":
            return [v.start != "true"]
        if v.type == "String":
            return ["2009-11-10T06:00:00Z"]
        return [n for n in (1, 2, 3, 4, 5, 6) if n != int(v.start)]


@pytest.mark.parametrize("case", EXCITED)
def test_nothing_changes_an_output_initially_but_what_it_declares(case, tmp_path):
    excited = EXCITED[case]
    host = Host(ensure(case.partition(",")[0], "native"), tmp_path, excited)
    declared = {u.variable.name: {d.name for d in u.dependencies} for u in host.description.initialUnknowns}
    base = host.outputs(excited)
    assert base is not None
    scale = {name: max(abs(v), 1e-9) for name, v in base.items()}
    undeclared, moved = [], 0
    for name, variable in host.variables.items():
        if variable.causality == "output":
            continue
        for other in host.others(name):
            now = host.outputs({**excited, name: other})
            if now is None:  # an inertia without its symmetry, say
                continue
            changed = [o for o in base if abs(now[o] - base[o]) > ROUNDING * scale[o]]
            moved += bool(changed)
            undeclared += [f"{o} changes with {name}" for o in changed if name not in declared[o]]
    host.fmu.freeInstance()
    assert not undeclared
    movable = sum(variable.causality != "output" for variable in host.variables.values())
    assert moved > movable // 4, "the test must see changes"


CAUTION = "the interface also stands in for another team's FMU that declares nothing, and whose law may use it"
TOGETHER = "it changes where all elements go from zero to a rotation at once"
BORDER = "it decides at the border of a field of view or of the threshold only whether there is a measurement"
GATE = "it decides at the gate, or at a limit of the deviation only; health, over many measurements"
BEGIN = "only in the step in which the filter starts"
LINE = "it follows a row or column alone; declared whole, as of a law that takes the nearest rotation"
UNSEEN = {
    "estimator": {
        (output, element.name): GATE if output in ("rejected", "attitude_valid", "sunlight", "health") else BEGIN
        for output, inputs in {
            "rejected": ("omega_B", "b_B", "r_N", "v_N", "R_NB", "sun_B"),
            "attitude_valid": ("omega_B", "b_B", "r_N", "v_N", "R_NB", "sun_B"),
            "sunlight": ("r_N", "v_N"),
            "covariance": ("b_B",),
            "attitude_sigma_B": ("b_B",),
            "attitude_bound": ("b_B",),
            "nis": ("b_B", "r_N", "v_N", "sun_B"),
            "health": ("omega_B", "b_B", "r_N", "v_N", "R_NB", "sun_B"),
        }.items()
        for name in inputs
        for element in load("estimator").variables[f"{name}_measured"].elements
    },
    **{
        block: {("no_attitude", element_name("R_NB", (i, j))): TOGETHER for i in (1, 2, 3) for j in (1, 2, 3)}
        for block in ("controller", "controller_planned", "plant_judge")
    },
    "allocator": {("dipole_cmd", "tau_cmd_B[1]"): CAUTION, ("", "omega_B[1]"): CAUTION},
    "allocator_bounded": {("", "omega_B[1]"): CAUTION},
    "controller_planned_wheels": {
        (output, element_name(name, (i, j))): LINE
        for output, name in (("R_d", "R_ref"), ("rate_error_B", "R_NB"))
        for i in (1, 2, 3)
        for j in (1, 2, 3)
    },
    "supervisor": {("R_ref", f"v_N[{i}]"): "its Z axis follows the velocity in slews only" for i in (1, 2, 3)},
    "plant_sensors": {
        **{
            (output, element_name("R_NB", (i, j))): BORDER
            for output in ("R_NB_measured", "attitude_sample", "sun_sample")
            for i in (1, 2, 3)
            for j in (1, 2, 3)
        },
        **{("sun_sample", f"r_N[{i}]"): BORDER for i in (1, 2, 3)},
    },
}
UNSEEN |= {f"{block}_wheels": UNSEEN[block] for block in ("estimator", "plant_sensors")}
"""Declared, and never seen: by output, all of them where it is empty, and element of an input."""


# The flavours give the same outputs (tests/native/test_flavours.py).
@pytest.mark.parametrize(
    "case",
    some(
        [(block, flavour) for block in BLOCKS for flavour in load(block).flavours],
        *((block, "native") for block in BLOCKS),
    ),
    ids="-".join,
)
def test_outputs_follow_at_once_the_inputs_that_they_declare_and_no_others(case):
    block, flavour = case
    real, declared = real_pairs(ensure(block, flavour), block, POINTS.get(block, 24)), declared_pairs(block)
    assert sorted(real - declared) == []
    listed = UNSEEN.get(block, {})
    unseen = {
        pair for pair in declared - real if not any((o, pair[1]) in listed for o in (pair[0].partition("[")[0], ""))
    }
    assert sorted(unseen) == []
    known = {(output.partition("[")[0], element) for output, element in declared - real}
    for output, element in listed:
        assert any(element == e and output in (o, "") for o, e in known), f"{element} is seen: take it off the list"


POINTS = {
    "plant_wheels": 64,
    "controller_planned_wheels": 64,
    "controller_wheels": 64,
    "allocator_bounded_wheels": 64,
    "controller_planned": 256,
    "allocator": 80,
    "estimator": 32,
    "estimator_wheels": 32,
    "supervisor": 10,
}


@pytest.mark.parametrize(
    ("block", "parameters", "at_one_state", "at_many"),
    [
        ("plant_sensors", {"attitude_bias_B": [0.0, 0.0, 0.0]}, 69, 387),
        ("controller_planned", next(settings("controller_planned")), 168, 320),
    ],
)
def test_at_one_state_fewer_pairs_are_seen_than_there_are(block, parameters, at_one_state, at_many):
    """An attitude without error is passed on element by element, one with an error is a product of matrices; and
    steering, plan, either reference and optional inputs that are not connected have pairs of their own."""
    seen = real_pairs(ensure(block, "native"), block, 1, parameters=[parameters])
    assert len(seen) == at_one_state
    assert seen < declared_pairs(block)
    unseen = {pair for pair in declared_pairs(block) if pair[0] == "no_attitude"}
    assert len(declared_pairs(block) - unseen) == at_many


@pytest.mark.parametrize(
    ("depends_on", "expected"),
    [
        ("matrix[i]", ["matrix[2,1]"]),
        ("matrix[i,:]", ["matrix[2,1]", "matrix[2,2]"]),
        ("matrix[:,i]", ["matrix[1,2]", "matrix[2,2]"]),
        ("matrix", ["matrix[1,1]", "matrix[1,2]", "matrix[2,1]", "matrix[2,2]"]),
    ],
)
def test_a_dependency_names_an_element_a_row_a_column_or_all(depends_on, expected):
    parsed = parse(SMALL.format(depends_on=depends_on))
    assert [e.name for e in parsed.feedthrough(parsed.variables["out"], 2)] == expected
    with pytest.raises(InterfaceError, match="out: depends_on: 'vector\\[i,:\\]' does not fit the shapes"):
        parse(SMALL.format(depends_on="vector[i,:]"))


SMALL = """
[block]
name = "small"
description = "of two ports"
[experiment]
stop = 1.0
step = 0.1
[variables.matrix]
causality = "input"
shape = [2, 2]
description = "in"
start = [[0.0, 0.0], [0.0, 0.0]]
[variables.vector]
causality = "input"
shape = [2]
description = "in"
start = [0.0, 0.0]
[variables.out]
causality = "output"
shape = [2, 2]
description = "out"
depends_on = ["{depends_on}"]
"""
