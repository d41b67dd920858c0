"""How another team's FMU fits an interface: which of its ports stands for which of ours, and what does not fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from ..fmu.interfaces import Interface
from ..fmu.model import Element, Floats, Model, Variable
from ..quantities import ONE, Unit
from ..scenario.mapping import Mapping
from ..scenario.references import Name, Reference

Level = Literal["ok", "note", "warning", "error"]


@dataclass(frozen=True)
class Finding:
    """One thing that fits, is worth knowing, or does not fit, and what to do about it."""

    level: Level
    topic: str
    text: str
    remedy: str = ""
    key: tuple[str | int, ...] = ()
    """Where in the mapping it stands, if it does."""

    def __str__(self) -> str:
        return self.text + (f"; remedy: {self.remedy}" if self.remedy else "")

    @property
    def data(self) -> dict[str, str]:
        """Returns it as `--json` and acceptance.json have it."""
        return {"level": self.level, "topic": self.topic, "text": self.text, "remedy": self.remedy}


@dataclass(frozen=True)
class Link:
    """A port or parameter of ours and what stands for it: theirs = A ours + c, in the units of the ports.

    Of a quaternion A and c are None: theirs are its four components, ours the elements of the matrix.
    """

    ours: Variable
    theirs: tuple[Element, ...]
    A: Floats | None = None
    c: Floats | None = None
    B: Floats | None = None
    """The inverse of A, where there is one."""
    scalar_last: bool = False
    rotation: str = ""
    """Of three numbers that stand for our matrix, A and c are None as well: which, see `rotation.FORMS`."""
    unit: float = 1.0
    """Of such angles: their unit in rad."""
    turned: str = ""
    """Our rotation matrix by which ours is turned first, theirs = A R ours + c; by its inverse with `inverse`."""
    inverse: bool = False

    @property
    def plain(self) -> bool:
        """Returns whether nothing but the name may differ."""
        return (
            self.A is not None and self.c is not None and not self.turned and not self.c.any() and is_identity(self.A)
        )


@dataclass
class Fit:
    """Correspondence of ports, and everything that was fitted."""

    reference: Interface
    theirs: Model
    mapping: Mapping | None = None
    links: dict[str, Link] = field(default_factory=dict)
    """By our name."""
    extra: list[Variable] = field(default_factory=list)
    """Inputs, outputs and parameters that only theirs has, under their own names."""
    fed: dict[Name, Reference] = field(default_factory=dict)
    """Inputs among these, whole or element by element, with the signal of the scenario that the mapping connects."""
    start: dict[Element, Any] = field(default_factory=dict)
    """Values of some of these, from the mapping, as FMI stores them."""
    ignored: dict[str, Variable] = field(default_factory=dict)
    """Those of ours that the mapping says theirs does without."""
    without: dict[str, Variable] = field(default_factory=dict)
    """Optional inputs of ours that theirs lacks: nothing can be connected to them."""
    missing: dict[str, Variable] = field(default_factory=dict)
    """Outputs and parameters of ours that theirs lacks and that the mapping does not ignore."""
    candidates: set[str] = field(default_factory=set)
    """Inputs of theirs that an error names for one of ours that is missing."""
    findings: list[Finding] = field(default_factory=list)

    @property
    def feeding(self) -> dict[str, Reference]:
        """The signals of `fed` by the whole variable."""
        return {n if n in self.theirs.variables else n.variable: signal for n, signal in self.fed.items()}

    @property
    def errors(self) -> list[Finding]:
        return [finding for finding in self.findings if finding.level == "error"]

    @property
    def identical(self) -> bool:
        """Returns whether theirs can be wired as it is."""
        return not (self.ignored or self.start) and all(
            link.plain and link.ours == _twin(self.theirs.variables.get(name), link.ours)
            for name, link in self.links.items()
        )

    def say(self, level: Level, topic: str, text: str, remedy: str = "", key: tuple[str | int, ...] = ()) -> None:
        self.findings.append(Finding(level, topic, text, remedy, key))


def _twin(theirs: Variable | None, ours: Variable) -> Variable | None:
    """Ours, where theirs is of its name, shape and unit."""
    alike = theirs is not None and (theirs.type, theirs.shape) == (ours.type, ours.shape)
    return ours if alike and _same_unit(theirs, ours) else None  # type: ignore[arg-type]


def _same_unit(a: Variable, b: Variable) -> bool:
    def alike(one: Unit, other: Unit) -> bool:
        return one.exponents is not None and one.fits(other) and one.conversion(other) == (1.0, 0.0)

    return all(alike(a.at([p]).unit or ONE, b.at([p]).unit or ONE) for p in range(a.size))


def is_identity(A: Floats) -> bool:
    return A.shape[0] == A.shape[1] and bool((np.eye(len(A)) == A).all())


def unfed(finding: Finding) -> bool:
    """Returns whether it is about an input that only a scenario can feed: there the wiring decides."""
    return finding.topic == "extra" and finding.level == "error"


def once(fitted: Fit, level: Level, topic: str, text: str, remedy: str = "") -> None:
    if all(finding.text != text for finding in fitted.findings):
        fitted.say(level, topic, text, remedy)


class Misfit(ValueError):
    def __init__(self, topic: str, text: str, remedy: str) -> None:
        super().__init__(text)
        self.topic, self.remedy = topic, remedy


def named(model: Model, elements: Sequence[Element]) -> str:
    """The names of whole variables, or else of the elements."""
    names = dict.fromkeys(element.variable for element in elements)
    if list(elements) == [element for name in names for element in model.variables[name].elements]:
        return " ".join(names)
    return " ".join(model.variables[element.variable].label(element.position) for element in elements)


def may_stay_unconnected(fitted: Fit, link: Link) -> bool:
    """Returns whether theirs may do without what feeds an input of ours."""
    return all(fitted.theirs.variables[element.variable].optional for element in link.theirs)
