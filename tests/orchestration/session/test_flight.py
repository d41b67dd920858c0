"""Flights on the same instances, as those of a campaign."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orchestration import load, run
from orchestration.fmu.model import Floats
from orchestration.master.circuit import Circuit
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


def test_each_flight_has_its_own_circuit_and_columns_on_the_instances_of_the_last(loop: Path) -> None:
    """Motor and regulator, exchanged in turn and at once; flown alone, and one after the other."""
    opened = open_scenario(load(loop))
    plan = opened.plan
    at_once = replace(plan.circuit, parallel=not plan.circuit.parallel)
    nodes = [node for node in plan.columns if node.element.variable in ("speed", "voltage")]
    a, b = nodes
    asked = [(plan.circuit, [a]), (at_once, [a]), (at_once, [b]), (plan.circuit, [b])]  # one of both changes at a time

    def flown(session: Session, circuit: Circuit, columns: list[Node]) -> tuple[list[Node], list[float]]:
        recording = session.fly(plan.starts, columns=columns, circuit=circuit).whole()
        return recording.columns, recording.values[:, 0].tolist()

    alone = []
    for circuit, columns in asked:
        with Session(opened, resets=True) as session:
            alone.append(flown(session, circuit, columns))
    assert len({str(values) for _, values in alone}) == len(asked)
    with Session(opened, resets=True) as session:
        for _ in range(2):
            assert [flown(session, *one) for one in asked] == alone
