"""A campaign as a function of the unit cube."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestration.campaign.case import read_campaign
from orchestration.campaign.flying import crew
from orchestration.campaign.metric_function import of_campaign
from orchestration.session.run import run

from .toy import SHRINKS


def test_points_of_the_unit_cube_give_their_metrics(toy):
    case = read_campaign(toy)
    with crew.crew(case.job, 0) as (here, _):
        evaluate = of_campaign(case, here)
        unit = np.array([[0.0], [0.25], [1.0]])
        assert evaluate.fly(unit)["final"] == pytest.approx(SHRINKS * np.array([1.0, 1.25, 2.0]))
        assert (evaluate.coordinates, evaluate.metrics) == (["motor.speed0"], {"final": "rad/s", "slow": "s"})
        assert evaluate.values(unit[1]) == {"motor.speed0": "1.25 rad/s"}
        Path("point.yaml").write_text(evaluate.scenario(unit[1]), "utf-8")
    assert run("point.yaml")["motor.speed"][0] == 1.25
