"""Designs: Latin hypercubes, Sobol's sequence and grids."""

from __future__ import annotations

import numpy as np
import pytest

from orchestration.campaign.case import read_campaign
from orchestration.campaign.drawing.design import Design
from orchestration.errors import InputError

from ..toy import changed, fly, rows


@pytest.mark.parametrize("sampling", ["latin hypercube", "sobol"])
def test_a_design_fills_every_layer_once(toy, sampling):
    changed(toy, ("runs: 60", f"runs: 64\nsampling: {sampling}"))
    fly(toy)
    layers = np.floor((np.array([row["motor.speed0"] for row in rows()]) - 1.0) * 64).astype(int)
    assert sorted(layers) == list(range(64))


def test_sobols_sequence_also_fills_each_box_of_two_coordinates_once():
    """Of 16 points one lies in each of 4 by 4 boxes, of 2 by 8 and of 8 by 2: a net, which no Latin hypercube is."""
    points = Design("sobol", 3, 16, 2).points(range(16))
    for sides in ((4, 4), (2, 8), (8, 2)):
        assert len({tuple(box) for box in np.floor(points * sides).astype(int)}) == 16


def test_a_grid_is_crossed_and_the_rest_is_drawn(toy):
    changed(
        toy,
        ("runs: 60", "sampling: grid"),
        ("vary:", "vary:\n  motor.poles: {grid: [2, 4, 6]}\n  motor.mode: {grid: [normal, brake]}"),
    )
    fly(toy)
    found = rows()
    assert [(row["motor.poles"], row["motor.mode"]) for row in found] == [
        (poles, mode) for poles in (2.0, 4.0, 6.0) for mode in ("normal", "brake")
    ]
    assert len({row["motor.speed0"] for row in found}) == 6
    with pytest.raises(InputError, match="the grid has 6 points"):
        read_campaign(toy, {"runs": 7})
