"""Finds as which wrong wiring another team's FMU behaves: its outputs beside ours, on the inputs of ours in a run.

Both are given instants of the run, spread over its lively part, one a step. What is handed to theirs is changed port by
port, and what it gives is compared with ours in every order and sign, until the two agree.
No output has to agree to the last digit, since theirs may round, saturate or filter; `mend.SMALL` says how near.

Tests: tests/orchestration/acceptance/test_polarity.py, tests/torture/polarity.py.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from itertools import combinations, islice
from time import monotonic

import numpy as np

from ...fmu.model import Floats
from ...quantities import ONE
from ...scenario.source import Source
from .bench import Bench, flown_inputs
from .fly import Loop
from .ports import Port, kind_of
from .wrongs import Wrong, wrongs

INSTANTS, COARSE = 24, 6
"""How many instants of a run are played, and how many of them in the search of pairs."""
ALIKE = 1e-6
"""A share of an output's size by which two agree to rounding."""
_CHANGE, _MINUS = 2e-3, 1e-6
"""What a change of a port and each minus sign in it count as difference: of two that serve, the plainer is taken."""
_LIVELY = 1.0 / 3.0
"""Share of the run, from its start, of which the instants are."""
SECONDS = 120.0
"""The search ends after so long."""

Changes = dict[str, Wrong]
"""By input: what is handed over instead."""


@dataclass(frozen=True)
class Score:
    """How far theirs is from ours, and the changes of the outputs that bring it nearest."""

    error: float
    """The mean over the outputs of the rms of the difference, over that of ours; 1 is as bad as zeros."""
    cost: float
    """The error, and what the changes count."""
    outputs: dict[str, Wrong] = field(default_factory=dict)


@dataclass(frozen=True)
class Identified:
    """The changes under which theirs is nearest to ours."""

    inputs: Changes
    outputs: dict[str, Wrong]
    before: float
    after: float
    ports: dict[str, Port]
    complete: bool = True
    """Whether the search ended before its time was over."""


class Identifier:
    """Theirs and ours on one bench."""

    def __init__(self, ours: Loop, theirs: Loop, block: str, stack: ExitStack) -> None:
        self.block = block
        nodes = list(dict.fromkeys(node for link in ours.plan.wiring.links for node in link.source))
        _, signals = ours.record(nodes)
        flown = flown_inputs(ours, block, signals)
        count = len(next(iter(flown.values())))
        lively = min(max(int(_LIVELY * count), INSTANTS), count)
        rows = np.unique(np.linspace(0, lively - 1, INSTANTS).astype(int))
        model = theirs.plan.models[block]
        self.inputs = {
            n: v[rows] for n, v in flown.items() if n in model.variables and model.variables[n].causality == "input"
        }
        self._ours, self._theirs = Bench(ours, block, stack), Bench(theirs, block, stack)
        reference = self._ours.play({name: values[rows] for name, values in flown.items()})
        if reference is None:
            raise ValueError(f"{block}: ours refuses the inputs of its own run when they are played to it")
        own = {n: v for n, v in reference.items() if n in model.variables and model.variables[n].causality == "output"}
        fits = theirs.opened.prepared.fits.get(block)
        linked = own if fits is None else {n: v for n, v in own.items() if n in fits.links}
        self.reference = {n: v for n, v in linked.items() if np.abs(v).max() > 0.0}
        needed = {s.element.variable for link in ours.plan.wiring.links for s in link.source if s.block == block}
        self._weights = {name: 1.0 if name in needed else 0.25 for name in self.reference}
        self.ports = {name: self._port(name, values, "input") for name, values in self.inputs.items()}
        self.ports |= {name: self._port(name, values, "output") for name, values in self.reference.items()}
        self.quaternions = {n for n, link in (fits.links.items() if fits else ()) if link.A is None}
        self._finals = {n: _finals(port) for n, port in self.ports.items() if port.causality == "output"}
        self._settle()

    def _port(self, name: str, values: Floats, causality: str) -> Port:
        variable = self._theirs.model.variables[name]
        positions = tuple(range(variable.size))
        kind = kind_of(variable, positions, values)
        from_unit = variable.unit
        return Port(self.block, name, causality, positions, kind, from_unit or ONE, variable.size)

    def _settle(self) -> None:
        """Takes a new instance each time where one that is reset does not give the same again."""
        first, second = (self.error({}).error for _ in range(2))
        if first != second:
            self._theirs.keeps_instance = False

    def candidates(self, name: str) -> list[Wrong]:
        """Returns what may be handed to an input instead: what undoes each of its wrong wirings."""
        tried = wrongs(self.ports[name])
        if name not in self.quaternions:
            return [w for w in tried if w.turn is None]
        turns = [w for w in tried if w.turn is not None or w.name == "transposed"]
        # Who inverts what he reads is helped by the quaternion of the inverse.
        return [replace(w, turn=(f"inverse, {w.turn[0]}", False)) if w.turn and w.turn[1] else w for w in turns]

    def error(self, changes: Changes, count: int = INSTANTS) -> Score:
        """Returns how far theirs is from ours with these changes, on some of the instants."""
        chosen = slice(None) if count >= INSTANTS else slice(0, None, INSTANTS // count)
        handed = {n: changes[n].apply(v[chosen]) if n in changes else v[chosen] for n, v in self.inputs.items()}
        played = self._theirs.play(handed)
        if played is None:
            return Score(np.inf, np.inf)
        outputs: dict[str, Wrong] = {}
        total = 0.0
        for name, ours in self.reference.items():
            wrong, error = self._nearest(name, ours[chosen], played[name])
            total += self._weights[name] * min(error, 2.0)
            if wrong is not None:
                outputs[name] = wrong
        error = total / sum(self._weights.values())
        return Score(error, error + sum(map(_count, (*changes.values(), *outputs.values()))), outputs)

    def as_wired(self) -> float:
        """Returns how far theirs is from ours with nothing changed."""
        played = self._theirs.play(self.inputs)
        if played is None:
            return np.inf
        sizes = {name: float(np.linalg.norm(ours)) for name, ours in self.reference.items()}
        apart = {n: float(np.linalg.norm(played[n] - ours)) / sizes[n] for n, ours in self.reference.items()}
        return sum(self._weights[n] * min(x, 2.0) for n, x in apart.items()) / sum(self._weights.values())

    def _nearest(self, name: str, ours: Floats, theirs: Floats) -> tuple[Wrong | None, float]:
        """Returns the change of an output that brings it nearest to ours, None for none; and how far it is then."""
        changes, stacked, counts = self._finals[name]
        square = float((ours * ours).sum()) or 1.0
        # |theirs M^T - ours|^2 of all M at once, from the products of the two with each other.
        own, mixed = theirs.T @ theirs, ours.T @ theirs
        errors = np.einsum("nij,jk,nik->n", stacked, own, stacked) - 2.0 * np.einsum("nij,ij->n", stacked, mixed)
        least = int((np.sqrt(np.maximum(errors + square, 0.0) / square) + counts).argmin())
        return changes[least], float(np.linalg.norm(theirs @ stacked[least].T - ours)) / square**0.5

    def search(self) -> Identified:
        """Looks at each input alone, then at pairs, then at one after the other again."""
        ends = monotonic() + SECONDS
        complete = True
        ranked = self._ranked([{}, *({name: w} for name in self.inputs for w in self.candidates(name))], INSTANTS)
        starts = [changes for _, changes in ranked[:3]]
        if ranked[0][0].error > 10 * ALIKE:
            vectors = [n for n in self.inputs if self.ports[n].kind in ("vector", "rotation")]
            axes = {n: [w for w in self.candidates(n) if w.kind != "unit"] for n in vectors}
            pairs = ({a: one, b: two} for a, b in combinations(vectors, 2) for one in axes[a] for two in axes[b])
            found: list[tuple[Score, Changes]] = []
            while part := list(islice(pairs, 500)):
                found = sorted([*found, *self._ranked(part, COARSE)], key=lambda pair: pair[0].cost)[:6]
                if found[0][0].error < ALIKE:
                    break
                if monotonic() > ends:
                    complete = False
                    break
            starts = [changes for _, changes in found[:4]] + starts
        reached: list[tuple[Score, Changes]] = []
        for start in starts:
            reached.append(self._descend(start))
            if reached[-1][0].error <= ALIKE:
                break
        score, changes = min(reached, key=lambda pair: pair[0].cost)
        return Identified(changes, score.outputs, self.as_wired(), score.error, self.ports, complete)

    def _ranked(self, tried: list[Changes], count: int) -> list[tuple[Score, Changes]]:
        scored = [(self.error(changes, count), changes) for changes in tried]
        return sorted(scored, key=lambda pair: pair[0].cost)

    def _descend(self, changes: Changes) -> tuple[Score, Changes]:
        """Takes the best change of one input after the other, as long as the cost gets smaller."""
        score = self.error(changes)
        for _ in range(3):
            before = score.cost
            for name in self.inputs:
                now = changes.get(name)
                others = {n: w for n, w in changes.items() if n != name}
                tried = [others] if now is not None else []
                if score.error > ALIKE:  # else what is changed can only get less
                    tried += [{**others, name: w} for w in self._near(name, now)]
                if not tried:
                    continue
                reached, candidate = self._ranked(tried, INSTANTS)[0]
                if reached.cost < score.cost:
                    score, changes = reached, candidate
            if score.cost >= before:
                break
        return score, changes

    def _near(self, name: str, now: Wrong | None) -> list[Wrong]:
        """Returns every change of an input, and those made of the present one and another."""
        every = self.candidates(name)
        if now is None or now.matrix is None:
            return every
        more = [w for w in every if w.matrix is not None and (w.kind == "unit") != (now.kind == "unit")]
        return every + [
            Wrong(f"{now.name}, {w.name}", "axes", now.matrix @ w.matrix) for w in more if w.matrix is not None
        ]


def _count(wrong: Wrong) -> float:
    """Returns what a change counts beside the difference."""
    minus = 0 if wrong.matrix is None else int((wrong.matrix < 0.0).sum())
    return _CHANGE + _MINUS * minus


def _finals(port: Port) -> tuple[list[Wrong | None], Floats, Floats]:
    """Returns changes of an output, first none: axes and signs, each also with a usual factor; matrices, and costs."""
    every = [w for w in wrongs(port) if w.matrix is not None]
    n = len(port.positions)
    turned = [w for w in every if w.kind in ("axes", "sign")] if port.kind in ("vector", "scalar") else []
    units = [w for w in every if w.kind == "unit"]
    pairs = [(f"{a.name}, {u.name}", a.matrix, u.matrix) for a in turned for u in units]
    every += [Wrong(name, "axes", u @ a) for name, a, u in pairs if a is not None and u is not None]
    matrices = [np.eye(n), *(w.matrix for w in every if w.matrix is not None)]
    return [None, *every], np.array(matrices), np.array([0.0, *map(_count, every)])


def open_identifier(ours: Source, theirs: Source, block: str, stack: ExitStack) -> Identifier:
    """Opens both for a bench in this process."""
    return Identifier(Loop(ours), Loop(theirs), block, stack)


def identify(ours: Source, theirs: Source, block: str) -> Identified:
    """Returns as which wrong wiring the block of the second scenario behaves. Raises InputError."""
    with ExitStack() as stack:
        return open_identifier(ours, theirs, block, stack).search()
