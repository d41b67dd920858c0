"""How another team's FMU fits an interface: which of its ports stands for which of ours, and what does not fit.

`fit` finds everything that can be said without running anything. `orchestrate check` prints it, and a
swap refuses to run where it holds a fault, so the two never disagree.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from ..errors import hint, nearest
from ..fmu.interfaces import Reference
from ..fmu.model import Element, Floats, Model, NameUnknown, Variable
from ..quantities import BASES, ONE, QuantityError, Unit, parse, parse_unit, value_in
from ..scenario.mapping import Mapping as PortMapping
from ..scenario.mapping import PortMap
from ..system.starts import values_of

Level = Literal["ok", "note", "warning", "fault"]


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
    inverse: bool = False

    @property
    def plain(self) -> bool:
        """Whether nothing but the name may differ."""
        return self.A is not None and self.c is not None and not self.c.any() and _is_identity(self.A)


@dataclass
class Fit:
    """What stands for what, and everything that was found."""

    reference: Reference
    theirs: Model
    mapping: PortMapping | None = None
    links: dict[str, Link] = field(default_factory=dict)
    """By our name."""
    extra: list[Variable] = field(default_factory=list)
    """Inputs, outputs and parameters that only theirs has, under their own names."""
    start: dict[Element, Any] = field(default_factory=dict)
    """Values of some of these, from the mapping, as FMI stores them."""
    ignored: dict[str, Variable] = field(default_factory=dict)
    """Those of ours that the mapping says theirs does without."""
    without: dict[str, Variable] = field(default_factory=dict)
    """Optional inputs of ours that theirs lacks: nothing can be connected to them."""
    missing: dict[str, Variable] = field(default_factory=dict)
    """Outputs and parameters of ours that theirs lacks and that nothing has been said about."""
    findings: list[Finding] = field(default_factory=list)

    @property
    def faults(self) -> list[Finding]:
        return [finding for finding in self.findings if finding.level == "fault"]

    @property
    def identical(self) -> bool:
        """Whether theirs can be wired as it is."""
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


def _is_identity(A: Floats) -> bool:
    return A.shape[0] == A.shape[1] and bool((np.eye(len(A)) == A).all())


# ---------------------------------------------------------------- ports


def fit(reference: Reference, theirs: Model, mapping: PortMapping | None = None) -> Fit:
    """Finds what of theirs stands for what of ours, and says of everything whether it fits."""
    found = Fit(reference, theirs, mapping)
    mapping = mapping or PortMapping()
    _ignored(found, mapping)
    taken: dict[Element, str] = {}
    for name, entry in mapping.ports.items():
        _mapped(found, name, entry, taken)
    for name, ours in reference.model.variables.items():
        if name in mapping.ports or name in found.ignored or ours.causality not in ("input", "output", "parameter"):
            continue
        same = theirs.variables.get(name)
        if same is None or any(element in taken for element in same.elements):
            _lacking(found, ours, theirs, taken)
        else:
            _link(found, ours, tuple(same.elements), PortMap(theirs=[name], inverse=False), (), taken)
    _extra(found, mapping, taken)
    return found


def _ignored(found: Fit, mapping: PortMapping) -> None:
    known = found.reference.model.variables
    for number, name in enumerate(mapping.ignore):
        key = ("ignore", number)
        if name not in known:
            found.say(
                "fault",
                "mapping",
                f"the interface {found.reference.name} has no {name!r}{hint(name, known)}",
                key=key,
            )
        elif name in mapping.ports:
            found.say("fault", "mapping", f"{name} is both mapped and ignored", "leave it out of one of the two", key)
        else:
            ours = known[name]
            found.ignored[name] = ours
            what = {
                "input": "what flows there reaches no one",
                "output": "it is not there for others, records and expectations",
            }.get(ours.causality, "its value in a scenario is not handed on")
            found.say("note", "ignored", f"{ours.causality} {name} is ignored, as the mapping says: {what}")


def _mapped(found: Fit, name: str, entry: PortMap, taken: dict[Element, str]) -> None:
    key = ("ports", name)
    known = found.reference.model.variables
    if name not in known:
        text = f"the interface {found.reference.name} has no {name!r}{hint(name, known)}"
        found.say("fault", "mapping", text, "the names of the interface stand on the left", key)
        return
    elements: list[Element] = []
    for theirs in entry.theirs:
        try:
            elements += _elements(found.theirs, theirs)
        except NameUnknown as error:
            found.say("fault", "mapping", str(error), key=(*key, "theirs"))
            return
    _link(found, known[name], tuple(elements), entry, key, taken)
    for element in elements:  # told once, if it does not fit
        taken.setdefault(element, name)


def _elements(model: Model, name: str) -> list[Element]:
    from ..scenario.references import split

    block, variable_name, index = split(f"theirs.{name}") or ("theirs", name, ())
    if name in model.variables:
        variable_name, index = name, ()
    try:
        variable, positions = model.find(block, variable_name, index)
    except NameUnknown as error:
        raise NameUnknown(str(error).replace("theirs.", "").replace("theirs has", "their FMU has")) from None
    return [Element(variable.name, position) for position in positions]


def _link(
    found: Fit,
    ours: Variable,
    elements: tuple[Element, ...],
    entry: PortMap,
    key: tuple[str, ...],
    taken: dict[Element, str],
) -> None:
    theirs = [found.theirs.variables[element.variable] for element in elements]
    names = _named(found.theirs, elements)
    label = f"{ours.causality} {ours.name}" + (f" = {names}" if names != ours.name else "")
    for variable in theirs:
        if variable.causality != ours.causality:
            text = f"{label}: {variable.name} is of causality {variable.causality}, expected {ours.causality}"
            return found.say("fault", "causality", text, "map it to another variable, or change the FMU", key)
        if variable.type != ours.type:
            text = f"{label}: {variable.name} is {variable.type}, expected {ours.type}"
            return found.say("fault", "type", text, "change the type in the FMU", key)
        if variable.items != ours.items:
            text = f"{label}: the items differ, {_items(variable)}, expected {_items(ours)}"
            return found.say("fault", "type", text, "give the enumeration of the FMU these items", key)
    if ours.causality != "output" and (twice := next((e for e in elements if e in taken), None)):
        label_twice = found.theirs.variables[twice.variable].label(twice.position)
        return found.say("fault", "mapping", f"{label}: {label_twice} already stands for {taken[twice]}", key=key)
    if repeated := next((e for i, e in enumerate(elements) if e in elements[:i]), None):
        text = f"{label}: {_named(found.theirs, (repeated,))} is named more than once"
        return found.say("fault", "mapping", text, "name each of theirs once", key)
    if ours.type != "real" and any(
        getattr(entry, name) is not None for name in ("unit", "scale", "divide", "matrix", "offset", "quaternion")
    ):
        return found.say("fault", "mapping", f"{label}: only real variables are converted; it is {ours.type}", key=key)
    try:
        link = (
            _quaternion(found, ours, elements, entry)
            if entry.quaternion
            else _affine(found, ours, elements, entry, label)
        )
    except _Misfit as error:
        return found.say("fault", error.topic, f"{label}: {error}", error.remedy, key)
    if ours.causality == "output" and link.A is not None and link.B is None:
        text = f"{label}: ours cannot be found from theirs, since the matrix has no inverse that keeps its digits"
        return found.say("fault", "mapping", text, "give a square matrix of full rank", key)
    found.links[ours.name] = link
    taken.update(dict.fromkeys(elements, ours.name))
    found.say("ok", "port", f"{label}, {ours.kind}{_told(ours, theirs, link)}")
    if ours.optional and not _optional(found, link):
        text = f"{label}: optional in ours, but theirs does not say that it may stay unconnected"
        found.say("note", "optional", text, "connect it in the scenario, or give it a value under start there")
    return None


def _named(model: Model, elements: Sequence[Element]) -> str:
    """The names of whole variables, or else of the elements."""
    names = dict.fromkeys(element.variable for element in elements)
    if list(elements) == [element for name in names for element in model.variables[name].elements]:
        return " ".join(names)
    return " ".join(model.variables[element.variable].label(element.position) for element in elements)


class _Misfit(ValueError):
    def __init__(self, topic: str, text: str, remedy: str) -> None:
        super().__init__(text)
        self.topic, self.remedy = topic, remedy


def _quaternion(found: Fit, ours: Variable, elements: tuple[Element, ...], entry: PortMap) -> Link:
    if ours.shape != (3, 3) or len(elements) != 4:
        text = f"a quaternion of 4 stands for a matrix of [3, 3]; ours is {ours.kind}, theirs has {len(elements)}"
        raise _Misfit("shape", text, "map the quaternion to the rotation matrix")
    for variable in dict.fromkeys(found.theirs.variables[e.variable] for e in elements):
        if variable.unit is not None and variable.unit.exponents not in (None, ONE.exponents):
            raise _Misfit(
                "unit", f"{variable.name} is in {variable.unit}, but a quaternion has no unit", "change the FMU"
            )
    return Link(ours, elements, scalar_last=entry.quaternion == "scalar last", inverse=entry.inverse)


_UNIT_TOLERANCE = 1e-4
"""Of the factor that an FMU declares for a unit of a usual name: rounded, but not another."""
_CONDITION_MAX = 1e12
"""Of a matrix whose inverse keeps some of the sixteen digits."""


def _affine(found: Fit, ours: Variable, elements: tuple[Element, ...], entry: PortMap, label: str) -> Link:
    n, m = ours.size, len(elements)
    A = np.eye(n)
    if entry.matrix is not None:
        A = np.array(entry.matrix, float)
        if A.shape != (m, n):
            text = f"the matrix is {_by(A.shape)}, expected {_by((m, n))}, a row for each of theirs and a column for each of ours"
            raise _Misfit("shape", text, "correct the matrix")
    elif m != n or (len(entry.theirs) == 1 and _shape(found, elements) != ours.shape and ours.size > 1):
        text = f"ours is {ours.kind}, theirs has {_shape_said(found, elements, m)}"
        raise _Misfit("shape", text, f"name {n} of theirs, or give a matrix, in the mapping's ports")
    factors, offsets = np.ones(m), np.zeros(m)
    if ours.type == "real":
        for i, element in enumerate(elements):
            own, theirs = ours.at(np.flatnonzero(A[i]).tolist() or [0]), found.theirs.variables[element.variable]
            factors[i], offsets[i] = _conversion(found, own, theirs.at([element.position]), entry, label)
        offsets = offsets + _offset(found, elements, entry)
    invertible = m == n and np.linalg.cond(A) <= _CONDITION_MAX
    A = factors[:, None] * A
    B: Floats | None = None
    if invertible:
        B = A.copy() if _is_identity(A) else np.asarray(np.linalg.inv(A), np.float64)
    return Link(ours, elements, A, offsets, B)


def _shape(found: Fit, elements: tuple[Element, ...]) -> tuple[int, ...]:
    variable = found.theirs.variables[elements[0].variable]
    return variable.shape if len(elements) == variable.size else ()


def _shape_said(found: Fit, elements: tuple[Element, ...], count: int) -> str:
    shape = _shape(found, elements) if len({e.variable for e in elements}) == 1 else ()
    return f"the shape {list(shape)}" if shape else f"{count} value{'s' if count > 1 else ''}"


def _by(shape: tuple[int, ...]) -> str:
    return f"{shape[0]} by {shape[1]}"


def _conversion(found: Fit, ours: Variable, theirs: Variable, entry: PortMap, label: str) -> tuple[float, float]:
    """k and o of theirs = k ours + o for one element."""
    own = ours.unit or ONE
    unit = _unit(found, ours, theirs, entry, label)
    if own.exponents is None or unit.exponents is None:
        if own.name != unit.name:
            raise _Misfit("unit", f"the unit {unit} is not defined", "state the unit in the mapping: 'unit: ...'")
        return 1.0, 0.0
    scale = entry.scale if entry.scale is not None else entry.divide
    if scale is None:
        if not own.fits(unit):
            remedy = "give a 'scale' with a unit in the mapping, or change the FMU"
            if own.exponents[:-1] == unit.exponents[:-1]:
                remedy = f"they differ by the radian only: state what it is, such as 'unit: {own}', in the mapping"
            raise _Misfit("unit", f"the units do not fit: ours is {own}, theirs {unit}", remedy)
        return own.conversion(unit)
    number, by = parse(scale) if isinstance(scale, str) else (float(scale), None)
    power = 1 if entry.scale is not None else -1
    by = by or ONE
    got = [a + power * b for a, b in zip(own.exponents, by.exponents or (), strict=True)]
    bare = tuple(got[:-1]) == unit.exponents[:-1]  # the radian is no unit where quantities change
    if not (bare if by.exponents != ONE.exponents else tuple(got) == unit.exponents):
        text = (
            f"ours, {own}, {'times' if power > 0 else 'over'} {scale} does not come out in {unit}, the unit of theirs"
        )
        raise _Misfit("unit", text, "correct the unit of the factor")
    factor = number * by.factor
    if factor and power < 0:
        factor = 1.0 / factor
    if not factor or not math.isfinite(factor):
        raise _Misfit("unit", f"the factor {scale} is beyond what a double holds", "correct the factor")
    return factor * own.factor / unit.factor, (factor * own.offset - unit.offset) / unit.factor


def _unit(found: Fit, ours: Variable, theirs: Variable, entry: PortMap, label: str) -> Unit:
    """The unit of theirs: stated in the mapping, declared in the FMU, or taken to be ours, with a word on it."""
    declared = theirs.unit
    if entry.unit is not None:
        stated = parse_unit(entry.unit)
        differs = (
            declared is not None
            and declared.exponents is not None
            and (not declared.fits(stated) or not math.isclose(declared.factor, stated.factor, rel_tol=1e-6))
        )
        if differs:
            _once(found, "note", "unit", f"{label}: {stated}, as the mapping says; the FMU declares {declared}")
        return stated
    if declared is None:
        if (ours.unit or ONE).exponents != ONE.exponents:
            text = f"{label}: theirs has no unit, so it is taken to be in {ours.unit}"
            _once(
                found, "warning", "unit", text, "state the unit in the mapping: 'unit: ...', or declare it in the FMU"
            )
        return ours.unit or ONE
    if declared.exponents is None:
        try:
            named = parse_unit(declared.name)
        except QuantityError:
            return declared
        text = f"{label}: the FMU names the unit {declared} without defining it; it is read as the usual one"
        _once(found, "warning", "unit", text, "define it in the FMU's UnitDefinitions")
        return named
    _refuse_unusual(declared)
    return declared


def _refuse_unusual(declared: Unit) -> None:
    """Refuses a unit of a usual name that is declared to be another one; the radian may be left out."""
    try:
        usual = parse_unit(declared.name)
    except QuantityError:
        return
    if usual.exponents is None or declared.exponents is None:
        return
    alike = (
        declared.exponents[:-1] == usual.exponents[:-1]
        and math.isclose(declared.factor, usual.factor, rel_tol=_UNIT_TOLERANCE)
        and math.isclose(declared.offset, usual.offset, rel_tol=_UNIT_TOLERANCE, abs_tol=1e-12)
    )
    if not alike:
        text = f"the FMU declares the unit {declared} to be {_defined(declared)}, but usually it is {_defined(usual)}"
        remedy = f"correct it in the FMU's UnitDefinitions, or state what is meant, such as 'unit: {declared}', in the mapping"
        raise _Misfit("unit", text, remedy)


def _defined(unit: Unit) -> str:
    powers = zip(BASES, unit.exponents or (), strict=True)
    base = ".".join(f"{name}{power if power != 1 else ''}" for name, power in powers if power) or "1"
    return f"{unit.factor:.10g} {base}" + (f" {unit.offset:+.10g}" if unit.offset else "")


def _once(found: Fit, level: Level, topic: str, text: str, remedy: str = "") -> None:
    if all(finding.text != text for finding in found.findings):
        found.say(level, topic, text, remedy)


def _offset(found: Fit, elements: tuple[Element, ...], entry: PortMap) -> Floats:
    if entry.offset is None:
        return np.zeros(len(elements))
    values = entry.offset if isinstance(entry.offset, list) else [entry.offset] * len(elements)
    if len(values) != len(elements):
        raise _Misfit("shape", f"the offset has {len(values)} values, expected {len(elements)}", "correct the offset")
    own = [found.theirs.variables[e.variable].at([e.position]).unit or ONE for e in elements]
    units = [parse_unit(entry.unit) if entry.unit else unit for unit in own]
    try:
        return np.array([value_in(value, unit) for value, unit in zip(values, units, strict=True)])
    except QuantityError as error:
        raise _Misfit("unit", f"offset: {error}", "correct the offset") from None


def _told(ours: Variable, theirs: list[Variable], link: Link) -> str:
    """The change from ours to theirs, in a few words."""
    if link.A is None or link.c is None:
        last = "last" if link.scalar_last else "first"
        return f": quaternion, scalar {last}{', of the inverse rotation' if link.inverse else ''}"
    unit = f" {ours.unit}" if ours.unit and ours.unit.name not in ("", "1") else ""
    if link.plain:
        return f",{unit}" if unit else ""
    their_unit = f" {theirs[0].unit}" if theirs[0].unit and theirs[0].unit.name not in ("", "1") else ""
    diagonal = link.A.shape[0] == link.A.shape[1] and np.count_nonzero(link.A - np.diag(np.diag(link.A))) == 0
    if diagonal and np.ptp(np.diag(link.A)) == 0.0 and np.ptp(link.c) == 0.0:
        shift = f" {link.c[0]:+.6g}" if link.c[0] else ""
        return f",{unit} to{their_unit or ' theirs'}: times {link.A[0, 0]:.10g}{shift}"
    largest = float(np.abs(link.A).max())
    rows = "; ".join(" ".join(f"{x / largest + 0.0:.6g}" for x in row) for row in link.A)
    times = f" times {largest:.10g}" if largest != 1.0 else ""
    shift = " plus [" + " ".join(f"{x:.6g}" for x in link.c) + "]" if link.c.any() else ""
    return f",{unit} to{their_unit or ' theirs'}: [{rows}]{times}{shift}"


def _items(variable: Variable) -> str:
    return ", ".join(f"{name} ({value})" for name, value in variable.items) or "none"


# ---------------------------------------------------------------- what one side only has


def _lacking(found: Fit, ours: Variable, theirs: Model, taken: Mapping[Element, str]) -> None:
    free = [v for v in theirs.of(ours.causality) if v.name not in found.reference.model.variables]
    free = [v for v in free if not any(element in taken for element in v.elements)]
    match = nearest(ours.name, (v.name for v in free))
    meant = [match] if match else []
    alike = [v.name for v in free if v.type == ours.type and v.size == ours.size and _unit_fits(ours, v)]
    meant += [name for name in alike if name not in meant]
    key = f"'{ours.name}: {meant[0] if meant else 'THEIRS'}' under ports in the mapping"
    kind = f"{ours.kind}" + (f" in {ours.unit}" if str(ours.unit or ONE) != "1" else "")
    text = f"{ours.causality} {ours.name}, {kind}, is missing"
    if meant:
        text += f"; by name or unit it may be {' or '.join(meant[:3])}"
    if ours.optional:
        found.without[ours.name] = ours
        text = f"{text}, which is optional: theirs runs without it, and a scenario's connection to it is dropped"
        found.say("note", "optional", text, f"none needed, or {key}")
    elif ours.causality == "input":
        found.say("fault", "missing", text, f"{key}; or list it under ignore, if theirs does without")
    if ours.causality == "input":
        return
    found.missing[ours.name] = ours
    if ours.causality == "output" and ours.name in found.reference.needed:
        found.say("fault", "missing", f"{text}; other blocks need it", key)
    elif ours.causality == "output":
        found.say("note", "missing", f"{text}; no other block needs an input of its name", f"none needed, or {key}")
    else:
        text += "; a scenario that gives it a value is refused"
        found.say("note", "missing", text, f"none needed, or {key}, or list it under ignore")


def _unit_fits(ours: Variable, theirs: Variable) -> bool:
    if ours.type != "real" or str(ours.unit or ONE) == "1" or theirs.unit is None:
        return False
    return (ours.unit or ONE).fits(theirs.unit)


def _extra(found: Fit, mapping: PortMapping, taken: Mapping[Element, str]) -> None:
    ours = found.reference.model.variables
    known = found.theirs.variables
    for name, value in mapping.start.items():
        base = name.partition("[")[0]
        variable = known.get(name) or known.get(base)
        key = ("start", name)
        if variable is None or variable.causality not in ("input", "parameter"):
            names = (v.name for v in found.theirs.of("input", "parameter"))
            found.say("fault", "mapping", f"their FMU has no input or parameter {name!r}{hint(base, names)}", key=key)
        else:
            _started(found, variable, name, value, taken)
    partial: dict[str, list[str]] = {}
    for variable in found.theirs.of("input", "output", "parameter"):
        left = [e for e in variable.elements if e not in taken and e not in found.start]
        if not left:
            continue
        if len(left) < variable.size and variable.name not in found.ignored:
            label = _named(found.theirs, left)
            if variable.causality == "input":
                text = f"input{_s(left)} {label} {'are' if len(left) > 1 else 'is'} of theirs only, and nothing feeds "
                text += "them" if len(left) > 1 else "it"
                remedy = f"give a value under start in the mapping, such as '{label.split()[0]}: 0', or map the whole"
                found.say("fault", "elements", text, remedy)
            else:
                partial.setdefault(variable.causality, []).append(label)
            continue
        if variable.name in ours:
            if variable.name in found.links or variable.name in found.ignored:
                text = f"their {variable.causality} {variable.name} has the name of ours, but is not mapped to it"
                found.say("note", "extra", text, "none needed, if that is meant")
            continue
        found.extra.append(variable)
        if variable.optional:
            text = f"input {variable.name}, {variable.kind}, is of theirs only, and optional"
            found.say("note", "extra", text, "none needed, or connect it in the scenario")
        elif variable.causality == "input":
            text = f"input {variable.name}, {variable.kind}, is of theirs only, and nothing feeds it"
            remedy = "give it a value under start in the mapping, or connect it in the scenario"
            found.say("fault", "extra", text, remedy)
    outputs = [f"{v.name}, {v.kind}" for v in found.extra if v.causality == "output"]
    if outputs:
        text = f"output{_s(outputs)} of theirs only: {'; '.join(outputs)}"
        found.say("note", "extra", text, "none needed; they are recorded under these names")
    if "output" in partial:
        text = f"elements of outputs that stand for nothing of ours: {', '.join(partial['output'])}"
        found.say("note", "extra", text, "none needed; they are not recorded")
    parameters = [v.name for v in found.extra if v.causality == "parameter"] + partial.get("parameter", [])
    if parameters:
        text = f"parameter{_s(parameters)} of theirs only, at the values of their FMU: {', '.join(parameters)}"
        found.say("note", "extra", text, "other values, if they are wanted, under start in the mapping")


def _started(found: Fit, variable: Variable, name: str, value: Any, taken: Mapping[Element, str]) -> None:
    """Takes a start value of the mapping, unless it is for what ours give a value."""
    key = ("start", name)
    try:
        values = values_of("theirs", found.theirs, name, value)
    except (QuantityError, NameUnknown) as error:
        return found.say("fault", "mapping", str(error), key=key)
    standing = [element for element in values if element in taken]
    if standing:
        port = taken[standing[0]]
        label = name if len(standing) == len(values) else _named(found.theirs, standing)
        text = f"{label} stands for our {port}, whose value it takes"
        return found.say("fault", "mapping", text, f"give the value to {port} in the scenario", key)
    found.start.update(values)
    return found.say("ok", "extra", f"{variable.causality} {name} of theirs is {value}, as the mapping says")


def _s(items: Sequence[Any]) -> str:
    return "s" if len(items) > 1 else ""


def unfed(finding: Finding) -> bool:
    """Whether it is about an input that only a scenario can feed: there the wiring decides."""
    return finding.topic == "extra" and finding.level == "fault"


# ---------------------------------------------------------------- feedthrough


def model(found: Fit) -> Model:
    """Theirs as a block of our interface: our names, units and shapes, and under their own names what only they have."""
    variables = {name: replace(link.ours, optional=_optional(found, link)) for name, link in found.links.items()}
    variables |= {name: ours for name, ours in found.ignored.items() if ours.causality != "output"}
    variables |= {variable.name: variable for variable in found.extra}
    back: dict[Element, list[Element]] = {}
    for link in found.links.values():
        if link.ours.causality == "input":
            for row, element in enumerate(link.theirs):
                columns = range(link.ours.size) if link.A is None else np.flatnonzero(link.A[row]).tolist()
                back.setdefault(element, []).extend(Element(link.ours.name, column) for column in columns)
    for variable in found.extra:
        back.update((element, [element]) for element in variable.elements)

    def ours_of(declared: Mapping[Element, frozenset[Element] | None]) -> dict[Element, frozenset[Element] | None]:
        deps: dict[Element, frozenset[Element] | None] = {}
        for link in found.links.values():
            if link.ours.causality == "output":
                for row in range(link.ours.size):
                    columns = range(len(link.theirs)) if link.B is None else np.flatnonzero(link.B[row]).tolist()
                    deps[Element(link.ours.name, row)] = _union((declared.get(link.theirs[j]) for j in columns), back)
        for variable in found.extra:
            if variable.causality == "output":
                deps.update((element, _union([declared.get(element)], back)) for element in variable.elements)
        return deps

    theirs = found.theirs
    return Model(theirs.name, variables, ours_of(theirs.feedthrough), ours_of(theirs.initial), theirs.guid, theirs.tool)


def _optional(found: Fit, link: Link) -> bool:
    """Whether theirs may do without what feeds an input of ours."""
    return all(found.theirs.variables[element.variable].optional for element in link.theirs)


def _union(
    parts: Iterable[frozenset[Element] | None], back: Mapping[Element, list[Element]]
) -> frozenset[Element] | None:
    """The inputs of ours behind these of theirs; None as soon as one is not declared."""
    found: set[Element] = set()
    for part in parts:
        if part is None:
            return None
        for element in part:
            found.update(back.get(element, ()))
    return frozenset(found)
