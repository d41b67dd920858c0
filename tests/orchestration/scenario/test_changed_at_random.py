"""A few of the scenarios of `python -m tests.torture scenarios`, with a seed of their own."""

from __future__ import annotations

import os

import pytest
from click.testing import CliRunner

from ...torture import scenarios

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the time limit is an alarm, which Windows has not")


def test_scenarios_that_are_changed_at_random_are_refused_or_flown_and_nothing_else():
    result = CliRunner().invoke(scenarios.command, ["--count", "60", "--seed", "60"])
    assert result.exit_code == 0, result.output
    assert "  flown\n" in result.output
    assert "  refused\n" in result.output
