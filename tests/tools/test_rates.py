"""Scenarios with rates and delays in another host: FMPy steps the components of the archive in their order.

All have one rate there.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import orchestration
from orchestration import load

from .archives import printed, validate
from .sequential import flown

pytestmark = pytest.mark.thorough

SCENARIOS = Path(__file__).parents[2] / "scenarios"
SIGNALS = [*(f"plant.omega_B[{i}]" for i in (1, 2, 3)), *(f"allocator.dipole_cmd[{i}]" for i in (1, 2, 3)), "plant.h_w"]
COUNT = 100
ADDS_UP = (False, True)


@pytest.mark.parametrize("name", ["flight_vb", "flight_hold", "flight_estimated"])
def test_an_exported_loop_with_rates_gives_our_bits_in_hosts_that_multiply_and_that_add_up(
    name: str, tmp_path: Path
) -> None:
    path, archive = SCENARIOS / f"{name}.yaml", tmp_path / "adcs.ssp"
    printed("export", path, "--ssp", archive)
    validate(archive)
    source = load(path).source.without([(key,) for key in ("expect", "figures", "holds", "record", "consistency")])
    step = load(path).step
    result = orchestration.run(load(source.with_value("duration", COUNT * step, "")))
    ours = np.column_stack([result[signal] for signal in SIGNALS])[1:]
    for adds_up in ADDS_UP:
        theirs = np.array(flown(archive, step, COUNT, SIGNALS, adds_up))
        assert np.array_equal(theirs, ours), adds_up
