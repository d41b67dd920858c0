"""Another team's block behind our interface: the master sees our names, units and quantities.

Every value that passes is theirs = A ours + c, the whole of a block in one product; quaternions are
made and read beside it. A block with a sample time of its own is stepped so often in each step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ..errors import BlockError
from ..fmu.model import TYPES, Element, Floats, Model
from ..instances.block import Block
from . import rotation
from .as_ours import model
from .findings import Fit, Link


class Adapter:
    """See `block.Block`. `substeps` steps of theirs make one of ours."""

    def __init__(self, inner: Block, fit: Fit, substeps: int = 1) -> None:
        self.inner, self.fit, self.substeps = inner, fit, substeps
        self.name = inner.name
        self.model: Model = model(fit)
        self._links = dict(fit.links)
        for variable in fit.extra:  # under their own names, as they are
            n = variable.size
            self._links[variable.name] = Link(variable, tuple(variable.elements), np.eye(n), np.zeros(n), np.eye(n))
        self._values: dict[Element, Any] = {}
        """What our inputs and parameters were set to."""
        self._signs: dict[str, list[float]] = {}
        """The last quaternion of each port, which the next one follows."""
        self._place: dict[Element, int] = {}
        """Where each input of ours stands once it is wired, in `_ours`."""

    @property
    def log(self) -> Sequence[str]:
        return self.inner.log

    # ------------------------------------------------------------ by name, before the first step and in faults

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        touched: dict[str, None] = {}
        for element, value in values:
            self._values[element] = value
            touched[element.variable] = None
            if element in self._place:
                self._ours[self._place[element]] = value
        theirs: list[tuple[Element, Any]] = []
        for name in touched:
            if name in self._links:
                theirs += self._forward(self._links[name])
        if theirs:
            self.inner.set(theirs)

    def _forward(self, link: Link) -> list[tuple[Element, Any]]:
        """Theirs of a port, from what ours was set to; elements never set are those of the interface's starts."""
        ours = [self._value(e) for e in link.ours.elements]
        if link.ours.type != "real":
            known = zip(link.theirs, link.ours.elements, ours, strict=True)
            return [(theirs, value) for theirs, element, value in known if element in self._values]
        if link.A is None or link.c is None:
            return list(zip(link.theirs, self._quaternion(link, ours), strict=True))
        rows = [
            row
            for row in range(len(link.theirs))
            if any(link.ours.elements[j] in self._values for j in np.flatnonzero(link.A[row]))
        ]
        values = link.A @ np.array(ours, float) + link.c
        return [(link.theirs[row], float(values[row])) for row in rows]

    def _value(self, element: Element) -> Any:
        """What one of ours was last given."""
        at = self._place.get(element)
        if at is not None:
            return self._ours[at]
        return self._values.get(element, self.fit.reference.starts.get(element, 0))

    def _quaternion(self, link: Link, R: Sequence[float]) -> list[float]:
        q = rotation.quaternion(rotation.transposed(R) if link.inverse else R, self._signs.get(link.ours.name))
        self._signs[link.ours.name] = q
        return [*q[1:], q[0]] if link.scalar_last else q

    def _matrix(self, link: Link, q: Sequence[float]) -> list[float]:
        try:
            R = rotation.matrix([q[3], *q[:3]] if link.scalar_last else q)
        except ValueError as error:
            names = ", ".join(dict.fromkeys(e.variable for e in link.theirs))
            raise BlockError(
                self.name, f"output {names}", f"stands for our {link.ours.name}: {error}", log=self.log
            ) from None
        return rotation.transposed(R) if link.inverse else R

    def get(self, elements: Sequence[Element]) -> list[float]:
        values: dict[Element, float] = {}
        for name in dict.fromkeys(e.variable for e in elements):
            variable = self.model.variables[name]
            link = self._links.get(name)
            if link is None or variable.causality == "input" or (link.A is not None and link.B is None):
                values.update((e, float(self._value(e))) for e in variable.elements)
            else:
                theirs = self.inner.get(link.theirs)
                values.update(zip(variable.elements, self._back(link, theirs), strict=True))
        return [values[element] for element in elements]

    def _back(self, link: Link, theirs: Sequence[float]) -> list[float]:
        if link.B is None or link.c is None:
            return self._matrix(link, theirs)
        return (link.B @ (np.array(theirs) - link.c)).tolist()

    def enter(self, stop: float) -> None:
        self.inner.set(self.fit.start.items())
        self.inner.enter(stop)

    def leave(self) -> None:
        self.inner.leave()

    # ------------------------------------------------------------ steps

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        self._wire_inputs(inputs)
        self._wire_outputs(outputs, live, into)
        step, substeps = self.inner.do_step, self.substeps

        def often(time: float, length: float) -> None:
            for n in range(substeps):
                step(time + n * length / substeps, length / substeps)

        self.do_step = step if substeps == 1 else often
        return self._given

    set_inputs: Callable[[], None]
    get_live: Callable[[], None]
    get_all: Callable[[], None]
    do_step: Callable[[float, float], None]

    def _wire_inputs(self, inputs: Sequence[Element]) -> None:
        """From what is connected to the whole of each port of ours, and from there to theirs."""
        names = dict.fromkeys(e.variable for e in inputs)
        ours = [e for name in names for e in self.model.variables[name].elements]
        whole = np.array([float(self._value(e)) for e in ours])
        self._ours, self._place = whole, {element: i for i, element in enumerate(ours)}
        place = self._place
        given = self._given = whole[[place[e] for e in inputs]]
        linked = [self._links[name] for name in names if name in self._links]
        theirs = self._by_type(list(dict.fromkeys(e for link in linked for e in link.theirs)))
        A, c, turned = np.zeros((len(theirs), len(ours))), np.zeros(len(theirs)), []
        row_of = {element: i for i, element in enumerate(theirs)}
        for link in linked:
            rows, columns = [row_of[e] for e in link.theirs], [place[e] for e in link.ours.elements]
            if link.A is None or link.c is None:
                turned.append((link, np.array(rows), np.array(columns)))
            else:
                A[np.ix_(rows, columns)], c[rows] = link.A, link.c
        self._theirs_in = theirs
        places = np.array([place[e] for e in inputs], np.intp)
        self._push = lambda buffer: self._pusher(given, places, whole, A, c, turned, buffer)

    def _pusher(
        self, given: Floats, places: Any, whole: Floats, A: Floats, c: Floats, turned: list[Any], buffer: Floats
    ) -> Callable[[], None]:
        hand_over = self.inner.set_inputs

        def push() -> None:
            whole[places] = given
            if len(buffer):
                np.matmul(A, whole, out=buffer)
                np.add(buffer, c, out=buffer)
                for link, rows, columns in turned:
                    buffer[rows] = self._quaternion(link, whole[columns].tolist())
            hand_over()

        return push

    def _wire_outputs(self, outputs: Sequence[Element], live: Sequence[int], into: Floats) -> None:
        """Wires theirs, and makes ours of them; what was handed in is recorded as it was handed in."""
        first = np.cumsum([0, *(sum(self._type(e) == kind for e in outputs) for kind in TYPES)])
        alive = {e for kind, start, n in zip(TYPES, first[:-1], live, strict=True) for e in outputs[start : start + n]}
        fetched = [e for e in outputs if self._fetched(e)]
        theirs = {source: False for e in fetched for source in self._sources(e)}
        theirs |= {source: True for e in fetched if e in alive for source in self._sources(e)}
        ordered = self._by_type(sorted(theirs, key=lambda e: not theirs[e]))
        counts = [sum(theirs[e] for e in ordered if self._their_type(e) == kind) for kind in TYPES]
        values = np.zeros(len(ordered))
        buffer = self.inner.wire(self._theirs_in, ordered, counts, values)
        self.set_inputs = self._push(buffer)
        at = {e: i for i, e in enumerate(ordered)}
        rows = np.array([i for i, e in enumerate(outputs) if self._fetched(e)], np.intp)
        B, d, turned = np.zeros((len(rows), len(ordered))), np.zeros(len(rows)), []
        for row, element in enumerate(fetched):
            link = self._links[element.variable]
            columns = [at[source] for source in link.theirs if source in at]
            if link.B is None or link.c is None:
                turned.append((row, link, element.position, columns))
            else:
                used = np.flatnonzero(link.B[element.position])
                B[row, [at[link.theirs[j]] for j in used]] = link.B[element.position, used]
                d[row] = -(link.B[element.position] @ link.c)
        handed = [(i, e) for i, e in enumerate(outputs) if not self._fetched(e)]
        convert = self._converter(into, values, rows, B, d, turned, handed, ordered)
        self.get_live = _then(self.inner.get_live, convert)
        self.get_all = _then(self.inner.get_all, convert)

    def _converter(
        self, into: Floats, values: Floats, rows: Any, B: Floats, d: Floats, turned: Any, handed: Any, theirs: Any
    ) -> Callable[[], None]:
        out = np.zeros(len(rows))
        whole = len(rows) == len(into)
        target = into if whole else out

        def convert() -> None:
            if not math.isfinite(values.dot(values)):
                self._check(theirs, values)
            np.matmul(B, values, out=target)
            np.add(target, d, out=target)
            for row, link, position, columns in turned:
                target[row] = self._matrix(link, values[columns].tolist())[position]
            if not whole:
                into[rows] = target
                for place, element in handed:
                    into[place] = self._value(element)

        return convert

    def _check(self, theirs: Sequence[Element], values: Floats) -> None:
        """Refuses a value that is not finite by their name, before the product spreads it."""
        for element, value in zip(theirs, values.tolist(), strict=True):
            if not math.isfinite(value):
                name = self.fit.theirs.variables[element.variable].label(element.position)
                raise BlockError(self.name, f"output {name}", f"is {value}, expected a finite number", log=self.log)

    # ------------------------------------------------------------ helpers

    def _type(self, element: Element) -> str:
        return self.model.variables[element.variable].type

    def _their_type(self, element: Element) -> str:
        return self.fit.theirs.variables[element.variable].type

    def _by_type(self, elements: list[Element]) -> list[Element]:
        return sorted(elements, key=lambda e: TYPES.index(self._their_type(e)))

    def _fetched(self, element: Element) -> bool:
        """Whether it comes from theirs; inputs, and what cannot be turned back, are as they were handed in."""
        link = self._links.get(element.variable)
        return link is not None and link.ours.causality != "input" and (link.A is None or link.B is not None)

    def _sources(self, element: Element) -> list[Element]:
        link = self._links[element.variable]
        if link.B is None:
            return list(link.theirs)
        return [link.theirs[j] for j in np.flatnonzero(link.B[element.position])]

    def close(self) -> None:
        self.inner.close()


def _then(first: Callable[[], None], second: Callable[[], None]) -> Callable[[], None]:
    def both() -> None:
        first()
        second()

    return both


def handed_on(fit: Fit, starts: Iterable[tuple[Element, Any]]) -> dict[Element, Any]:
    """What theirs is given for start values of ours, by their elements; those of the mapping among them."""
    recorder: Any = _Recorder()
    recorder.set(fit.start.items())
    Adapter(recorder, fit).set(starts)
    return dict(recorder.values)


class _Recorder:
    """Stands for a block, and keeps what it is set to."""

    name = ""

    def __init__(self) -> None:
        self.values: dict[Element, Any] = {}

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        self.values.update(values)
