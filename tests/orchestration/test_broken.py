"""Whatever an FMU does, the run ends by itself, says what happened, and leaves nothing behind but its results."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from .broken import CASES, Case, outcomes, page

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="signals and limits are those of Linux")


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_broken_fmu_is_told_and_nothing_is_left_behind(case: Case):
    found = outcomes()[case.name]
    assert case.message in found.output
    assert found.status == case.status
    assert found.samples == case.samples
    assert found.seconds < 30.0
    assert found.files == {"run.yaml", "vendor.fmu"}
    assert found.temporary == set()
    assert found.processes == set()
    assert "Traceback" not in found.output
    assert "internal error" not in found.output


def test_what_an_fmu_prints_does_not_disturb_the_table():
    table = outcomes()["printing without end"].table
    assert table.startswith("run: failed after 1 s in ")
    assert "and on" not in table


def test_the_page_of_broken_fmus_is_up_to_date():
    committed = Path(__file__).parents[2] / "docs" / "broken-fmus.md"
    assert committed.read_text("utf-8") == page(), "python -m tests.orchestration.broken > docs/broken-fmus.md"
