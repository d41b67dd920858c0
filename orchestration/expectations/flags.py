"""Boolean outputs of a run: when each was true, at every base step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..fmu.model import Floats, Model
from ..system import signals
from ..system.wiring import Node


@dataclass
class Flag:
    """A boolean output. Times in s."""

    name: str
    first: float | None = None
    """When it was true first; None for never."""
    until: float | None = None
    """When it ceased to be true for the last time: excluded, as the end of a hold or a fault is; None for never."""
    standing: bool = False
    """Whether it is true at the end of the run."""
    times: int = 0
    """How often it became true."""

    @property
    def text(self) -> str:
        """From when to when it was true, and how often where it was false between; it was true at some time."""
        often = f" {self.times} times" if self.times > 1 else ""
        return f"{self.name}{often} from {self.first:.5g} s to {'the end' if self.standing else f'{self.until:.5g} s'}"


class FlagObserver:
    """Takes in the flags piece by piece, and has their times in the end."""

    def __init__(self, nodes: Sequence[Node], models: Mapping[str, Model]) -> None:
        self._flags = {node: Flag(signals.label(node, models)) for node in nodes}
        self._begun = False

    def see(self, time: Floats, columns: Mapping[Node, Floats]) -> None:
        """Takes in the samples that follow those before."""
        if not len(time):
            return
        self._begun = True
        for node, flag in self._flags.items():
            raised = columns[node] != 0.0
            if flag.first is None and raised.any():
                flag.first = float(time[raised.argmax()])
            before = np.concatenate(([flag.standing], raised[:-1]))
            flag.times += int((raised & ~before).sum())
            if len(ceased := np.flatnonzero(~raised & before)):
                flag.until = float(time[ceased[-1]])
            flag.standing = bool(raised[-1])

    @property
    def flags(self) -> list[Flag]:
        """Returns all flags; none of a run that ended before its first sample."""
        return list(self._flags.values()) if self._begun else []
