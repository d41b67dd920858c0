"""Another team's block behind our interface: the master sees our names, units and quantities.

Every value that passes is theirs = A ours + c, the whole of a block in one product; quaternions are
made and read beside it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..errors import BlockError
from ..fmu.model import TYPES, Element, Floats
from .named_values import NamedValues


class Adapter(NamedValues):
    """See `block.Block`."""

    def wire(self, inputs: Sequence[Element], outputs: Sequence[Element], live: Sequence[int], into: Floats) -> Floats:
        self._wire_inputs(inputs)
        self._wire_outputs(outputs, live, into)
        self.do_step = self.inner.do_step
        return self._given

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
            if link.A is None or link.c is None or link.turned:
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
                    ours = whole[columns].tolist()
                    if link.A is not None and link.c is not None:
                        buffer[rows] = link.A @ self._turned(link, ours) + link.c
                    else:
                        buffer[rows] = self._rotation(link, ours)
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
        """Returns whether it comes from theirs; inputs, and what cannot be turned back, are as they were handed in."""
        link = self._links.get(element.variable)
        return link is not None and link.ours.causality != "input" and (link.A is None or link.B is not None)

    def _sources(self, element: Element) -> list[Element]:
        link = self._links[element.variable]
        if link.B is None:
            return list(link.theirs)
        return [link.theirs[j] for j in np.flatnonzero(link.B[element.position])]


def _then(first: Callable[[], None], second: Callable[[], None]) -> Callable[[], None]:
    def both() -> None:
        first()
        second()

    return both
