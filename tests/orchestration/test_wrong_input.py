"""Whatever is wrong, a message says where and what, and no traceback is seen."""

from __future__ import annotations

from pathlib import Path

import fmpy
import pytest

from tests.once import computed

from .wrong_inputs import CASES, Case, outcomes, page

pytestmark = pytest.mark.isolate


@pytest.fixture(scope="session")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[int, str, bool]]:
    return computed(tmp_path_factory, "wrong_inputs", outcomes)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_wrong_input_is_told_in_a_message(case: Case, found: dict[str, tuple[int, str, bool]]):
    status, output, ran = found[case.name]
    assert case.message in output
    assert status == case.status
    assert "Traceback" not in output
    assert "internal error" not in output
    if status == 2:
        assert not ran, "nothing was run"


def test_there_are_thirty_cases_or_more_under_names_of_their_own():
    assert len({case.name for case in CASES}) == len(CASES) >= 30


@pytest.mark.skipif(fmpy.platform != "linux64", reason="the page names the platform's libraries")
def test_the_page_of_errors_is_up_to_date(found: dict[str, tuple[int, str, bool]]):
    committed = Path(__file__).with_name("wrong_inputs.md")
    assert committed.read_text("utf-8") == page(found), (
        "python -m tests.orchestration.wrong_inputs > tests/orchestration/wrong_inputs.md"
    )
