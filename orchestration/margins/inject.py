"""Blocks that stand before the receivers of a signal: they add to it, or hand it on late and amplified, and record it.

Tests: tests/orchestration/margins/test_measure.py, test_search.py.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..fmu.model import Element, Floats
from ..instances.block import Block
from ..instances.front import Front
from ..session.session import Blocks, Session
from ..system.observer import Observer
from ..system.starts import Start
from ..system.wiring import Node
from .site import Receiver, Site


@dataclass(frozen=True)
class Altered:
    """What is wrong with a signal on its way, as a margin counts it."""

    gain: float = 1.0
    delay: int = 0
    """Base steps, beside what the loop has."""


class Rig:
    """Flies a session with signals injected from base step `first` on."""

    def __init__(self, session: Session, site: Site, first: int) -> None:
        self.session, self.site = session, site
        self.first = -(-first // site.hold) * site.hold
        self.flights = 0
        self.peaks = np.zeros(len(site.channels))
        """The largest value of each channel in the first flight."""

    @property
    def period(self) -> float:
        """Seconds from sample to sample."""
        return self.site.hold * self.session.opened.plan.clock.step

    @property
    def scales(self) -> Floats:
        """The size of each channel: the largest value of its port in the first flight, or its nominal one."""
        channels = self.site.channels
        ports = [channel.port for channel in channels]
        largest = {port: max(p for p, of in zip(self.peaks, ports, strict=True) if of == port) for port in ports}
        return np.array([largest[channel.port] or channel.nominal for channel in channels])

    def fly(
        self,
        injected: Floats,
        altered: Altered = Altered(),
        observers: Sequence[Observer] = (),
        nodes: Sequence[Node] = (),
        starts: Mapping[str, Sequence[Start]] | None = None,
    ) -> Floats:
        """Returns what comes back to each channel, before the injection is added, (samples, channels).

        `injected` (samples, channels) is held from sample to sample, in the unit of the port. Raises BlockError where
        a block fails.
        """
        plan, site = self.session.opened.plan, self.site
        steps = self.first + len(injected) * site.hold
        circuit = replace(plan.circuit, clock=replace(plan.clock, steps=steps, interval=steps))
        came = np.full(injected.shape, np.nan)

        def around(blocks: Blocks) -> Blocks:
            found: dict[str, dict[Element, tuple[int, Receiver]]] = {}
            for number, channel in enumerate(site.channels):
                for receiver in channel.receivers:
                    found.setdefault(receiver.target.block, {})[receiver.target.element] = number, receiver
            fronts = {
                name: _Front(blocks[name], circuit.rate(name), taken, self, injected, came, altered)
                for name, taken in found.items()
            }
            return {**blocks, **fronts}

        self.flights += 1
        recording = self.session.fly(starts or plan.starts, observers, nodes, circuit=circuit, around=around).whole()
        if recording.failure is not None:
            raise recording.failure
        return came


class _Front(Front):
    """A receiver with what is added to some of its inputs."""

    def __init__(
        self,
        inner: Block,
        every: int,
        taken: Mapping[Element, tuple[int, Receiver]],
        rig: Rig,
        injected: Floats,
        came: Floats,
        altered: Altered,
    ) -> None:
        super().__init__(inner)
        self._every, self._taken, self._rig = every, taken, rig
        self._injected, self._came, self._altered = injected, came, altered

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        given = super().wire(inputs, outputs, live, into)
        hand_over, every, rig = self.inner.set_inputs, self._every, self._rig
        first, hold, injected, came, peaks = rig.first, rig.site.hold, self._injected, self._came, rig.peaks
        gain, late = self._altered.gain, self._altered.delay // every
        places = [
            (place, number, receiver.factor, receiver.behind, rig.site.channels[number].receivers[0] is receiver)
            for place, element in enumerate(inputs)
            if element in self._taken
            for number, receiver in [self._taken[element]]
        ]
        kept = {place: [0.0] * late for place, *_ in places}
        calls, looks = 0, bool(late) or rig.flights == 1

        def set_inputs() -> None:
            nonlocal calls
            calls += 1
            if calls * every < first and not looks:
                hand_over()
                return
            for place, number, factor, behind, sampled in places:
                value = given[place]
                if sampled:
                    peaks[number] = max(peaks[number], abs(value / factor))
                sample, within = divmod(calls * every - behind - first, hold)
                acts = 0 <= sample < len(injected)
                if late:
                    kept[place].append(value)
                    before = kept[place].pop(0)
                    value = before if acts else value
                if acts:
                    value *= gain
                    if sampled and within < every:
                        came[sample, number] = value / factor
                    value += factor * injected[sample, number]
                given[place] = value
            hand_over()

        self.set_inputs = set_inputs
        return given
