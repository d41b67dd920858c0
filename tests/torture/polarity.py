"""Flies every wrong wiring of V.B and of the tumble, and the FMUs of other teams; docs/use/polarity.md has the results.

Prints what is found, by what, and what mends it.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import click

from orchestration.acceptance.polarity import page
from orchestration.acceptance.polarity.mend import as_yaml
from orchestration.acceptance.polarity.swaps import Looked, look
from orchestration.acceptance.polarity.trials import run
from orchestration.session.read import read
from orchestration.swap.option import swapped, swaps_of

from ..orchestration.acceptance import teams

ROOT = Path(__file__).parents[2]
FLOWN = ("paper_no_singularity", "flight_tumble")
EXAMPLE = ROOT / "examples" / "hardware_allocator"
MENDED = {"b_B": "+y -x +z", "dipole_cmd": "+z +x +y", "wheel_torque_cmd": "opposite sign"}
"""What the example's drivers behave as."""


@click.command("polarity")
def command() -> None:
    """Wrong wirings of the scenarios and of other teams' FMUs; exit status 1 where one is neither found nor
    explained."""
    bad: list[str] = []
    for name in FLOWN:
        begun = perf_counter()
        trials = run(_scenario(name))
        seconds = perf_counter() - begun
        print(f"{name}: {page.verdict(trials)}, in {seconds:.0f} s")
        bad += [
            f"{name}: {row.port.name} {row.wrong}: no reason"
            for row in trials.rows
            if not (row.found or row.unobservable)
        ]
        bad += [f"{name}: false alarm: {trials.nominal}"] if trials.nominal else []
        print(page.markdown(trials, name))
    with tempfile.TemporaryDirectory() as folder:
        print(_teams(Path(folder), bad))
    for text in bad:
        print(text)
    sys.exit(1 if bad else 0)


def _scenario(name: str):
    return read(ROOT / "scenarios" / f"{name}.yaml")


def _teams(folder: Path, bad: list[str]) -> str:
    """The other teams' FMUs: a row for each."""
    ours = _scenario("paper_no_singularity")
    rows = [
        "| FMU | in the place of | behaves as | difference from ours as wired, corrected | seconds |",
        "| --- | --- | --- | --- | --- |",
    ]
    subprocess.run(["make", "-s", "-C", str(EXAMPLE)], check=True)
    cases = {name: (team.block, teams.build(name, folder), team.behaves) for name, team in teams.TEAMS.items()}
    cases["hardware_allocator"] = ("allocator", EXAMPLE / "actuators.fmu", MENDED)
    for name, (block, fmu, expected) in cases.items():
        begun = perf_counter()
        looked: Looked = look(ours, swapped(ours, swaps_of([f"{block}={fmu}"])), [block])
        seconds = perf_counter() - begun
        behaves = {port: wrong for mended in looked.mended for port, wrong in mended.behaves.items()}
        told = {port: wrong for port, wrong in behaves.items() if port in expected}
        print(f"{name}: {behaves}, in {seconds:.0f} s")
        if told != expected or looked.left is not None:
            bad.append(f"{name}: expected {expected}, found {behaves}; left: {looked.left}")
        for mended in looked.mended:
            print(as_yaml(mended.mapping))
            shares = f"{100 * mended.before:.3g} %, {100 * mended.after:.2g} %"
            words = "; ".join(f"`{port}`: {wrong}" for port, wrong in mended.behaves.items())
            rows.append(f"| {name} | {block} | {words} | {shares} | {seconds:.0f} |")
    return "\n".join(rows)
