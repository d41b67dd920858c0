"""Notes on a scenario by installed packages that know more of it than this one: entry points `orchestrate.notes`.

Tests: tests/orchestration/cli/test_noted.py.
"""

from __future__ import annotations

from ..errors import InputError
from ..scenario.scenario import Scenario


def noted(scenario: Scenario) -> list[str]:
    """Returns what the packages say of a scenario; nothing of one that they do not know."""
    from importlib.metadata import entry_points  # here, since it takes time that --quiet saves  # noqa: PLC0415

    found: list[str] = []
    for point in entry_points(group="orchestrate.notes"):
        try:
            found += point.load()(scenario)
        except (InputError, ModuleNotFoundError):  # what a run refuses it tells by itself
            continue
    return found
