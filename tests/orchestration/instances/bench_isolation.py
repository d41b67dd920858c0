"""What a step costs of an FMU in this process and of one in its own: `python -m
tests.orchestration.instances.bench_isolation`.

A step is Set of the inputs, doStep and Get of the outputs, called from the loop in Python.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

from orchestration.fmu.archive import Fmu, open_fmu
from orchestration.fmu.model import Element
from orchestration.instances.block import Block
from orchestration.instances.isolation import IsolatedBlock
from orchestration.instances.process import Limits
from orchestration.instances.slave import Slave

from .. import fmus

STEPS = 20_000


def _wired(block: Block) -> None:
    model = block.model
    inputs = [e for v in model.of("input") for e in v.elements]
    outputs = [e for v in model.of("output") for e in v.elements]
    order = ("real", "integer", "enumeration", "boolean")
    kinds = {e: order.index(model.variables[e.variable].type) for e in [*inputs, *outputs]}
    block.enter(1e9)
    values = block.wire(
        sorted(inputs, key=lambda e: kinds[e]),
        sorted(outputs, key=lambda e: kinds[e]),
        [sum(kinds[e] == i for e in outputs) for i in range(4)],
        np.zeros(len(outputs)),
    )
    starts: list[Element] = sorted(inputs, key=lambda e: kinds[e])
    values[:] = block.get(starts)
    block.leave()


def _microseconds(block: Block) -> tuple[float, float]:
    """Median and 99th percentile of a step."""
    taken = np.empty(STEPS)
    for n in range(STEPS):
        begun = perf_counter()
        block.set_inputs()
        block.do_step(0.001 * n, 0.001)
        block.get_all()
        taken[n] = perf_counter() - begun
    return 1e6 * float(np.median(taken)), 1e6 * float(np.quantile(taken, 0.99))


def measure(fmu: Fmu) -> dict[str, tuple[float, float]]:
    found = {}
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        for isolation in ("none", "process"):
            place = Path(folder) / isolation
            fmu.extract(place)
            block: Block
            if isolation == "process":
                block = IsolatedBlock("block", fmu, place, Limits(60.0, 10**9))
                block.started()
            else:
                block = Slave("block", fmu, place)
            try:
                _wired(block)
                found[isolation] = _microseconds(block)
            finally:
                block.close()
    return found


def main() -> None:
    from fmus.build import ensure

    with tempfile.TemporaryDirectory() as folder:
        fmus.write_pair(Path(folder))
        measured = {"motor, a small FMU in C": measure(open_fmu(Path(folder) / "motor.fmu"))}
    for block in ("controller", "plant"):
        measured[f"{block}, native"] = measure(open_fmu(ensure(block, "native")))
    print(
        f"{'us per step: median (99 % below)':34s}{'in this process':>20s}{'in its own':>20s}{'isolation costs':>18s}"
    )
    for name, found in measured.items():
        cells = "".join(f"{m:>11.1f} ({p:5.1f})".rjust(20) for m, p in found.values())
        cost = found["process"][0] - found["none"][0]
        print(f"{name:34s}{cells}{cost:>18.1f}")


if __name__ == "__main__":
    main()
