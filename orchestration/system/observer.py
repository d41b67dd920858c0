"""An observer of a run. Tests: tests/orchestration/master/test_every_step.py."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from ..fmu.model import Floats
from .wiring import Node


class Observer(Protocol):
    """Is shown signals of a run after every base step, piece by piece."""

    def see(self, time: Floats, columns: Mapping[Node, Floats]) -> None:
        """Takes in the samples that follow those before: times (n,) s, and values (n,) by node.

        What it raises ends the run.
        """
