"""Rules of MISRA C:2012 and clang-tidy: what is found is what the list of deviations says.

Shows FC-3.
"""

from __future__ import annotations

import shutil
from collections import Counter

import pytest

from evidence.proofs import rules
from fmus.places import PACKAGES
from orchestration import InputError


def test_each_deviation_has_a_reason_and_names_files_that_exist():
    for rule, reason, places in rules.deviations():
        assert len(reason) > 5, rule
        assert all((PACKAGES / file).is_file() for file in places)


def test_one_finding_more_or_less_is_an_error(monkeypatch):
    listed = Counter({(rule, file): n for rule, _, places in rules.deviations() for file, n in places.items()})
    monkeypatch.setattr(rules, "findings", lambda: listed)
    assert rules.check() == listed
    for change in (1, -1):
        other = Counter(listed)
        other["misra-c2012-17.7", "supervisor/native/modes.c"] += change
        monkeypatch.setattr(rules, "findings", lambda other=other: other)
        with pytest.raises(InputError, match="1 findings"):
            rules.check()


@pytest.mark.thorough
@pytest.mark.skipif(
    shutil.which("cppcheck") is None or shutil.which("clang-tidy") is None,
    reason="cppcheck or clang-tidy is not installed (Debian: cppcheck clang-tidy)",
)
def test_the_flight_code_has_no_finding_beyond_the_deviations():
    rules.check()
