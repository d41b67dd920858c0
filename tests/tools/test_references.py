"""Other tools reproduce the reference data that our FMUs carry, read from the FMU as a user of the tool would."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pandas
import pytest
from fmpy.util import read_csv
from lxml import etree

from fmus.build import ensure
from fmus.contents.references import FOLDER
from fmus.interface import BLOCKS as ALL
from fmus.interface import load
from tests.native.test_fmi3 import three

from .measure import ONES, Recipe
from .test_importers import needs

pytestmark = pytest.mark.thorough

READ = """\
import json, sys
fmu, step, start, names, inputs, outputs = json.loads(sys.stdin.read())  # inputs: a row of numbers an instant
"""
SCRIPTS = {
    "FMPy": """
import numpy as np
from fmpy import simulate_fmu
columns = [("time", float), *((name, float) for name in names)]
signals = np.array([(step * k, *row) for k, row in enumerate(inputs)], dtype=columns)
end = step * (len(inputs) - 1)
result = simulate_fmu(
    fmu, stop_time=end, output_interval=step, start_values=start, input=signals, output=outputs
)
rows = [[float(row[name]) for name in outputs] for row in result][1:]
""",
    "libcosim": """
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
log_output_level(CosimLogLevel.ERROR)
execution = CosimExecution.from_step_size(round(1e9 * step))
block = execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name="block"))
reference = {v.name.decode(): v.reference for v in execution.slave_variables(block)}
for name, value in {**start, **dict(zip(names, inputs[0]))}.items():
    set_initial = execution.string_initial_value if isinstance(value, str) else execution.real_initial_value
    set_initial(block, reference[name], value)
observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
execution.add_observer(observer), execution.add_manipulator(manipulator)
rows = []
for row in inputs[:-1]:
    manipulator.slave_real_values(block, [reference[name] for name in names], row)
    execution.step()
    rows.append(observer.last_real_values(block, [reference[name] for name in outputs]))
""",
    "ecos": """
from ecospy import EcosSimulation, EcosSimulationStructure
structure = EcosSimulationStructure()
structure.add_model("block", fmu)
structure.add_parameter_set("start", {f"block::{k}": v for k, v in {**start, **dict(zip(names, inputs[0]))}.items()})
rows = []
with EcosSimulation(structure=structure, step_size=step) as simulation:
    simulation.init(parameter_set="start")
    for row in inputs[:-1]:
        for name, value in zip(names, row):
            simulation.set_real(f"block::{name}", value)
        simulation.step()
        rows.append([simulation.get_real(f"block::{name}") for name in outputs])
""",
}
BLOCKS = ("plant", "controller", "allocator")


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("recipe", ONES, ids=lambda r: r.tool)
def test_a_tool_reproduces_what_the_fmu_carries(recipe: Recipe, block: str, tmp_path: Path) -> None:
    needs(recipe)
    fmu = tmp_path / f"{block}.fmu"
    fmu.write_bytes(ensure(block).read_bytes())
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(tmp_path / "unpacked", [n for n in archive.namelist() if n.startswith(FOLDER)])
    folder = tmp_path / "unpacked" / FOLDER
    given, expected = (pandas.read_csv(folder / name) for name in ("inputs.csv", "outputs.csv"))
    values = {p.get("name"): p[0] for p in etree.parse(str(folder / "parameters.ssv")).findall(".//{*}Parameter")}
    start = {k: v.get("value") if v.tag.endswith("String") else float(v.get("value")) for k, v in values.items()}
    experiment = etree.parse(str(folder / "smoke-test.exp")).find("Experiment")
    step = float(experiment.get("stepSize"))
    tolerances = {t.get("name"): float(t.get("absolute")) for t in experiment.iter("Tolerance")}
    names, outputs = list(given)[1:], list(tolerances)
    task = (str(fmu), step, start, names, given[names].to_numpy().tolist(), outputs)
    script = f"{READ}{SCRIPTS[recipe.tool]}\nprint('\\n@' + json.dumps(rows))"
    run = subprocess.run(
        [sys.executable, "-c", script],
        input=json.dumps(task),
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert run.returncode == 0, run.stdout[-2000:] + run.stderr[-2000:]
    rows = np.array(json.loads(run.stdout.rpartition("\n@")[2]))
    assert len(rows) == len(expected) - 1
    for i, name in enumerate(outputs):
        difference = np.abs(rows[:, i] - expected[name][1:]).max()
        assert difference <= tolerances[name], f"{name}: {difference}"


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("block", ALL)
def test_fmpy_maps_every_column_of_the_inputs(
    block: str, version: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It warns of an input without a column, and passes over a column without an input; of FMI 3.0 by its reader."""
    fmu = ensure(block, here=True) if version == 2 else three(block)
    folder = Path(fmpy.extract(str(fmu), unzipdir=str(tmp_path))) / FOLDER
    given, expected = (folder / name for name in ("inputs.csv", "outputs.csv"))
    if version == 2:
        signals, wanted = (pandas.read_csv(path).to_records(index=False) for path in (given, expected))
    else:
        signals, wanted = read_csv(given), read_csv(expected)
    step = float(etree.parse(str(folder / "smoke-test.exp")).find("Experiment").get("stepSize"))
    values = {
        p.get("name"): p[0].get("value") for p in etree.parse(str(folder / "parameters.ssv")).iter("{*}Parameter")
    }
    start = values if version == 2 else _arrays(block, values)
    outputs = [name for name in wanted.dtype.names if name != "time"]
    result = fmpy.simulate_fmu(
        str(fmu), input=signals, start_values=start, output=outputs, output_interval=step, stop_time=signals["time"][-1]
    )
    assert "Warning" not in capsys.readouterr().out
    about = fmpy.read_model_description(str(fmu))
    assert {v.name for v in about.modelVariables if v.causality == "input"} == set(signals.dtype.names) - {"time"}
    for name in outputs:
        np.testing.assert_allclose(result[name], wanted[name], rtol=1e-6, atol=1e-6 * np.abs(wanted[name]).max())


def _arrays(block: str, values: dict[str, str]) -> dict[str, object]:
    """The start values of elements as those of arrays."""
    found: dict[str, object] = {}
    for variable in load(block).variables.values():
        if any(e.name in values for e in variable.elements):
            flat = [values.get(e.name, str(e.start)) for e in variable.elements]
            found[variable.name] = np.array(flat, float).reshape(variable.shape) if variable.shape else flat[0]
    return found
