"""A vendor's recorded log against our FMU, open loop: the log of our own loop is met, and a wrong sign is found."""

import csv
from dataclasses import replace
from pathlib import Path

import pytest

from fmus.build import ensure
from orchestration import InputError, run
from orchestration.acceptance.check import check
from orchestration.acceptance.log import against_log

SCENARIO = Path(__file__).parents[3] / "scenarios" / "paper_no_singularity.yaml"
PORTS = {"R_NB": 9, "omega_B": 3, "r_N": 3, "v_N": 3, "tau_cmd_B": 3}
UNITS = {"omega_B": "deg/s", "r_N": "km", "v_N": "m/s", "tau_cmd_B": "N.m"}


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """The controller's ports of a run, as a log with the units of a laboratory."""
    folder = tmp_path_factory.mktemp("log")
    result = run(SCENARIO, duration=20.0)
    factors = {"omega_B": 57.29577951308232, "r_N": 1e-3}
    header, columns = ["seconds"], [result.time.tolist()]
    for port, size in PORTS.items():
        block = "controller" if port == "tau_cmd_B" else "plant"
        names = [i for i, label in enumerate(result.labels) if label.startswith(f"{block}.{port}[")]
        assert len(names) == size
        header += [f"{port}{k}" for k in range(size)]
        columns += [(result.samples[:, i] * factors.get(port, 1.0)).tolist() for i in names]
    with (folder / "log.csv").open("w", newline="") as file:
        csv.writer(file).writerows([header, *zip(*columns, strict=True)])
    lines = ["telemetry:", "  file: log.csv", "  time: {column: seconds, scale: elapsed}", "  columns:"]
    for port, size in PORTS.items():
        of = [f"{port}{k}" for k in range(size)]
        lines.append(f"    {port}: {{of: [{', '.join(of)}], unit: {UNITS.get(port, '1')!r}}}")
    start = result.manifest["scenario"]["blocks"]["controller"]["start"]
    parameters = {name: value for name, value in start.items() if name not in PORTS}
    (folder / "log.yaml").write_text("\n".join([*lines, f"start: {parameters!r}"]), "utf-8")
    return folder / "log.yaml"


def test_our_controller_meets_the_log_of_its_own_run(log):
    fmu = ensure("controller")
    _, fitted = check(fmu, "controller", tolerance=None)
    (finding,) = against_log(fmu, fitted, "controller", log, 1e-9)
    assert finding.level == "ok", finding


def test_a_sign_in_the_log_is_found(log, tmp_path):
    text = log.read_text().replace("tau_cmd_B:", "tau_cmd_B_: ").replace("tau_cmd_B_: ", "tau_cmd_B:")
    turned = text.replace("omega_B: {", "omega_B: {matrix: [[-1, 0, 0], [0, 1, 0], [0, 0, 1]], ")
    for name in ("log.csv",):
        (tmp_path / name).write_bytes((log.parent / name).read_bytes())
    (tmp_path / "log.yaml").write_text(turned, "utf-8")
    fmu = ensure("controller")
    _, fitted = check(fmu, "controller", tolerance=None)
    (finding,) = against_log(fmu, fitted, "controller", tmp_path / "log.yaml", 1e-9)
    assert finding.level == "error"
    assert replace(finding).topic == "log"


def test_an_input_of_the_log_without_a_sample_is_refused_at_its_line(log, tmp_path):
    rows = list(csv.DictReader((log.parent / "log.csv").open(newline="")))
    with (tmp_path / "log.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows({**row, "omega_B1": "nan"} for row in rows)
    (tmp_path / "log.yaml").write_text(log.read_text(), "utf-8")
    fmu = ensure("controller")
    _, fitted = check(fmu, "controller", tolerance=None)
    with pytest.raises(InputError, match=r"log.yaml:6: telemetry.columns.omega_B: .*expected a sample, found none"):
        against_log(fmu, fitted, "controller", tmp_path / "log.yaml", 1e-9)


def test_an_input_that_the_log_does_not_have_is_refused_at_its_columns(log, tmp_path):
    (tmp_path / "log.csv").write_bytes((log.parent / "log.csv").read_bytes())
    kept = [line for line in log.read_text().splitlines() if "r_N:" not in line]
    (tmp_path / "log.yaml").write_text("\n".join(kept), "utf-8")
    fmu = ensure("controller")
    _, fitted = check(fmu, "controller", tolerance=None)
    with pytest.raises(InputError, match=r"log.yaml:4: telemetry.columns: .*the input r_N is neither"):
        against_log(fmu, fitted, "controller", tmp_path / "log.yaml", 1e-9)


def test_a_log_that_begins_far_from_zero_is_refused_and_not_filled_up_from_there(log, tmp_path):
    header, *rows = csv.reader((log.parent / "log.csv").open(newline=""))
    with (tmp_path / "log.csv").open("w", newline="") as file:
        csv.writer(file).writerows([header, *([str(float(row[0]) + 1.7e9), *row[1:]] for row in rows)])
    (tmp_path / "log.yaml").write_text(log.read_text(), "utf-8")
    fmu = ensure("controller")
    _, fitted = check(fmu, "controller", tolerance=None)
    with pytest.raises(InputError, match=r"log.yaml:2: .*at most 5000000 steps.*the first row, 1700000000 s"):
        against_log(fmu, fitted, "controller", tmp_path / "log.yaml", 1e-9)


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("unit: 'deg/s'", "unit: 'kg'", "3 values in 'kg'"),
        ("omega_B0, omega_B1, omega_B2", "omega_B0, omega_B1", "2 val"),
    ],
)
def test_a_port_with_another_unit_or_number_of_columns_is_refused(log, tmp_path, old, new, found):
    (tmp_path / "log.csv").write_bytes((log.parent / "log.csv").read_bytes())
    assert old in log.read_text("utf-8")
    (tmp_path / "log.yaml").write_text(log.read_text("utf-8").replace(old, new), "utf-8")
    fmu = ensure("controller")
    _, fitted = check(fmu, "controller", tolerance=None)
    with pytest.raises(InputError, match=f"expected 3 values in 'rad/s', found {found}"):
        against_log(fmu, fitted, "controller", tmp_path / "log.yaml", 1e-9)
