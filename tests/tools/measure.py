"""What other tools make of our FMUs, beside what `orchestrate` makes of them. The recipes are what a user types."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import orchestration
from fmus.interface import load as interface
from orchestration import Scenario, load
from orchestration.cli.main import main

ROOT = Path(__file__).parents[2]
RECIPES = Path(__file__).parent / "recipes"
SCENARIO = ROOT / "scenarios" / "paper_no_singularity.yaml"
STEPS = (0.1, 0.05, 0.025)
DURATION = 120.0
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Recipe:
    """A script in recipes/, and what its tool is."""

    script: str
    tool: str
    package: str
    what: str
    exchange: str = "parallel"
    """Which exchange of ours it should match."""
    ahead: int = 0
    """By how many steps it shows a law's output earlier."""

    @property
    def text(self) -> str:
        return (RECIPES / self.script).read_text("utf-8")

    @property
    def version(self) -> str:
        return version(self.package)


ONES = (
    Recipe("fmpy_one.py", "FMPy", "FMPy", "one FMU, `simulate_fmu`"),
    Recipe("libcosim_one.py", "libcosim", "libcosimpy", "one FMU, its Python API"),
    Recipe("ecos_one.py", "ecos", "ecospy", "one FMU, its Python API"),
)
LOOPS = (
    Recipe("fmpy_ssp.py", "FMPy", "FMPy", "the loop from `adcs.ssp`"),
    Recipe("libcosim_ssp.py", "libcosim", "libcosimpy", "the loop from `adcs.ssp`"),
    Recipe("ecos_ssp.py", "ecos", "ecospy", "the loop from `adcs.ssp`", ahead=1),
    Recipe("fmpy_container.py", "FMPy", "FMPy", "the loop as one FMU", exchange="sequential"),
)


def prepare(folder: Path) -> None:
    """What the recipes read, made with the command line in this folder."""
    _orchestrate("fmus", "--copy", folder)
    for step in STEPS:
        inner = folder / f"step_{step:g}"
        inner.mkdir()
        _orchestrate("export", SCENARIO, "--step", step, "--ssp", inner / "adcs.ssp", "--container", inner / "adcs.fmu")


def prepare_item(folder: Path, *options: str) -> Path:
    """The same with an enumeration's item that is not the FMU's own; returns the scenario."""
    scenario = folder / "item.yaml"
    item = "blocks: {controller: {start: {gain_schedule: constant}}}"
    scenario.write_text(f"extends: {SCENARIO.as_posix()}\n{item}\n", "utf-8")
    _orchestrate("export", scenario, "--ssp", folder / "adcs.ssp", "--container", folder / "adcs.fmu", *options)
    return scenario


def _orchestrate(*arguments: object) -> None:
    main([str(argument) for argument in arguments], standalone_mode=False)


def play(
    recipe: Recipe, folder: Path, step: float = 0.1, replace: dict[str, str] | None = None
) -> tuple[Floats, Floats]:
    """Time and the signal of a recipe, run by an interpreter of its own. Raises AssertionError with what it printed."""
    text = re.sub(r"^step = .*$", f"step = {step}", recipe.text, flags=re.MULTILINE)
    text = text.replace("output_interval=0.1", f"output_interval={step}")
    for old, new in (replace or {}).items():
        assert old in text
        text = text.replace(old, new)
    text += "\nimport json\nseen = globals().get('error', globals().get('rate'))\n"
    text += "print('\\n@' + json.dumps([[float(x) for x in time], [float(x) for x in seen]]))\n"
    run = subprocess.run(
        [sys.executable, "-c", text], cwd=folder, capture_output=True, text=True, check=False, timeout=120
    )
    assert run.returncode == 0, run.stdout[-2000:] + run.stderr[-2000:]
    time, seen = json.loads(run.stdout.rpartition("\n@")[2])
    return np.array(time), np.array(seen)


PLANT = {"omega_B0[1]": 0.04, "omega_B0[2]": -0.0789, "omega_B0[3]": 0.04}
"""The start values in the recipes of one FMU."""


def alone(block: str, start: dict[str, float], signal: str) -> Floats:
    """The signal of one block by itself in `orchestrate`, every 0.1 s for 60 s; inputs keep the FMU's start values."""
    inputs = {element.name: element.start for v in interface(block).of("input") for element in v.elements}
    blocks = {block: {"fmu": block, "start": inputs | start}}
    result = orchestration.run({"name": "alone", "step": 0.1, "duration": 60, "blocks": blocks})
    return np.asarray(result[f"{block}.{signal}"], dtype=float)


def changed(recipe: Recipe, block: str, start: dict[str, float], signal: str) -> dict[str, str]:
    """What to replace in a recipe of the plant to have another block with one start value."""
    prefix = "plant::" if recipe.tool == "ecos" else ""
    ((name, value),) = start.items()
    old = ", ".join(f'"{prefix}{n}": {x}' for n, x in PLANT.items())
    return {old: f'"{prefix}{name}": {value}', "omega_B[2]": signal, "plant": block}


@cache
def ours(step: float, exchange: str) -> Floats:
    """The attitude error of the loop in `orchestrate`."""
    return loop(SCENARIO, step, exchange)


def loop(scenario: Path, step: float, exchange: str) -> Floats:
    return np.asarray(orchestration.run(_loop(scenario, step, exchange))["controller.attitude_error"])


def _loop(scenario: Path, step: float, exchange: str) -> Scenario:
    source = load(scenario).source.without([("expect",), ("figures",), ("holds",)])
    for key, value in (("step", step), ("exchange", exchange), ("duration", DURATION)):
        source = source.with_value(key, value, "")
    return load(source)


@dataclass(frozen=True)
class Difference:
    """Largest difference of the attitude error, rad."""

    step: float
    sequential: float
    """From what `orchestrate` gives by default."""
    same: float
    """From what it gives with the tool's own exchange."""


@cache
def difference(recipe: Recipe, folder: Path, step: float) -> Difference:
    time, error = play(recipe, folder / f"step_{step:g}", step)
    index = np.rint(time / step).astype(int)
    own, default = ours(step, recipe.exchange), ours(step, "sequential")
    kept = index + recipe.ahead < len(own)
    index, error = index[kept], error[kept]
    return Difference(
        step, float(np.abs(error - default[index]).max()), float(np.abs(error - own[index + recipe.ahead]).max())
    )
