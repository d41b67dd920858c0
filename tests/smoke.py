"""Loads each native FMU with FMPy on this machine and steps it: `python -m tests.smoke [FOLDER]`.

Without a folder of FMUs they are built from the sources, for all platforms. Needs FMPy and, to build, ziglang.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from fmpy import platform, read_model_description, simulate_fmu, supported_platforms
from fmpy.validation import validate_fmu

from fmus.build import blocks_of, ensure

STEPS = 20


def step(path: Path) -> int:
    """Steps an FMU from its start values and returns the number of its outputs, all of which were finite.

    Raises RuntimeError where FMPy has a finding, this platform is missing, or an output is not finite.
    """
    if findings := validate_fmu(str(path)):
        raise RuntimeError(f"{path}: expected a valid FMU, found: {findings[0]}")
    if platform not in supported_platforms(str(path)):
        raise RuntimeError(f"{path}: expected a library for {platform}, found {supported_platforms(str(path))}")
    description = read_model_description(str(path))
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    h = float(description.defaultExperiment.stepSize)
    result = simulate_fmu(str(path), stop_time=STEPS * h, step_size=h, output_interval=h, output=outputs)
    if len(result) != STEPS + 1:
        raise RuntimeError(f"{path}: expected {STEPS + 1} rows, found {len(result)}")
    for name in outputs:
        if not np.isfinite(result[name].astype(float)).all():
            raise RuntimeError(f"{path}: expected finite values of {name}, found {result[name]}")
    return len(outputs)


def main(arguments: Iterable[str] = sys.argv[1:]) -> None:
    folders = [Path(argument) for argument in arguments]
    paths = [folder / f"{block}.fmu" for folder in folders for block in blocks_of("native")]
    for path in paths or map(ensure, blocks_of("native")):
        print(f"{path.name}: {step(path)} outputs, finite over {STEPS} steps on {platform}", flush=True)


if __name__ == "__main__":
    main()
