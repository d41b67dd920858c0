"""Whatever an FMU does, the run ends by itself, says what happened, and leaves nothing behind but its results."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.once import computed

from .broken import CASES, CASES_3, HEAD, HEAD_3, TESTED_3, Case, Outcome, outcomes, outcomes_3, rows, wrong

pytestmark = [
    pytest.mark.isolate,
    pytest.mark.skipif(sys.platform != "linux", reason="signals and limits are those of Linux"),
]


@pytest.fixture(scope="session")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Outcome]:
    return computed(tmp_path_factory, "broken", outcomes)


@pytest.fixture(scope="session")
def found_3(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Outcome]:
    return computed(tmp_path_factory, "broken_3", outcomes_3)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_broken_fmu_is_told_and_nothing_is_left_behind(case: Case, found: dict[str, Outcome]):
    assert wrong(case, found[case.name]) == [], found[case.name]


@pytest.mark.parametrize("case", [case for case in CASES_3 if case.name in TESTED_3], ids=lambda case: case.name)
def test_a_broken_fmu_of_fmi_3_is_told_and_nothing_is_left_behind(case: Case, found_3: dict[str, Outcome]):
    assert wrong(case, found_3[case.name]) == [], found_3[case.name]


def test_what_an_fmu_prints_does_not_disturb_the_table(found: dict[str, Outcome]):
    table = found["printing without end"].table
    assert table.startswith("run: failed after 1 s in ")
    assert "and on" not in table


def test_the_page_of_broken_fmus_is_up_to_date(found: dict[str, Outcome], found_3: dict[str, Outcome]):
    committed = Path(__file__).with_name("broken.md").read_text("utf-8")
    two, _, three = committed.partition(HEAD_3)
    remedy = "python -m tests.orchestration.broken > tests/orchestration/broken.md"
    assert two == "\n".join([HEAD, *rows(CASES, found), ""]), remedy
    listed = three.splitlines()[1:]
    assert [line.split(" | ")[0] for line in listed] == [f"| {case.name}" for case in CASES_3], remedy
    assert set(rows([case for case in CASES_3 if case.name in TESTED_3], found_3)) <= set(listed), remedy
