"""Flights on the same instances, as those of a campaign."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from orchestration import load, run
from orchestration.fmu.model import Floats
from orchestration.session.flight import fly
from orchestration.session.open import open_scenario
from orchestration.session.session import Session
from orchestration.system.wiring import Node

PAPER = Path(__file__).parents[3] / "scenarios" / "paper_no_singularity.yaml"


class Last:
    """Keeps what it is shown at the end."""

    def see(self, time: Floats, columns: Mapping[Node, Floats]) -> None:
        self.values = {node: float(values[-1]) for node, values in columns.items()}


@pytest.mark.parametrize("kind", ["cut", "freeze"])
def test_each_flight_with_a_fault_in_an_exchange_ends_as_a_run_does(kind: str) -> None:
    data = {"extends": str(PAPER), "duration": 5.0, "faults": [{"at": 1.0, kind: "plant.dipole_cmd[1]"}]}
    scenario = load({**data, "expect": [], "record": {"signals": ["plant.omega_B"]}})
    wanted = np.asarray(run(scenario)["plant.omega_B"])[-1]
    opened = open_scenario(scenario)
    nodes = [node for node in opened.plan.columns if node.element.variable == "omega_B"]
    with Session(opened, resets=True) as session:
        for _ in range(4):
            last = Last()
            flown = fly(session, {}, [last], nodes)
            assert flown.reason is None
            np.testing.assert_array_equal([last.values[node] for node in nodes], wanted)
