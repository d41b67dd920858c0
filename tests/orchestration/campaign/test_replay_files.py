"""A campaign whose blocks are a law in Python and a record: their files are found from a replayed run's folder, and a
law that ends the process does not end the campaign with status 0."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from .toy import FILE, ROOT, command, fly, rows

LAW = "def step(inputs, parameters, t, h):\n    return {'tau_cmd_B': -0.02 * parameters.J_B @ inputs.omega_B}\n"
SCENARIO = """\
name: own
step: 0.1 s
duration: 2 s
blocks:
  controller:
    python: my_law.py
    start: {R_NB: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], r_N: [7e6, 0, 0], v_N: [0, 7500, 0]}
  log:
    telemetry: {file: log.csv, time: {column: t, scale: elapsed}, columns: {omega_B: {of: [x, y, z], unit: rad/s}}}
connections: [log.omega_B -> controller.omega_B]
"""


@pytest.fixture
def own(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("my_law.py").write_text(LAW)
    Path("log.csv").write_text("t,x,y,z\n" + "".join(f"{0.1 * k},{k},0,0\n" for k in range(25)))
    Path("own.yaml").write_text(SCENARIO)
    entry = "{name: final, signal: 'controller.tau_cmd_B[1]', statistic: final}"
    text = (
        FILE[: FILE.index("metrics:")].replace("loop.yaml", "own.yaml").replace("motor.speed0", "'controller.J_B[1,1]'")
    )
    Path("own_campaign.yaml").write_text(f"{text.replace('1 rad/s, 2 rad/s', '1, 2')}metrics: [{entry}]\n")
    return Path("own_campaign.yaml")


@pytest.mark.fly
def test_a_run_with_a_law_and_a_record_is_replayed(own):
    fly(own, runs=3)
    result = command(own, "--out", "out", "--replay", 2)
    assert result.exit_code == 0
    assert rows()[2]["final"] == pytest.approx(-0.02 * 20 * rows()[2]["controller.J_B[1,1]"], rel=1e-12)


@pytest.mark.fly
@pytest.mark.skipif(sys.platform != "linux", reason="a campaign is waited for on Linux alone")
def test_a_law_that_ends_the_process_does_not_end_the_campaign_with_status_0(own):
    own_scenario = Path("own.yaml").read_text()
    Path("own.yaml").write_text(own_scenario.replace("my_law.py", "my_law.py\n    isolation: none"))
    Path("my_law.py").write_text(LAW.replace("    return", "    if t > 1: __import__('os')._exit(0)\n    return"))
    line = [sys.executable, "-m", "orchestration", "campaign", str(own), "--workers", "0", "--runs", "3"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(line, env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 3
    assert "controller: step: ended the run with exit status 0; runs that are written are kept; remedy" in done.stderr
