"""docs/sweep.md, its file, and the loop that it is flown by."""

import numpy as np
import pytest

from studies.flight.cases import SEEDS, tumbles
from studies.optimum.kept import FILE as FLOWN
from studies.optimum.kept import load as load_flown
from studies.paper import ROOT
from studies.sweep.constants import CONSTANTS
from studies.sweep.loop import built, settled, tumbles_of, value_of
from studies.sweep.make import FACTORS, FILE, load, text

LINES = load(ROOT / "docs" / FILE)


def test_the_page_is_made_from_the_file():
    assert text(LINES) == (ROOT / "docs" / "sweep.md").read_text("utf-8")


@pytest.mark.parametrize(("file", "name"), [(file, name) for file, name, _ in CONSTANTS])
def test_each_constant_was_flown_at_half_and_twice_the_value_that_it_has(file, name):
    flown = [line.value for line in LINES if (line.file, line.name) == (file, name)]
    assert flown == pytest.approx([float(value_of(file, name)) * factor for factor in FACTORS], rel=0.21)


@pytest.mark.thorough
def test_the_loop_settles_when_the_fmus_do(tmp_path):
    library = built(None, "", tmp_path / "loop")
    flown = [line.flown_s for line in load_flown(ROOT / "docs" / FLOWN)][:4]
    times = [settled(library, tumble) for tumble in tumbles_of(tumbles("nominal", SEEDS["nominal"], 4))]
    assert np.abs(np.subtract(times, flown)).max() < 2.0
