"""What takes a port of ours to theirs: matrix and offset with the units in them, or a quaternion."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np

from ..fmu.model import Element, Floats, Variable
from ..quantities import BASES, ONE, QuantityError, Unit, parse, parse_unit, value_in
from ..scenario.mapping import PortMap
from .findings import Fit, Link, Misfit, is_identity, once

_UNIT_TOLERANCE = 1e-4
"""Of the factor that an FMU declares for a unit of a usual name: rounded, but not another."""
_CONDITION_MAX = 1e12
"""Of a matrix whose inverse keeps some of the sixteen digits."""
_IN_A_FRAME = re.compile(r"_[A-Z]+\d*$")
"""What the name of a vector ends in that has its components in a frame: `omega_B`, `r_N`."""


def quaternion(fitted: Fit, ours: Variable, elements: tuple[Element, ...], entry: PortMap) -> Link:
    if ours.shape != (3, 3) or len(elements) != 4:
        text = f"a quaternion of 4 stands for a matrix of [3, 3]; ours is {ours.kind}, theirs has {len(elements)}"
        raise Misfit("shape", text, "map the quaternion to the rotation matrix")
    for variable in dict.fromkeys(fitted.theirs.variables[e.variable] for e in elements):
        if variable.unit is not None and variable.unit.exponents not in (None, ONE.exponents):
            raise Misfit(
                "unit", f"{variable.name} is in {variable.unit}, but a quaternion has no unit", "change the FMU"
            )
    return Link(ours, elements, scalar_last=entry.quaternion == "scalar last", inverse=entry.inverse)


def three(fitted: Fit, ours: Variable, elements: tuple[Element, ...], entry: PortMap) -> Link:
    """Three numbers for a rotation matrix of ours: Euler angles, a rotation vector or MRP."""
    form = entry.rotation or ""
    if ours.shape != (3, 3) or len(elements) != 3:
        text = f"{form} of 3 stands for a matrix of [3, 3]; ours is {ours.kind}, theirs has {len(elements)}"
        raise Misfit("shape", text, "map the three numbers to the rotation matrix")
    plain = form == "mrp"
    units = {str(u) for e in elements if (u := fitted.theirs.variables[e.variable].at([e.position]).unit) is not None}
    unit = parse_unit(entry.unit or (units.pop() if len(units) == 1 else "1" if plain else "rad"))
    if unit.exponents not in ((ONE.exponents,) if plain else (ONE.exponents, parse_unit("rad").exponents)):
        raise Misfit("unit", f"{form} in {unit}", "expected " + ("no unit" if plain else "an angle such as deg"))
    return Link(ours, elements, rotation=form, inverse=entry.inverse, unit=unit.factor)


def affine(fitted: Fit, ours: Variable, elements: tuple[Element, ...], entry: PortMap, label: str) -> Link:
    n, m = ours.size, len(elements)
    A = np.eye(n)
    if entry.matrix is not None:
        A = np.array(entry.matrix, float)
        if A.shape != (m, n):
            expected = f"{_by((m, n))}, a row for each of theirs and a column for each of ours"
            text = f"the matrix is {_by(A.shape)}, expected {expected}"
            raise Misfit("shape", text, "correct the matrix")
    elif m != n or (len(entry.theirs) == 1 and _shape(fitted, elements) != ours.shape and ours.size > 1):
        text = f"ours is {ours.kind}, theirs has {_shape_in_words(fitted, elements, m)}"
        raise Misfit("shape", text, f"name {n} of theirs, or give a matrix, in the mapping's ports")
    factors, offsets = np.ones(m), np.zeros(m)
    if ours.type == "real":
        for i, element in enumerate(elements):
            own, theirs = ours.at(np.flatnonzero(A[i]).tolist() or [0]), fitted.theirs.variables[element.variable]
            factors[i], offsets[i] = _conversion(fitted, own, theirs.at([element.position]), entry, label)
        offsets = offsets + _offset(fitted, elements, entry)
    invertible = m == n and np.linalg.cond(A) <= _CONDITION_MAX
    if entry.matrix is not None and m == n and ours.shape == (3,) and _IN_A_FRAME.search(ours.name):
        if not invertible:
            text = "the matrix is singular, so a component of the vector is lost"
            raise Misfit("mapping", text, "give the matrix of a rotation, or of full rank")
        if np.linalg.det(A) < 0.0:
            text = f"{label}: the matrix is left-handed: its determinant is {np.linalg.det(A):.3g}"
            once(fitted, "warning", "mapping", text, "correct the sign of a row, unless their axes are left-handed")
    A = factors[:, None] * A
    B: Floats | None = None
    if invertible:
        B = A.copy() if is_identity(A) else np.asarray(np.linalg.inv(A), np.float64)
    if entry.turn is not None:
        _turn(fitted, ours, entry.turn, label)
    return Link(ours, elements, A, offsets, B, turned=entry.turn or "", inverse=entry.inverse)


def _turn(fitted: Fit, ours: Variable, by: str, label: str) -> None:
    """Refuses a turn that cannot be: of what is no vector of inputs, or by what is no matrix beside it."""
    matrix = fitted.reference.model.variables.get(by)
    if matrix is None or matrix.causality != "input" or matrix.shape != (3, 3):
        raise Misfit("mapping", f"turn: expected an input of ours that is a rotation matrix, found {by}", "name one")
    if ours.causality != "input" or ours.shape != (3,):
        raise Misfit("mapping", f"{label}: only an input that is a vector of 3 is turned", "leave out turn")


def _shape(fitted: Fit, elements: tuple[Element, ...]) -> tuple[int, ...]:
    variable = fitted.theirs.variables[elements[0].variable]
    return variable.shape if len(elements) == variable.size else ()


def _shape_in_words(fitted: Fit, elements: tuple[Element, ...], count: int) -> str:
    shape = _shape(fitted, elements) if len({e.variable for e in elements}) == 1 else ()
    return f"the shape {list(shape)}" if shape else f"{count} value{'s' if count > 1 else ''}"


def _by(shape: tuple[int, ...]) -> str:
    return f"{shape[0]} by {shape[1]}"


def _conversion(fitted: Fit, ours: Variable, theirs: Variable, entry: PortMap, label: str) -> tuple[float, float]:
    """k and o of theirs = k ours + o for one element."""
    own = ours.unit or ONE
    unit = _unit(fitted, ours, theirs, entry, label)
    if own.exponents is None or unit.exponents is None:
        if own.name != unit.name:
            raise Misfit("unit", f"the unit {unit} is not defined", "state the unit in the mapping: 'unit: ...'")
        return 1.0, 0.0
    scale = entry.scale if entry.scale is not None else entry.divide
    if scale is None:
        if not own.fits(unit):
            wrong = f"where the FMU declares a wrong unit, state the right one in the mapping, such as 'unit: {own}'"
            remedy = f"give a 'scale' with a unit in the mapping, or change the FMU; {wrong}"
            if ours.causality != "parameter" and is_rate(own, unit):
                remedy = f"none in a mapping: {NO_MEMORY}; change the FMU; or, {wrong}"
            if own.exponents[:-1] == unit.exponents[:-1]:
                remedy = f"they differ by the radian only: state what it is, such as 'unit: {own}', in the mapping"
            raise Misfit("unit", f"the units do not fit: ours is {own}, theirs {unit}", remedy)
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
        raise Misfit("unit", text, "correct the unit of the factor")
    factor = number * by.factor
    if factor and power < 0:
        factor = 1.0 / factor
    if not factor or not math.isfinite(factor):
        raise Misfit("unit", f"the factor {scale} is beyond what a double holds", "correct the factor")
    return factor * own.factor / unit.factor, (factor * own.offset - unit.offset) / unit.factor


NO_MEMORY = "one is the rate of change of the other, and a mapping has no memory, so no mapping serves"


def is_rate(one: Unit, other: Unit) -> bool:
    """Returns whether one is the rate of change of the other, a mass or an inertia apart: a torque beside a speed."""
    if one.exponents is None or other.exponents is None or ONE.exponents in (one.exponents, other.exponents):
        return False
    kg, m, s, *more = (a - b for a, b in zip(one.exponents[:-1], other.exponents[:-1], strict=True))
    return not any(more) and (abs(s), (kg, m)) in {(1, (n, power * n)) for n in (-1, 0, 1) for power in (0, 2)}


def _unit(fitted: Fit, ours: Variable, theirs: Variable, entry: PortMap, label: str) -> Unit:
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
            once(fitted, "note", "unit", f"{label}: {stated}, as the mapping says; the FMU declares {declared}")
        return stated
    if declared is None:
        if (ours.unit or ONE).exponents != ONE.exponents:
            text = f"{label}: theirs has no unit, so it is taken to be in {ours.unit}"
            once(
                fitted, "warning", "unit", text, "state the unit in the mapping: 'unit: ...', or declare it in the FMU"
            )
        return ours.unit or ONE
    if declared.exponents is None:
        try:
            named = parse_unit(declared.name)
        except QuantityError:
            return declared
        text = f"{label}: the FMU names the unit {declared} without defining it; it is read as the usual one"
        once(fitted, "warning", "unit", text, "define it in the FMU's UnitDefinitions")
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
        stated = f"state what is meant, such as 'unit: {declared}', in the mapping"
        raise Misfit("unit", text, f"correct it in the FMU's UnitDefinitions, or {stated}")


def _defined(unit: Unit) -> str:
    powers = zip(BASES, unit.exponents or (), strict=True)
    base = ".".join(f"{name}{power if power != 1 else ''}" for name, power in powers if power) or "1"
    return f"{unit.factor:.10g} {base}" + (f" {unit.offset:+.10g}" if unit.offset else "")


def _offset(fitted: Fit, elements: tuple[Element, ...], entry: PortMap) -> Floats:
    if entry.offset is None:
        return np.zeros(len(elements))
    values = entry.offset if isinstance(entry.offset, list) else [entry.offset] * len(elements)
    if len(values) != len(elements):
        raise Misfit("shape", f"the offset has {len(values)} values, expected {len(elements)}", "correct the offset")
    own = [fitted.theirs.variables[e.variable].at([e.position]).unit or ONE for e in elements]
    units = [parse_unit(entry.unit) if entry.unit else unit for unit in own]
    try:
        return np.array([value_in(value, unit) for value, unit in zip(values, units, strict=True)])
    except QuantityError as error:
        raise Misfit("unit", f"offset: {error}", "correct the offset") from None


def change(ours: Variable, theirs: list[Variable], link: Link) -> str:
    """The change from ours to theirs, in a few words."""
    if link.rotation:
        return f": {link.rotation}{' in deg' if link.unit != 1.0 else ''}{', of the inverse rotation' * link.inverse}"
    if link.A is None or link.c is None:
        last = "last" if link.scalar_last else "first"
        return f": quaternion, scalar {last}{', of the inverse rotation' if link.inverse else ''}"
    unit = f" {ours.unit}" if ours.unit and ours.unit.name not in ("", "1") else ""
    if link.turned:
        how = f": turned by {link.turned}{' transposed' if link.inverse else ''}"
        return how + change(ours, theirs, replace(link, turned=""))
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
