"""Plays another team's FMU beside ours, and says how far ours with misread inputs is from it.

Theirs is played on some instants of the lively part of the run of ours, each held for a while, so that what is late or
slow has settled. Hypotheses are played on ours: a wiring misreads its inputs.

Longer than 250 lines: the two benches and what is compared on them have one state.
Tests: tests/orchestration/acceptance/test_polarity.py, tests/torture/polarity.py, tests/vendors.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ...fmu.model import Floats, Variable
from ...quantities import ONE
from .bench import Bench, flown_inputs
from .fly import Loop
from .ports import Port, kind_of
from .wrongs import Wrong, frames_of, signed_permutations, undo, wrongs

INSTANTS, COARSE, HELD = 24, 6, 16
"""How many instants of a run are played, how many of them in the search of pairs, and for how many steps each."""
ALIKE = 1e-6
"""A share of an output's size by which two agree to rounding."""
SAME = 1e-10
"""And one up to which they are the same."""
CHANGE, MINUS = 2e-3, 1e-6
"""What a change of a port and each minus sign in it count as difference: of two that serve, the plainer is taken."""
_REPEATED, _ENOUGH = 3, 8
"""At so many instants an output that saturates is at its largest, and so many others have to be left."""
_LIVELY = 1.0 / 3.0
"""Share of the run, from its start, of which the instants are."""
_MOST = 4000
"""Samples of a run that are played."""

Changes = dict[str, Wrong]
"""By input: how it is misread."""


@dataclass(frozen=True)
class Score:
    """Distance of theirs from ours, and the changes of the outputs that bring it nearest."""

    error: float
    """The mean over the outputs of the rms of the difference, over that of ours; 1 is as bad as zeros."""
    cost: float
    """The error, and what the changes count."""
    outputs: dict[str, Wrong] = field(default_factory=dict)


class Identifier:
    """Theirs and ours on one bench."""

    def __init__(self, ours: Loop, theirs: Loop, block: str, stack: ExitStack) -> None:
        self.block = block
        nodes = list(dict.fromkeys(node for link in ours.plan.wiring.links for node in link.source))
        fed = [node for link in theirs.plan.wiring.links for node in link.source if node.block != block]
        _, signals = ours.record(list(dict.fromkeys([*nodes, *fed])))
        flown = flown_inputs(ours, block, signals)
        alone = {n: v for n, v in flown_inputs(theirs, block, signals).items() if n not in flown}
        there = min(map(len, signals.values()))
        lively = min(max(int(_LIVELY * there), INSTANTS), there)
        self.rows = np.unique(np.linspace(0, lively - 1, INSTANTS).astype(int))
        model = theirs.plan.models[block]
        self._ours, self._theirs = Bench(ours, block, stack), Bench(theirs, block, stack)
        every = ours.plan.scenario.blocks[block].every
        self._alone, self._fed = set(alone), set(flown)  # inputs that only theirs has, and those of ours
        flown |= alone
        self.whole = {n: v[::every][:_MOST] for n, v in flown.items()}
        self.few = {n: v[self.rows] for n, v in flown.items()}
        shared = [
            n for n in flown if n in self._fed and n in model.variables and model.variables[n].causality == "input"
        ]
        self.inputs = {n: self.few[n] for n in shared}
        fits = theirs.opened.prepared.fits.get(block)
        reference = self.ours_on(self.few)
        if reference is None:
            raise ValueError(f"{block}: ours refuses the inputs of its own run when they are played to it")
        own = {n: v for n, v in reference.items() if n in model.variables and model.variables[n].causality == "output"}
        linked = own if fits is None else {n: v for n, v in own.items() if n in fits.links}
        self.reference = {n: v for n, v in linked.items() if np.abs(v).max() > 0.0}
        needed = {s.element.variable for link in ours.plan.wiring.links for s in link.source if s.block == block}
        self._weights = {name: 1.0 if name in needed else 0.25 for name in self.reference}
        self.ports = {name: self._port(name, values, "input") for name, values in self.inputs.items()}
        self.ports |= {name: self._port(name, values, "output") for name, values in self.reference.items()}
        links = fits.links if fits is not None else {}
        self.quaternions = {n: links[n].inverse for n in self.inputs if n in links and links[n].A is None}
        self.turned = {n for n in self.inputs if n in links and links[n].turned}
        self._finals = {n: _finals(port) for n, port in self.ports.items() if port.causality == "output"}
        self.base: Changes = {}
        """What theirs has to be spared to take its inputs at all."""
        self._refused: set[tuple[str, str]] = set()
        """Inputs and wrong wirings of them that ours refuses, such as a matrix that is no rotation."""
        held = self._held(self.few)
        again = self.ours_on(held)
        same = again is not None and all(
            np.abs(again[n][self._ends] - v).max() <= ALIKE * np.abs(v).max() for n, v in self.reference.items()
        )
        self._steady = held if same else self.few
        self._kept = self._ends if same else np.arange(len(self.rows))
        self.given = self._take()

    def _held(self, values: dict[str, Floats]) -> dict[str, Floats]:
        """Returns each instant held, behind the first, with which the block starts."""
        self._ends = np.arange(1, len(self.rows) + 1) * HELD
        return {n: np.concatenate([v[:1], np.repeat(v, HELD, axis=0)]) for n, v in values.items()}

    def ours_on(self, values: dict[str, Floats]) -> dict[str, Floats] | None:
        """Returns what ours gives on these inputs."""
        return self._ours.play({n: v for n, v in values.items() if n in self._fed})

    def theirs_on(self, values: dict[str, Floats], changes: Changes | None = None) -> dict[str, Floats] | None:
        """Returns what theirs gives where it is handed what makes it read these inputs, misread as it does."""
        handed = {n: v for n, v in values.items() if n in self.inputs}
        for name, wrong in {**self.base, **(changes or {})}.items():
            if wrong.along is not None:
                R = values[wrong.along[0]].reshape(-1, 3, 3)
                handed[name] = np.einsum("nij,nj->ni" if wrong.along[1] else "nji,nj->ni", R, values[name])
            else:
                handed[name] = undo(wrong, values[name])
        handed |= {n: values[n] for n in self._alone}
        return self._theirs.play(handed)

    def _take(self) -> dict[str, Floats] | None:
        """Plays theirs on the instants; where it refuses them, with one input after the other read otherwise."""
        tries: list[Changes] = [
            {},
            *({n: w} for n in self.inputs for w in self.candidates(n) if w.kind in ("unit", "attitude")),
        ]
        for self.base in tries:
            played = self.theirs_on(self._steady)
            if played is not None and all(n in played for n in self.reference):
                return {n: v[self._kept] for n, v in played.items()}
        self.base = {}
        return None

    def _port(self, name: str, values: Floats, causality: str) -> Port:
        variable = self._theirs.model.variables[name]
        positions = tuple(range(variable.size))
        kind = kind_of(variable, positions, values)
        return Port(self.block, name, causality, positions, kind, variable.unit or ONE, variable.size)

    def candidates(self, name: str) -> list[Wrong]:
        """Returns the wrong wirings of an input that theirs may behave as, but for those that ours has refused."""
        return [w for w in self._candidates(name) if (name, w.name) not in self._refused]

    def _candidates(self, name: str) -> list[Wrong]:
        port = self.ports[name]
        tried = wrongs(port, True)
        if name in self.quaternions:
            turns = [w for w in tried if w.turn is not None or w.name == "transposed"]
            return [_of_the_inverse(w) if self.quaternions[name] else w for w in turns]
        tried = [w for w in tried if w.turn is None]
        if port.kind == "vector" and (matrix := self._matrix_of(name)):
            inverse = name in self.turned
            words = f"along the axes of {matrix}'s other side"
            tried.append(Wrong(f"read {words}", "frame", along=(matrix, not inverse)))
        return tried

    def _matrix_of(self, name: str) -> str | None:
        """Returns the rotation matrix among the inputs whose one side is the frame of a vector."""
        frame = self._theirs.model.variables[name].frame or ""
        for other, port in self.ports.items():
            if port.causality == "input" and port.kind == "rotation":
                sides = frames_of(self._theirs.model.variables[other])
                if len(sides) == 2 and sides[1] == frame:
                    return other
        return None

    @cached_property
    def common(self) -> list[Changes]:
        """Returns one turn, or one mirror, of all that has components along a frame's axes, where ours feels it:
        where N is turned whole, a law gives the same."""
        variables: dict[str, Variable] = {n: self._theirs.model.variables[n] for n in self.inputs}
        frames = dict.fromkeys(f for v in variables.values() for f in frames_of(v))
        made: list[Changes] = []
        for frame in frames:
            for words, P in signed_permutations()[1:]:
                changes: Changes = {}
                for name, variable in variables.items():
                    sides, kind = frames_of(variable), self.ports[name].kind
                    if kind == "vector" and sides == [frame]:
                        changes[name] = next(w for w in wrongs(self.ports[name]) if w.name == words)
                    elif kind == "rotation" and frame in sides and name not in self.quaternions:
                        side = "rows" if sides[0] == frame else "columns"
                        matrix = np.asarray(
                            np.kron(P, np.eye(3)) if side == "rows" else np.kron(np.eye(3), P), np.float64
                        )
                        changes[name] = Wrong(f"{side} {words}", "axes", matrix)
                if len(changes) > 1 and changes not in made and self._felt(changes):
                    made.append(changes)
        return made

    def _felt(self, changes: Changes) -> bool:
        played = self.ours_on(self.misread(self.few, changes))
        return played is None or any(
            np.abs(played[n] - v).max() > ALIKE * np.abs(v).max() for n, v in self.reference.items()
        )

    def misread(self, values: dict[str, Floats], changes: Changes) -> dict[str, Floats]:
        """Returns inputs as theirs reads them: a vector along other axes by the matrix as that is read."""
        read = values | {n: w.apply(values[n]) for n, w in changes.items() if w.along is None}
        for name, wrong in changes.items():
            if wrong.along is not None:
                R = read[wrong.along[0]].reshape(-1, 3, 3)
                read[name] = np.einsum("nji,nj->ni" if wrong.along[1] else "nij,nj->ni", R, values[name])
        return read

    def error(self, changes: Changes, count: int = INSTANTS) -> Score:
        """Returns how far theirs is from ours that misreads its inputs so, on some of the instants."""
        n = len(self.rows)
        chosen = np.arange(n) if count >= n else np.linspace(0, n - 1, count).astype(int)
        played = self.ours_on(self.misread({k: v[chosen] for k, v in self.few.items()}, {**self.base, **changes}))
        if played is None or self.given is None:
            if len(changes) == 1:
                self._refused.update((name, wrong.name) for name, wrong in changes.items())
            return Score(np.inf, np.inf)
        return self.scored(played, {k: v[chosen] for k, v in self.given.items()}, changes)

    def corrected(self, changes: Changes) -> Score:
        """Returns how far theirs is from ours where its misreadings are undone: none of the two then meets a limit."""
        played = self.theirs_on(self._steady, changes)
        if played is None:
            return Score(np.inf, np.inf)
        return self.scored(self.reference, {n: v[self._kept] for n, v in played.items()}, changes)

    def scored(self, ours: dict[str, Floats], theirs: dict[str, Floats], changes: Changes) -> Score:
        """Returns the score of what ours and theirs gave."""
        outputs: dict[str, Wrong] = {}
        total = 0.0
        for name in self.reference:
            free = _unlimited(theirs[name])
            wrong, error = self._nearest(name, ours[name][free], theirs[name][free])
            total += self._weights[name] * min(error, 2.0)
            if wrong is not None:
                outputs[name] = wrong
        error = total / sum(self._weights.values())
        matrices = {key_of(w) for w in changes.values()} if len(changes) > 1 else set(map(key_of, changes.values()))
        counted = CHANGE * (len(matrices) + len(outputs)) + MINUS * sum(map(minus_of, changes.values()))
        return Score(error, error + counted + MINUS * sum(map(minus_of, outputs.values())), outputs)

    def _nearest(self, name: str, ours: Floats, theirs: Floats) -> tuple[Wrong | None, float]:
        """Returns the change of an output that brings it nearest to ours, None for none; and how far it is then."""
        changes, stacked, counts = self._finals[name]
        square = float((ours * ours).sum()) or 1.0
        # |theirs M^T - ours|^2 of all M at once, from the products of the two with each other.
        own, mixed = theirs.T @ theirs, ours.T @ theirs
        errors = np.einsum("nij,jk,nik->n", stacked, own, stacked) - 2.0 * np.einsum("nij,ij->n", stacked, mixed)
        least = int((np.sqrt(np.maximum(errors + square, 0.0) / square) + counts).argmin())
        return changes[least], float(np.linalg.norm(theirs @ stacked[least].T - ours)) / square**0.5


def _unlimited(theirs: Floats) -> Floats:
    """Returns the instants at which no element is at its largest, where it is so at several, as one that saturates or
    is stuck; all where too few are left."""
    sizes = np.abs(theirs)
    at_most = (sizes >= (1.0 - 1e-9) * sizes.max(axis=0)) & (sizes > 0.0)
    free = ~(at_most & (at_most.sum(axis=0) >= _REPEATED)).any(axis=1)
    return free if free.sum() >= _ENOUGH else np.ones(len(theirs), bool)


def _of_the_inverse(wrong: Wrong) -> Wrong:
    """Returns the wrong reading of a quaternion that is that of the inverse rotation."""
    if wrong.turn is None:
        return wrong
    return Wrong(wrong.name, wrong.kind, turn=(f"inverse, {wrong.turn[0]}", not wrong.turn[1]))


def key_of(wrong: Wrong) -> str:
    """Returns a name that one turn of several ports has in common."""
    return wrong.name.removeprefix("rows ").removeprefix("columns ")


def minus_of(wrong: Wrong) -> int:
    return 0 if wrong.matrix is None else int((wrong.matrix < 0.0).sum())


def _finals(port: Port) -> tuple[list[Wrong | None], Floats, Floats]:
    """Returns changes of an output, first none: axes and signs, each also with a usual factor; matrices, and costs."""
    every = [w for w in wrongs(port, True) if w.matrix is not None]
    n = len(port.positions)
    turned = [w for w in every if w.kind in ("axes", "sign")] if port.kind in ("vector", "scalar") else []
    units = [w for w in every if w.kind == "unit"]
    pairs = [(f"{a.name}, {u.name}", a.matrix, u.matrix) for a in turned for u in units]
    every += [Wrong(name, "axes", u @ a) for name, a, u in pairs if a is not None and u is not None]
    matrices = [np.eye(n), *(w.matrix for w in every if w.matrix is not None)]
    return [None, *every], np.array(matrices), np.array([0.0, *(CHANGE + MINUS * minus_of(w) for w in every)])
