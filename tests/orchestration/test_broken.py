"""Whatever an FMU does, the run ends by itself, says what happened, and leaves nothing behind but its results."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from .broken import CASES, CASES_3, HEAD, HEAD_3, TESTED_3, Case, outcomes, outcomes_3, rows, wrong

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="signals and limits are those of Linux")


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_broken_fmu_is_told_and_nothing_is_left_behind(case: Case):
    assert wrong(case, outcomes()[case.name]) == [], outcomes()[case.name]


@pytest.mark.parametrize("case", [case for case in CASES_3 if case.name in TESTED_3], ids=lambda case: case.name)
def test_a_broken_fmu_of_fmi_3_is_told_and_nothing_is_left_behind(case: Case):
    assert wrong(case, outcomes_3()[case.name]) == [], outcomes_3()[case.name]


def test_what_an_fmu_prints_does_not_disturb_the_table():
    table = outcomes()["printing without end"].table
    assert table.startswith("run: failed after 1 s in ")
    assert "and on" not in table


def test_the_page_of_broken_fmus_is_up_to_date():
    committed = (Path(__file__).parents[2] / "docs" / "broken-fmus.md").read_text("utf-8")
    two, _, three = committed.partition(HEAD_3)
    remedy = "python -m tests.orchestration.broken > docs/broken-fmus.md"
    assert two == "\n".join([HEAD, *rows(CASES, outcomes()), ""]), remedy
    listed = three.splitlines()[1:]
    assert [line.split(" | ")[0] for line in listed] == [f"| {case.name}" for case in CASES_3], remedy
    assert set(rows([case for case in CASES_3 if case.name in TESTED_3], outcomes_3())) <= set(listed), remedy
