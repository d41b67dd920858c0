"""Lists the wrong wirings of a port: what a receiver makes of a signal that it reads in another way than it is meant.

| port | wrong wirings |
|---|---|
| vector of 3 | the 47 signed permutations of its axes but for the right one; usual factors |
| rotation matrix | transposed; 47 signed permutations on its left and 46 on its right (minus the matrix is both) |
| | its quaternion with the scalar in the other place, each also of the inverse rotation |
| quaternion | scalar in the other place, each also conjugated and with the opposite sign |
| scalar | the opposite sign; usual factors |
| flag | inverted |
| other number of elements | each element and all with the opposite sign; usual factors |
| | neighbours exchanged, the order reversed |

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import permutations, product

import numpy as np

from ... import rotation
from ...fmu.model import Floats, Variable
from ...quantities import ONE, Unit, parse_unit
from .ports import Port

AXES = "xyz"
USUAL: tuple[tuple[str, ...], ...] = (
    ("rad", "deg"),
    ("rad/s", "deg/s", "rpm"),
    ("T", "nT", "uT", "G"),
    ("N.m", "mN.m"),
    ("N.m.s", "mN.m.s"),
    ("A.m2", "mA.m2"),
    ("m", "km"),
    ("m/s", "km/s"),
    ("kg.m2", "g.cm2"),
    ("A", "mA"),
    ("V", "mV"),
    ("s", "ms"),
)
"""Units of one quantity that are taken for each other."""
RARE: tuple[tuple[str, ...], ...] = (("N.m", "uN.m"),)
"""And those that are looked for besides where another team's FMU is explained."""


@dataclass(frozen=True)
class Wrong:
    """One wrong wiring: the receiver takes `matrix` times the elements, plus `offset`, or `turned` of them."""

    name: str
    kind: str
    """axes, unit, attitude, sign or flag."""
    matrix: Floats | None = None
    offset: float = 0.0
    turn: tuple[str, bool] | None = None
    """Of a rotation matrix: its quaternion is read with the scalar in the other place, "first as last" or
    "last as first", and whether as that of the inverse rotation."""
    along: tuple[str, bool] | None = None
    """Of a vector: the matrix of another port by which it is turned as it is read, and whether by its transpose."""

    def apply(self, values: Floats) -> Floats:
        """Returns values (n, elements) as they are read."""
        if self.matrix is not None:
            return np.asarray(values @ self.matrix.T + self.offset)
        return np.array([turned(row.tolist(), *(self.turn or ("", False))) for row in values])


def undo(wrong: Wrong, values: Floats) -> Floats:
    """Returns what has to be handed over (n, elements) so that these values are read."""
    if wrong.matrix is not None:
        return np.asarray((values - wrong.offset) @ np.linalg.inv(wrong.matrix).T)
    order, inverse = wrong.turn or ("", False)
    back = "last as first" if order.endswith("first as last") else "first as last"
    back = f"inverse, {back}" if inverse else back
    return np.array([turned(row.tolist(), back, order.startswith("inverse")) for row in values])


def frames_of(variable: Variable) -> list[str]:
    """Returns the frames of a vector, one, or of a rotation matrix, "N from B" being N and B."""
    return [part.strip() for part in (variable.frame or "").split(" from ") if part.strip()]


def left_handed(wrong: Wrong) -> bool:
    """Returns whether it mirrors a vector of three, but for one of the opposite sign."""
    M = wrong.matrix
    return (
        M is not None and M.shape == (3, 3) and float(np.linalg.det(M)) < 0.0 and not (M[0, 0] * np.eye(3) == M).all()
    )


def turned(R: list[float], order: str, inverse: bool) -> list[float]:
    """Returns the rotation matrix that is read of the quaternion of R with its scalar taken to be in the other place.

    An `order` that begins with "inverse" takes the quaternion of the inverse rotation; `inverse` inverts what is read.
    """
    q = rotation.quaternion(rotation.transposed(R) if order.startswith("inverse") else R)
    q = [q[3], q[0], q[1], q[2]] if order.endswith("first as last") else [q[1], q[2], q[3], q[0]]
    norm = sum(x * x for x in q) ** 0.5
    read = rotation.matrix([x / norm for x in q])
    return rotation.transposed(read) if inverse else read


@cache
def signed_permutations() -> tuple[tuple[str, Floats], ...]:
    """Returns all of three axes, named, the right one first: "-y +x +z" takes minus y for x, x for y, z for z."""
    made = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            matrix = np.zeros((3, 3))
            matrix[range(3), order] = signs
            made.append(
                (" ".join(f"{'+' if s > 0 else '-'}{AXES[j]}" for s, j in zip(signs, order, strict=True)), matrix)
            )
    return tuple(made)


def wrongs(port: Port, rare: bool = False) -> list[Wrong]:
    """Returns the wrong wirings of a port; with `rare` those by units that are seldom taken for its own, too."""
    n = len(port.positions)
    if port.kind == "other":
        return []
    if port.kind == "flag":
        return [Wrong("inverted", "flag", -np.eye(n), 1.0)] if n == 1 else []
    if port.kind == "rotation":
        return _attitude()
    if port.kind == "quaternion":
        return _quaternion()
    made = []
    if n == 1:
        made.append(Wrong("opposite sign", "sign", -np.eye(1)))
    elif n == 3:
        made += [Wrong(name, "axes", matrix) for name, matrix in signed_permutations()[1:]]
    else:
        made += _elements(n)
    return made + factors(port.unit, n, rare)


def factors(unit: Unit, n: int, rare: bool = False) -> list[Wrong]:
    """Returns the wrong wirings by usual units that are taken for this one, both ways."""
    made: dict[float, Wrong] = {}
    for name, factor in usual_factors(unit, rare):
        if not any(abs(factor / known - 1.0) < 1e-6 for known in (1.0, *made)):
            made[factor] = Wrong(name, "unit", factor * np.eye(n))
    return list(made.values())


def usual_factors(unit: Unit, rare: bool = False) -> list[tuple[str, float]]:
    """Returns by what a number of this unit is multiplied where it is taken for a usual other one, and words for it."""
    if unit.exponents in (None, ONE.exponents):
        return []
    found = []
    for family in (*USUAL, *RARE) if rare else USUAL:
        units = [parse_unit(name) for name in family]
        if units[0].exponents != unit.exponents:
            continue
        for other in units:
            ratio = other.factor / unit.factor
            if abs(ratio - 1.0) > 1e-9:
                found += [(f"given in {other}", 1.0 / ratio), (f"read in {other}", ratio)]
    return found


def _attitude() -> list[Wrong]:
    eye, made = np.eye(3), []
    transpose = np.zeros((9, 9))
    for i, j in product(range(3), repeat=2):
        transpose[3 * i + j, 3 * j + i] = 1.0
    made.append(Wrong("transposed", "attitude", transpose))
    for name, matrix in signed_permutations()[1:]:
        made.append(Wrong(f"rows {name}", "axes", np.asarray(np.kron(matrix, eye), np.float64)))
    for name, matrix in signed_permutations()[1:]:
        if not np.array_equal(matrix, -eye):
            made.append(Wrong(f"columns {name}", "axes", np.asarray(np.kron(eye, matrix), np.float64)))
    for order in ("first as last", "last as first"):
        for inverse in (False, True):
            ending = ", inverse" if inverse else ""
            made.append(Wrong(f"quaternion, scalar {order}{ending}", "attitude", turn=(order, inverse)))
    return made


def _quaternion() -> list[Wrong]:
    orders = {
        "": np.eye(4),
        "scalar first as last": np.eye(4)[[3, 0, 1, 2]],
        "scalar last as first": np.eye(4)[[1, 2, 3, 0]],
    }
    made = []
    for name, order in orders.items():
        for sign, conjugate in product((1.0, -1.0), (False, True)):
            change = sign * np.diag([1.0, -1.0, -1.0, -1.0] if conjugate else [1.0] * 4)
            words = [name, "conjugate" * conjugate, "opposite sign" * (sign < 0.0)]
            if any(words):
                made.append(Wrong(", ".join(filter(None, words)), "attitude", change @ order))
    return made


def _elements(n: int) -> list[Wrong]:
    made = [Wrong("opposite sign", "sign", -np.eye(n)), Wrong("order reversed", "axes", np.eye(n)[::-1])]
    for i in range(n):
        signs = np.ones(n)
        signs[i] = -1.0
        made.append(Wrong(f"opposite sign of [{i + 1}]", "sign", np.diag(signs)))
    for i in range(n - 1):
        order = list(range(n))
        order[i], order[i + 1] = i + 1, i
        if n > 2:
            made.append(Wrong(f"[{i + 1}] and [{i + 2}] exchanged", "axes", np.eye(n)[order]))
    return made
