"""How a paced run kept its deadlines: lateness, jitter, overruns, and who was late.

- lateness of a base step: from when its end was due until the run went on from there, with the wait for it;
- late step: its lateness is more than the tolerance;
- overrun: a base step that took longer than a base step has, wait not counted;
- jitter: how much the time from one instant to the next differs from that of a base step.
"""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ..fmu.model import Floats
from ..system.clock import Clock

_LISTED = 100
"""Late steps that are kept one by one."""
_SHARES = {"p50": 0.5, "p99": 0.99, "p99.9": 0.999}


@dataclass(frozen=True)
class Late:
    """An overrun, or the first of late steps in a row. Times in s."""

    time: float
    """The simulated time at the step's end."""
    lateness: float
    took: float
    overrun: bool
    block: str | None
    """The block whose step took longest; None where the steps were in time and the wait ended late."""
    block_took: float

    @property
    def text(self) -> str:
        """It in a line."""
        where = f"{milliseconds(self.lateness)} late at {self.time:.10g} s"
        if self.block is None:
            return f"{where}: the wait for it ended late, the base step took {milliseconds(self.took)}"
        kind = "overrun" if self.overrun else "base step"
        return (
            f"{where}: {kind} of {milliseconds(self.took)}, of which {self.block} took {milliseconds(self.block_took)}"
        )


@dataclass
class Pace:
    """Counts of a pacer. Times in s of wall time, where nothing else is said."""

    factor: float
    """Simulated seconds in a second."""
    tolerance: float
    stop: bool
    """Whether a late step ends the run."""
    clock: Clock
    priority: int | None = None
    """Of SCHED_FIFO, with the memory locked; None for that of any program."""
    lateness: array[float] = field(default_factory=lambda: array("d"))
    """Of each base step."""
    took: array[float] = field(default_factory=lambda: array("d"))
    """What each base step took, without the wait."""
    slowest: dict[str, tuple[float, float]] = field(default_factory=dict)
    """The longest that each block took in a base step, and the simulated time at that step's end."""
    listed: list[Late] = field(default_factory=list)
    """Overruns, and the first of late steps in a row; the first 100 of them."""
    late_steps: int = 0
    overruns: int = 0
    moved: set[int] = field(default_factory=set)
    """After how many base steps a pause moved the deadlines."""
    paused: float = 0.0
    single_steps: int = 0

    @property
    def period(self) -> float:
        """Wall time of a base step."""
        return self.clock.step / self.factor

    def add(self, count: int, lateness: float, took: float, blocks: Mapping[str, float], waited: bool) -> Late:
        """Counts a base step; `blocks` is what each block took of it."""
        time = self.clock.time(count)
        before = self.lateness[-1] if self.lateness else 0.0
        self.lateness.append(lateness)
        self.took.append(took)
        for name, block_took in blocks.items():
            if block_took > self.slowest.get(name, (-1.0, 0.0))[0]:
                self.slowest[name] = block_took, time
        late, overrun = lateness > self.tolerance, took > self.period
        self.late_steps += late
        self.overruns += overrun
        block = max(blocks, key=lambda name: blocks[name]) if blocks and not waited else None
        entry = Late(time, lateness, took, overrun, block, blocks[block] if block is not None else 0.0)
        if (overrun or (late and before <= self.tolerance)) and len(self.listed) < _LISTED:
            self.listed.append(entry)
        return entry

    def pause(self, count: int, lasted: float) -> None:
        self.moved.add(count)
        self.paused += lasted

    @property
    def times(self) -> Floats:
        """The simulated time at the end of each base step."""
        return self.clock.times(1, len(self.lateness))

    @property
    def jitter(self) -> Floats:
        """Differences of the time between neighbouring instants from a base step, without pauses."""
        lateness = np.concatenate([[0.0], self.lateness])
        steps = np.arange(len(self.lateness))
        return np.abs(np.diff(lateness))[~np.isin(steps, list(self.moved))]

    @property
    def figures(self) -> dict[str, dict[str, float]]:
        """Lateness, jitter and what a step took: its value that half, 99% and 99.9% of the steps keep, and the
        largest."""
        kinds = {"lateness": np.array(self.lateness), "jitter": self.jitter, "step": np.array(self.took)}
        return {
            name: {
                **{key: float(np.quantile(values, share, method="inverted_cdf")) for key, share in _SHARES.items()},
                "largest": float(values.max()),
            }
            for name, values in kinds.items()
            if len(values)
        }

    @property
    def summary(self) -> str:
        """All of it in a line."""
        steps = len(self.lateness)
        if not steps:
            return "no step was paced"
        late = self.figures["lateness"]
        largest = f"{milliseconds(late['largest'])} at {self.times[int(np.argmax(self.lateness))]:.10g} s"
        return (
            f"factor {self.factor:g}; lateness p50 {milliseconds(late['p50'])}, p99 {milliseconds(late['p99'])},"
            f" p99.9 {milliseconds(late['p99.9'])}, largest {largest}; {self.late_steps} of {steps} steps late"
            f" (more than {milliseconds(self.tolerance)}), {self.overruns} overrun{'s' * (self.overruns != 1)}"
            + (f"; priority {self.priority} (SCHED_FIFO), memory locked" if self.priority is not None else "")
        )

    def data(self) -> dict[str, Any]:
        """All of it for a manifest."""
        return {
            "factor": self.factor,
            "late": "stop" if self.stop else "continue",
            "tolerance": self.tolerance,
            "period": self.period,
            "priority": self.priority,
            "steps": len(self.lateness),
            **self.figures,
            "late_steps": self.late_steps,
            "overruns": self.overruns,
            "listed": [asdict(late) for late in self.listed],
            "slowest": {name: {"took": took, "time": time} for name, (took, time) in self.slowest.items()},
            "paused": self.paused,
            "single_steps": self.single_steps,
        }


def milliseconds(seconds: float) -> str:
    """A duration as text."""
    return f"{1e3 * seconds:.3g} ms"
