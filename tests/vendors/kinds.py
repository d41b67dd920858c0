"""Each kind of vendor FMU, with its expected answer: written together, and not changed after a measurement.

right   the FMU's words, units and names tell what it is, so `check --suggest` has to propose the mapping in full.
wrong   nothing in the FMU tells it: it has to be detected and named, with the mapping that corrects it.
cause   no wiring corrects it: the cause has to be named with its size, or else nothing but the symptom.
silent  nothing can name it: it has to be detected, and no cause stated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from orchestration.quantities import parse_unit

from .wrapper import Port, Vendor

NAMES: dict[str, dict[str, tuple[str, ...]]] = {
    "allocator": {
        "tau_cmd_B": ("torque_request", "T_cmd", "demand_torque", "trq_dem", "ctrl_moment"),
        "b_B": ("mag", "magnetometer", "mag_field", "bfield", "field_body"),
        "omega_B": ("gyro", "body_rate", "ang_vel", "rates", "imu_rate"),
        "h_w": ("wheel_momentum", "h_rw", "rw_momentum", "wheel_h"),
        "dipole_cmd": ("mtq_dipole", "magnetorquer_cmd", "dipoles", "rod_moment", "mtq_cmd"),
        "wheel_torque_cmd": ("rw_torque", "wheel_motor", "motor_torque", "rw_torque_cmd"),
    },
    "controller": {
        "R_NB": ("attitude", "dcm", "att", "C_IB"),
        "omega_B": ("gyro", "body_rate", "ang_vel", "rates", "imu_rate"),
        "r_N": ("pos", "position", "sat_pos", "gps_pos"),
        "v_N": ("vel", "velocity", "sat_vel", "gps_vel"),
        "tau_cmd_B": ("ctrl_torque", "torque_out", "T_ctrl", "trq"),
    },
}
WORDS = {
    "tau_cmd_B": "Torque demanded of the actuators, on the spacecraft",
    "b_B": "Magnetic field in body axes",
    "omega_B": "Angular rate of the body",
    "h_w": "Angular momentum of the wheel",
    "dipole_cmd": "Magnetic dipole moments of the torquers",
    "wheel_torque_cmd": "Torque of the wheel's motor on its rotor",
    "R_NB": "Attitude as direction cosine matrix from body to inertial",
    "r_N": "Position of the spacecraft, inertial",
    "v_N": "Velocity of the spacecraft, inertial",
}
UNITS = {
    "tau_cmd_B": ("N.m", "mN.m", "uN.m"),
    "b_B": ("T", "nT", "uT", "G"),
    "omega_B": ("rad/s", "deg/s", "rpm"),
    "h_w": ("N.m.s", "mN.m.s"),
    "dipole_cmd": ("A.m2", "mA.m2"),
    "wheel_torque_cmd": ("N.m", "mN.m"),
    "r_N": ("m", "km"),
    "v_N": ("m/s", "km/s"),
}
SPELLINGS: tuple[Callable[[str], list[str]], ...] = (
    lambda n: [f"{n}_{a}" for a in "xyz"],
    lambda n: [f"{n}{a}" for a in "123"],
    lambda n: [f"{n}_{a}" for a in "012"],
    lambda n: [f"{n}[{a}]" for a in "123"],
    lambda n: [f"{n}_{a}" for a in "XYZ"],
    lambda n: [f"{n}.{a}" for a in "xyz"],
    lambda n: [f"{a}_{n}" for a in "xyz"],
)
MATRICES: tuple[Callable[[str], list[str]], ...] = (
    lambda n: [f"{n}_{i}{j}" for i in "123" for j in "123"],
    lambda n: [f"{n}[{i},{j}]" for i in "123" for j in "123"],
    lambda n: [f"{n}_{i}_{j}" for i in "012" for j in "012"],
    lambda n: [f"{n}{i}{j}" for i in "123" for j in "123"],
)
INERTIA = 5.2e-5
AREA = 40.0
START = {"b_B": [2e-5, 1e-5, -3e-5], "r_N": [6971000.0, 0.0, 0.0], "v_N": [0.0, -1052.3891, 7488.1109]}


@dataclass
class Case:
    """A vendor's FMU and what is to be said of it."""

    vendor: Vendor
    rng: Random
    kinds: list[str] = field(default_factory=list)
    answer: str = "right"
    """right, wrong, cause or silent: the hardest of its kinds."""
    truth: dict[str, tuple[Any, ...]] = field(default_factory=dict)
    """By port: what the right mapping is in the end."""
    named: set[str] = field(default_factory=set)
    """Ports of which a wrong wiring has to be named."""
    causes: list[tuple[str, str, float]] = field(default_factory=list)
    """Cause, port or parameter, and size."""
    touched: set[str] = field(default_factory=set)
    common: Any = None
    """The rotation of all body vectors."""


def base(block: str, rng: Random, units: bool) -> Case:
    """Returns a vendor's FMU that does what ours does, in its own names."""
    ports = []
    spelling, matrix = rng.choice(SPELLINGS), rng.choice(MATRICES)
    for ours, choices in NAMES[block].items():
        name = rng.choice(choices)
        n = {"R_NB": 9, "h_w": 1, "wheel_torque_cmd": 1}.get(ours, 3)
        names = [name] if n == 1 else matrix(name) if n == 9 else spelling(name)
        causality = "output" if ours in ("dipole_cmd", "wheel_torque_cmd") else "input"
        if block == "controller":
            causality = "output" if ours == "tau_cmd_B" else "input"
        unit = UNITS[ours][0] if ours in UNITS else None
        start = START.get(ours, np.eye(3).ravel().tolist() if n == 9 else [0.0] * n)
        text = WORDS[ours] + ("" if units or unit is None else f" [{unit}]")
        ports.append(Port(ours, causality, names, unit if units else None, text, np.eye(n), np.zeros(n), start=start))
    return Case(Vendor(block, ports), rng)


# ------------------------------------------------------------ right: told by the FMU


def _rescaled(case: Case, ours: str, unit: str) -> None:
    port = case.vendor.port(ours)
    factor = 1.0 / (parse_unit(unit).factor / parse_unit(UNITS[ours][0]).factor)
    port.A, port.start = port.A * factor, [x * factor for x in port.start]


def unit(case: Case, ours: str) -> None:
    """Another unit, declared, or told by the description where the FMU declares none."""
    chosen = case.rng.choice(UNITS[ours][1:])
    port = case.vendor.port(ours)
    _rescaled(case, ours, chosen)
    if port.unit:
        port.unit = chosen
    else:
        port.description = port.description.replace(f"[{UNITS[ours][0]}]", f"[{chosen}]")


def speed(case: Case, ours: str) -> None:
    """A wheel's speed for its momentum; the rotor's inertia is a parameter of theirs."""
    chosen = case.rng.choice(("rad/s", "rpm"))
    port = case.vendor.port(ours)
    port.names, port.description = [case.rng.choice(("wheel_speed", "tacho", "rw_speed"))], "Speed of the wheel"
    port.unit, port.A = chosen, np.eye(1) / INERTIA / parse_unit(chosen).factor
    case.vendor.parameters.append(("rotor_inertia", "kg.m2", INERTIA, "Moment of inertia of the wheel's rotor"))


def reaction(case: Case, ours: str) -> None:
    """The torque on the body in place of that on the rotor."""
    port = case.vendor.port(ours)
    port.A, port.description = (
        -port.A,
        port.description.replace(WORDS[ours], "Reaction torque of the wheel on the body"),
    )


def current(case: Case, ours: str) -> None:
    """The coils' currents for the dipoles; turns times area is a parameter of theirs."""
    port = case.vendor.port(ours)
    port.names = [name.replace("dipole", "current").replace("moment", "current") for name in port.names]
    port.unit, port.description, port.A = "A", "Currents of the magnetorquers", port.A / AREA
    case.vendor.parameters.append(("turns_area", "m2", AREA, "Turns times area of a coil, dipole for each ampere"))


def _attitude(case: Case, names: list[str], words: str, form: int, inverse: bool, factor: float = 1.0) -> Port:
    port = case.vendor.port("R_NB")
    port.names, port.description, port.kind, port.form, port.inverse = names, words, "attitude", form, inverse
    port.factor, port.start = factor, [0.0] * len(names)
    if form < 2:
        port.start = [1.0, 0, 0, 0] if form == 0 else [0.0, 0, 0, 1]
    return port


def quaternion(case: Case, ours: str, told: bool = True, order: int | None = None) -> None:
    """A quaternion, its order and its direction told."""
    last, inverse = case.rng.random() < 0.5, case.rng.random() < 0.5
    name = case.rng.choice(("q", "quat", "att_q", "q_att"))
    ends = {False: ("wxyz", "0123", "sxyz"), True: ("xyzw", "1234", "xyzs")}[last] if told else ("0123", "1234")
    names = [f"{name}_{a}" for a in case.rng.choice(ends)]
    words = "Attitude quaternion"
    if told:
        words += f", scalar {'last' if last else 'first'}, from {'inertial to body' if inverse else 'body to inertial'}"
    _attitude(case, names, words, int(last), inverse)
    case.truth[ours] = ("quaternion", last, inverse)


def transposed(case: Case, ours: str, told: bool = True) -> None:
    """The matrix from N to B."""
    port = case.vendor.port(ours)
    port.A = np.eye(9)[[0, 3, 6, 1, 4, 7, 2, 5, 8]]
    if told:
        port.description = "Attitude as direction cosine matrix from inertial to body"


def euler(case: Case, ours: str) -> None:
    """Euler angles whose order and direction are told."""
    axes, degrees = case.rng.choice(("zyx", "xyz", "zxz", "zxy")), case.rng.random() < 0.5
    inverse = case.rng.random() < 0.3
    factor = np.pi / 180 if degrees else 1.0
    names = [f"{case.rng.choice(('euler', 'angle'))}_{i}" for i in "123"]
    names = [names[0][:-1] + i for i in "123"]
    a, b, c = ("xyz".index(x) for x in axes)
    direction = "inertial to body" if inverse else "body to inertial"
    words = f"Euler angles {axes} about the turned axes, {direction}"
    port = _attitude(case, names, words, 100 * (a + 4) + 10 * b + c, inverse, factor)
    if port.unit is None and case.vendor.port("omega_B").unit:
        port.unit = "deg" if degrees else "rad"
    else:
        port.description += " [deg]" if degrees else " [rad]"
    case.truth[ours] = ("rotation", f"euler {axes.upper()}", inverse)


def parameters_of_rodrigues(case: Case, ours: str) -> None:
    """Modified Rodrigues parameters."""
    _attitude(case, [f"mrp_{i}" for i in "123"], "Attitude, modified Rodrigues parameters, body to inertial", 2, False)
    case.truth[ours] = ("rotation", "mrp", False)


def rotation_vector(case: Case, ours: str) -> None:
    """The rotation vector, rad."""
    port = _attitude(case, [f"rotvec_{i}" for i in "xyz"], "Attitude as rotation vector, body to inertial", 3, False)
    port.unit = "rad" if case.vendor.port("omega_B").unit else None
    case.truth[ours] = ("rotation", "rotation vector", False)


def inertial_rate(case: Case, ours: str, told: bool = True) -> None:
    """The rate along the axes of N."""
    port = case.vendor.port(ours)
    port.kind, port.form = "turned", 0
    if told:
        port.description = port.description.replace(WORDS[ours], "Angular rate of the body in inertial axes")
    case.truth[ours] = ("turned",)


# ------------------------------------------------------------ wrong: not told


def _rotations(rng: Random, proper: bool) -> Any:
    order = rng.choice([(1, 2, 0), (2, 0, 1), (1, 0, 2), (0, 2, 1), (2, 1, 0), (0, 1, 2)])
    while True:
        signs = [rng.choice((1.0, -1.0)) for _ in range(3)]
        matrix = np.diag(signs) @ np.eye(3)[list(order)]
        if (np.linalg.det(matrix) > 0) == proper and not np.array_equal(matrix, np.eye(3)):
            return matrix


def axes(case: Case, ours: str, proper: bool = True) -> None:
    """Other axes at one port."""
    port = case.vendor.port(ours)
    port.A = _rotations(case.rng, proper) @ port.A


def common(case: Case, ours: str) -> None:
    """One proper rotation of all body vectors."""
    P = _rotations(case.rng, True)
    for port in case.vendor.ports:
        if port.ours in ("tau_cmd_B", "b_B", "omega_B"):
            port.A = P @ port.A
        elif port.ours == "R_NB":  # x_N = R x_B = (R P^T) (P x_B)
            port.A = np.kron(np.eye(3), P) @ port.A
        else:
            continue
        case.named.add(port.ours)


def opposite(case: Case, ours: str) -> None:
    """The opposite sign."""
    port = case.vendor.port(ours)
    port.A = -port.A


def other_unit(case: Case, ours: str) -> None:
    """Another unit than is declared."""
    _rescaled(case, ours, case.rng.choice(UNITS[ours][1:]))


def untold_quaternion(case: Case, ours: str) -> None:
    """A quaternion, of which neither order nor direction is told."""
    quaternion(case, ours, told=False)


# ------------------------------------------------------------ frames: no mapping serves


def relative_rate(case: Case, ours: str) -> None:
    """The rate relative to LVLH."""
    case.vendor.port(ours).kind, case.vendor.port(ours).form = "turned", 1
    case.causes.append(("frame", ours, 0.0))


def earth(case: Case, ours: str) -> None:
    """The position along axes that turn with the Earth."""
    port = case.vendor.port(ours)
    port.kind, port.factor = "earth", 1.7
    case.causes.append(("frame", ours, float(np.degrees(port.factor))))


def of_2000(case: Case, ours: str) -> None:
    """Position and velocity along the axes of J2000, read as those of date (Lieske's precession of 26.8 years)."""
    t = case.rng.choice((0.1, 0.268, 0.5))
    z, theta, zeta = (np.radians(x * t / 3600.0) for x in (2306.2181, 2004.3109, 2306.2181))
    P = Rotation.from_euler("ZYZ", [z, -theta, zeta]).as_matrix()
    for name in ("r_N", "v_N"):
        case.vendor.port(name).A = P @ case.vendor.port(name).A
        case.touched.add(name)
    case.causes.append(("frame", "r_N and v_N", 0.0))


# ------------------------------------------------------------ causes


def _effect(kind: str, value: Callable[[Case, str], float], all_axes: bool = True) -> Callable[[Case, str], None]:
    def make(case: Case, ours: str) -> None:
        size = value(case, ours)
        count = case.vendor.port(ours).size
        for i in range(count) if all_axes else [case.rng.randrange(count)]:
            case.vendor.effects.append((kind, ours, i, size))
        case.causes.append((kind, ours, size))

    return make


LARGEST = {"tau_cmd_B": 1.4e-4, "dipole_cmd": 12.0, "wheel_torque_cmd": 8e-4}
"""About what these reach in V.B."""


def gain(case: Case, ours: str) -> None:
    """A gain on one axis."""
    port, factor = case.vendor.port(ours), case.rng.choice((0.8, 0.9, 1.15, 1.3))
    row = case.rng.randrange(port.size)
    port.A = np.diag([factor if i == row else 1.0 for i in range(port.size)]) @ port.A
    case.causes.append(("gain", f"{ours}[{row + 1}]", factor))


def bias(case: Case, ours: str) -> None:
    """A bias on one axis."""
    port, share = case.vendor.port(ours), case.rng.choice((0.1, -0.2))
    row = case.rng.randrange(port.size)
    port.c = port.c + share * LARGEST[ours] * np.eye(port.size)[row]
    case.causes.append(("bias", f"{ours}[{row + 1}]", share * LARGEST[ours]))


def parameter(case: Case, ours: str) -> None:
    """A parameter of another value."""
    names = ["dipole_max"] if case.vendor.block == "allocator" else ["kappa0", "lambda0", "a2", "c2", "J_B"]
    name, factor = case.rng.choice(names), case.rng.choice((0.6, 0.8, 1.25, 1.5))
    if name == "dipole_max":
        factor = 0.5  # else its hold never acts in V.B
    for i in range(9 if name == "J_B" else 1):
        case.vendor.changed[name, i] = factor
    case.causes.append(("parameter", name, factor))


@dataclass(frozen=True)
class Kind:
    """How a convention is made, of which ports, and what the answer is."""

    make: Callable[[Case, str], None]
    ports: tuple[str, ...]
    answer: str
    whole: bool = False
    """Whether it concerns all ports, so that it stands alone beside kinds of causes only."""


_VECTORS = ("tau_cmd_B", "b_B", "omega_B", "dipole_cmd")
_OUT = ("dipole_cmd", "tau_cmd_B")
KINDS: dict[str, Kind] = {
    "names only": Kind(lambda case, ours: None, ("tau_cmd_B",), "right"),
    "unit": Kind(unit, tuple(UNITS), "right"),
    "speed for momentum": Kind(speed, ("h_w",), "right"),
    "torque on the body": Kind(reaction, ("wheel_torque_cmd",), "right"),
    "current for dipole": Kind(current, ("dipole_cmd",), "right"),
    "quaternion": Kind(quaternion, ("R_NB",), "right"),
    "matrix N to B": Kind(transposed, ("R_NB",), "right"),
    "Euler angles": Kind(euler, ("R_NB",), "right"),
    "MRP": Kind(parameters_of_rodrigues, ("R_NB",), "right"),
    "rotation vector": Kind(rotation_vector, ("R_NB",), "right"),
    "rate in N": Kind(inertial_rate, ("omega_B@controller",), "right"),
    "axes of a port, untold": Kind(axes, _VECTORS, "wrong"),
    "axes of all, untold": Kind(common, ("omega_B",), "wrong", whole=True),
    "left-handed port, untold": Kind(lambda case, ours: axes(case, ours, False), _VECTORS, "wrong"),
    "opposite sign, untold": Kind(opposite, ("h_w", "wheel_torque_cmd", "tau_cmd_B", "dipole_cmd", "omega_B"), "wrong"),
    "unit, untold": Kind(other_unit, tuple(UNITS), "wrong"),
    "quaternion, untold": Kind(untold_quaternion, ("R_NB",), "wrong"),
    "matrix N to B, untold": Kind(lambda case, ours: transposed(case, ours, False), ("R_NB",), "wrong"),
    "rate in N, untold": Kind(lambda case, ours: inertial_rate(case, ours, False), ("omega_B@controller",), "wrong"),
    "rate relative to LVLH": Kind(relative_rate, ("omega_B@controller",), "cause"),
    "position along the Earth's axes": Kind(earth, ("r_N",), "cause"),
    "orbit along the axes of J2000": Kind(of_2000, ("r_N",), "cause"),
    "late": Kind(_effect("delay", lambda c, o: c.rng.choice((1.0, 2.0, 5.0))), _OUT, "cause"),
    "late by a fraction": Kind(_effect("delay", lambda c, o: c.rng.choice((0.5, 1.3))), _OUT, "cause"),
    "own sample time": Kind(_effect("hold", lambda c, o: c.rng.choice((5.0, 10.0))), _OUT, "cause"),
    "stuck": Kind(_effect("stuck", lambda c, o: c.rng.choice((40.0, 90.0)), False), _OUT, "cause"),
    "saturated": Kind(_effect("limit", lambda c, o: 0.4 * LARGEST[o]), _OUT, "cause"),
    "lag": Kind(_effect("lag", lambda c, o: c.rng.choice((0.5, 2.0))), _OUT, "cause"),
    "noise": Kind(_effect("noise", lambda c, o: c.rng.choice((0.02, 0.1)) * LARGEST[o]), _OUT, "cause"),
    "dead zone": Kind(_effect("dead", lambda c, o: c.rng.choice((0.03, 0.1)) * LARGEST[o]), _OUT, "cause"),
    "quantised": Kind(_effect("quantum", lambda c, o: c.rng.choice((0.01, 0.05)) * LARGEST[o]), _OUT, "cause"),
    "single precision": Kind(_effect("single", lambda c, o: 0.0), _OUT, "cause"),
    "gain of an axis": Kind(gain, _OUT, "cause"),
    "bias of an axis": Kind(bias, _OUT, "cause"),
    "other parameter": Kind(parameter, _OUT, "cause"),
}
_RANK = ("right", "silent", "cause", "wrong")


def _port(kind: Kind, case: Case) -> str | None:
    """Returns a port of this block that the kind can touch and no other has."""
    free = []
    for text in kind.ports:
        ours, _, only = text.partition("@")
        known = any(port.ours == ours for port in case.vendor.ports)
        if known and ours not in case.touched and only in ("", case.vendor.block):
            free.append(ours)
    if kind.answer == "cause" and set(kind.ports) <= set(_OUT):
        free = [name for name in free if case.vendor.port(name).causality == "output"]
    return case.rng.choice(free) if free else None


def make(seed: int, kinds: list[str], units: bool) -> Case | None:
    """Returns a vendor's FMU of one kind or of two; None where they cannot stand together."""
    rng = Random(seed)
    blocks = [b for b in NAMES if all(any(_of(text, b) for text in KINDS[k].ports) for k in kinds)]
    if not blocks or (len(kinds) > 1 and any(KINDS[k].whole for k in kinds)):
        return None
    case = base(rng.choice(blocks), rng, units)
    for name in kinds:
        kind = KINDS[name]
        ours = _port(kind, case)
        if ours is None:
            return None
        case.touched.add(ours)
        kind.make(case, ours)
        case.kinds.append(name)
        if kind.answer == "wrong":
            case.named.add(ours)
    answers = [KINDS[k].answer for k in kinds]
    case.answer = "both" if {"wrong", "cause"} <= set(answers) else max(answers, key=_RANK.index)
    if "silent" in answers:
        case.answer = "silent"
    for port in case.vendor.ports:
        case.truth.setdefault(port.ours, ("linear", port.A, port.c))
    return case


def _of(text: str, block: str) -> bool:
    ours, _, only = text.partition("@")
    if only:
        return only == block
    return ours in NAMES[block]
