"""Values of another team's block under our names: what ours are set to becomes theirs, and theirs become ours."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from .. import rotation
from ..errors import BlockError
from ..fmu.model import Element, Floats
from ..instances.block import Block
from ..instances.front import Front
from .as_ours import in_ours_matrix, model
from .findings import Fit, Link


class NamedValues(Front):
    """The part of an adapter that sets and gets by name, before the first step and in faults."""

    def __init__(self, inner: Block, fit: Fit) -> None:
        super().__init__(inner, model(fit))
        self.fit = fit
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
        self._ours: Floats = np.zeros(0)

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        touched: dict[str, None] = {}
        for element, value in values:
            self._values[element] = value
            touched[element.variable] = None
            if element in self._place:
                self._ours[self._place[element]] = value
        theirs: list[tuple[Element, Any]] = []
        touched |= {n: None for n, link in self._links.items() if link.turned in touched and self._known(link)}
        for name in touched:
            if name in self._links:
                theirs += self._forward(self._links[name])
        if theirs:
            self.inner.set(theirs)

    def _known(self, link: Link) -> bool:
        return any(element in self._values for element in link.ours.elements)

    def _forward(self, link: Link) -> list[tuple[Element, Any]]:
        """Theirs of a port, from what ours was set to; elements never set are those of the interface's starts."""
        ours = [self._value(e) for e in link.ours.elements]
        if link.ours.type != "real":
            known = zip(link.theirs, link.ours.elements, ours, strict=True)
            return [(theirs, value) for theirs, element, value in known if element in self._values]
        if link.A is None or link.c is None:
            return list(zip(link.theirs, self._rotation(link, ours), strict=True))
        if link.turned:
            ours = self._turned(link, ours)
        rows = [
            row
            for row in range(len(link.theirs))
            if any(link.ours.elements[j] in self._values for j in np.flatnonzero(link.A[row]))
        ]
        values = link.A @ np.array(ours, float) + link.c
        return [(link.theirs[row], float(values[row])) for row in rows]

    def _value(self, element: Element) -> Any:
        """Returns what one of ours was last given."""
        at = self._place.get(element)
        if at is not None:
            return self._ours[at]
        return self._values.get(element, self.fit.reference.starts.get(element, 0))

    def _turned(self, link: Link, ours: Sequence[float]) -> list[float]:
        """A vector of ours along the axes of theirs."""
        R = [float(self._value(e)) for e in self.fit.reference.model.variables[link.turned].elements]
        R = rotation.transposed(R) if link.inverse else R
        return [sum(R[3 * i + j] * ours[j] for j in range(3)) for i in range(3)]

    def _rotation(self, link: Link, R: Sequence[float]) -> list[float]:
        """A quaternion, or three numbers, of a rotation matrix of ours."""
        if link.rotation:
            R = rotation.transposed(R) if link.inverse else R
            return [x / link.unit for x in rotation.three(R, link.rotation)]
        q = rotation.quaternion(rotation.transposed(R) if link.inverse else R, self._signs.get(link.ours.name))
        self._signs[link.ours.name] = q
        return [*q[1:], q[0]] if link.scalar_last else q

    def _matrix(self, link: Link, q: Sequence[float]) -> list[float]:
        try:
            R = in_ours_matrix(link, q)
        except ValueError as error:
            names = ", ".join(dict.fromkeys(e.variable for e in link.theirs))
            raise BlockError(
                self.name, f"output {names}", f"stands for our {link.ours.name}: {error}", log=self.log
            ) from None
        return R

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


def handed_on(fit: Fit, starts: Iterable[tuple[Element, Any]]) -> dict[Element, Any]:
    """Returns what theirs is given for start values of ours, by their elements; those of the mapping among them."""
    recorder: Any = _Recorder()
    recorder.set(fit.start.items())
    NamedValues(recorder, fit).set(starts)
    return dict(recorder.values)


class _Recorder:
    """Stands for a block, and keeps what it is set to."""

    name = ""

    def __init__(self) -> None:
        self.values: dict[Element, Any] = {}

    def set(self, values: Iterable[tuple[Element, Any]]) -> None:
        self.values.update(values)
