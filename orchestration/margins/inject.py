"""Blocks that stand before the receivers of a signal: they add to it, or hand it on late and amplified, and record it.

Tests: tests/orchestration/margins/test_measure.py, test_search.py.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..fmu.model import Element, Floats
from ..instances.block import Block
from ..instances.front import Front
from ..master.master import Kept, Options
from ..session.session import Blocks, Session
from ..system.observer import Observer
from ..system.starts import Start
from ..system.wiring import Node
from .site import Receiver, Site

_LATEST = 10_000
"""Values of a signal before the injection that are remembered, for delays."""
_BEYOND = 10**8
"""Base steps after `first` of which the FMUs are told."""


@dataclass(frozen=True)
class Altered:
    """Change of a signal on its way, as a margin counts it."""

    gain: float = 1.0
    delay: int = 0
    """Base steps, beside what the loop has."""
    tape: Floats | None = None
    """What is given in place of what comes, (samples, channels): the loop is open."""


class Rig:
    """Flies a session with signals injected from base step `first` on.

    Where the FMUs save their states, the time before is flown once. `starts` take the place of the scenario's.
    """

    def __init__(
        self, session: Session, site: Site, first: int, starts: Mapping[str, Sequence[Start]] | None = None
    ) -> None:
        self.session, self.site = session, site
        self.starts = session.opened.plan.starts if starts is None else starts
        self.first = self.since = -(-first // site.hold) * site.hold
        """`since` is the base step from which on a signal is altered."""
        self.flights = 0
        self.peaks = np.zeros(len(site.channels))
        """The largest value of each channel before the injection."""
        self.latest: dict[Node, deque[float]] = {}
        """What each receiver was given before the injection, the last value at the end."""
        self._kept: Kept | None = None
        self._begun = Altered()
        self._failed = False
        """Whether a flight has failed since, which closes the instances and ends what they have kept."""

    @property
    def period(self) -> float:
        """Seconds from sample to sample."""
        return self.site.hold * self.session.opened.plan.clock.step

    @property
    def scales(self) -> Floats:
        """The size of each channel: the largest value of its port before the injection, or its nominal one."""
        if not self.flights:
            self._begin()
        channels = self.site.channels
        ports = [channel.port for channel in channels]
        largest = {port: max(p for p, of in zip(self.peaks, ports, strict=True) if of == port) for port in ports}
        return np.array([largest[channel.port] or channel.nominal for channel in channels])

    def _begin(self, altered: Altered = Altered(), kept: Kept | None = None) -> None:
        """Flies to the step before `first`, from where another rig has kept it."""
        self.flights += 1
        self._begun, self._failed = altered, False
        if kept is None:
            self.latest = {r.target: deque(maxlen=_LATEST) for channel in self.site.channels for r in channel.receivers}
        last = self.first - 1  # the step up to `first` may take the first value already
        until = last if last > 0 else 2 * self.site.hold
        given = _Given(self, np.empty((0, len(self.peaks))), altered, 0 if kept is None else kept.count)
        self._flown(given, self.starts, (), (), Options(until=until, kept=kept), _BEYOND)
        self._kept = self.session.kept(last) if last > 0 else None

    def further(self, more: int, altered: Altered) -> Rig:
        """Returns the rig so many samples later, with the signals altered since this one's beginning."""
        if not self.flights:
            self._begin()
        rig = Rig(self.session, self.site, self.first + more * self.site.hold, self.starts)
        rig.since, rig.peaks = self.since, self.peaks.copy()
        rig.latest = {node: values.copy() for node, values in self.latest.items()}
        rig._begin(altered, self._kept)
        return rig

    def fly(
        self,
        injected: Floats,
        altered: Altered = Altered(),
        observers: Sequence[Observer] = (),
        nodes: Sequence[Node] = (),
        starts: Mapping[str, Sequence[Start]] | None = None,
        after: Callable[[Block], None] | None = None,
    ) -> Floats:
        """Returns what comes back to each channel, before the injection is added, (samples, channels).

        `injected` (samples, channels) is held from sample to sample, in the unit of the port. `observers` see what
        follows `first`, or all. `after` is called with a receiver after the step that takes the first sample. Raises
        BlockError where a block fails.
        """
        if not self.flights or self._failed:
            self._begin(self._begun)
        self.flights += 1
        kept = self._kept if starts is None else None
        given = _Given(self, injected, altered, 0 if kept is None else kept.count, after)
        starts = self.starts if starts is None else starts
        self._flown(given, starts, observers, nodes, Options(kept=kept), len(injected) * self.site.hold)
        return given.came

    def _flown(
        self,
        given: _Given,
        starts: Mapping[str, Sequence[Start]],
        observers: Sequence[Observer],
        nodes: Sequence[Node],
        options: Options,
        more: int,
    ) -> None:
        circuit, steps = self.session.opened.plan.circuit, self.first + more
        circuit = replace(circuit, clock=replace(circuit.clock, steps=steps, interval=steps))

        def around(blocks: Blocks) -> Blocks:
            found: dict[str, dict[Element, tuple[int, Receiver]]] = {}
            for number, channel in enumerate(self.site.channels):
                for receiver in channel.receivers:
                    found.setdefault(receiver.target.block, {})[receiver.target.element] = number, receiver
            fronts = {name: _Front(blocks[name], circuit.rate(name), taken, given) for name, taken in found.items()}
            return {**blocks, **fronts}

        flown = self.session.fly(starts, observers, nodes, circuit=circuit, around=around, options=options).whole()
        if flown.failure is not None:
            self._kept, self._failed = None, True
            raise flown.failure


class _Given:
    """Inputs of a flight, and what comes back."""

    def __init__(
        self,
        rig: Rig,
        injected: Floats,
        altered: Altered = Altered(),
        begun: int = 0,
        after: Callable[[Block], None] | None = None,
    ) -> None:
        self.rig, self.injected, self.altered, self.begun, self.after = rig, injected, altered, begun, after
        self.came = np.full(injected.shape, np.nan)


class _Front(Front):
    """A receiver with what is added to some of its inputs."""

    def __init__(self, inner: Block, every: int, taken: Mapping[Element, tuple[int, Receiver]], given: _Given) -> None:
        super().__init__(inner)
        self._every, self._taken, self._given = every, taken, given

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        values = super().wire(inputs, outputs, live, into)
        flight, every, hand_over = self._given, self._every, self.inner.set_inputs
        rig, injected, came = flight.rig, flight.injected, flight.came
        first, since, hold = rig.first, rig.since, rig.site.hold
        peaks, channels = rig.peaks, rig.site.channels
        gain, late, tape = flight.altered.gain, flight.altered.delay // every, flight.altered.tape
        places = [
            (place, number, receiver, channels[number].receivers[0] is receiver)
            for place, element in enumerate(inputs)
            if element in self._taken
            for number, receiver in [self._taken[element]]
        ]
        waiting = {place: deque([0.0] * late) for place, *_ in places}
        calls, remembers, looks = flight.begun // every, not len(injected), bool(late) or not len(injected)
        if flight.begun and late:
            for place, _, receiver, _ in places:
                latest = list(rig.latest[receiver.target])
                waiting[place] = deque(([0.0] * late + latest)[len(latest) :])

        def set_inputs() -> None:
            nonlocal calls
            calls += 1
            if calls * every < since and not looks:
                hand_over()
                return
            for place, number, receiver, sampled in places:
                value, factor = values[place], receiver.factor
                if remembers:
                    rig.latest[receiver.target].append(value)
                    if sampled:
                        peaks[number] = max(peaks[number], abs(value / factor))
                at = calls * every - receiver.behind
                sample, within = divmod(at - first, hold)
                if late:
                    waiting[place].append(value)
                    before = waiting[place].popleft()
                    value = before if at >= since else value
                if at >= since:
                    value *= gain
                if 0 <= sample < len(injected):
                    if sampled and within < every:
                        came[sample, number] = value / factor
                    if tape is not None:
                        value = factor * tape[sample, number]
                    value += factor * injected[sample, number]
                values[place] = value
            hand_over()

        self.set_inputs = set_inputs
        if (after := flight.after) is not None:
            step, behind = self.do_step, places[0][2].behind

            def do_step(time: float, length: float) -> None:
                step(time, length)
                if calls * every - behind == first:
                    after(self.inner)

            self.do_step = do_step
        return values
