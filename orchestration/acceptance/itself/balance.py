"""A plant's momentum by itself: its wheels follow their torques, and what turns it is what acts on it.

R (J Omega + sum h_i u_i) changes over each sample by the integral of R tau, tau = m x b and the gravity gradient.
Where it does not, one cause at a time is fitted to the whole run: the wheels' sign, the rods', the field, the inertia.
Tests: tests/orchestration/acceptance/test_itself.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...fmu.model import Floats
from ..robustness import Trial
from .motion import MU
from .signals import SMALL, Signals, along, apart, best, between, number, rate, rms, transposed

NAMES = (
    "its wheel's momentum follows the torque commanded",
    "its momentum changes by the torques on it",
    "its energy of rotation changes by the work of the torques",
)
_SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
_ALIKE = 0.02
"""How near a matrix is a multiple of another one."""
_USUAL = {-1.0: "the opposite sign", 1e-3: "N.m for mN.m", 1e3: "mN.m for N.m"}


def balance(of: Signals, turning: bool, falling: bool, field_N: Floats | None) -> Iterator[Trial]:
    """Yields what a plant's momentum keeps. `turning`: whether attitude and rate fit each other; `falling`: whether
    the orbit is right, without which there is no gravity gradient; `field_N` (n, 3), T, is the model's field where it
    is known."""
    yield _wheel(of)
    why = of.lacks("R_NB", "omega_B", "b_B", "dipole_cmd") or of.lacks(*(("h_w",) if _wheels(of) else ()))
    why = why or ("" if turning else "its attitude and its rate do not fit each other")
    if not why and of.parameter("rod_period", 0.0)[0] > 0.0 and "dipole_mean" not in of.values:
        why = "its rods take turns, and it does not give dipole_mean"
    if why or "J_B" not in of.told:
        yield from (Trial(name, "", why or "its inertia is not told") for name in NAMES[1:])
        return
    parts = _parts(of, falling)
    yield (held := _momentum(parts, field_N))
    yield _energy(of, parts) if held.status == "met" else Trial(NAMES[2], "", "its momentum does not")


def _wheels(of: Signals) -> bool:
    return bool(of.parameter("wheels", 1)[0])


def _wheel(of: Signals) -> Trial:
    if not _wheels(of):
        return Trial(NAMES[0], "", "it has no wheel")
    if why := of.lacks("h_w", "wheel_torque_cmd"):
        return Trial(NAMES[0], "", why)
    h, most = of.wide("h_w"), of.parameter("wheel_torque_max", np.inf)
    commands = np.clip(of.wide("wheel_torque_cmd"), -most, most)
    given = rate(h, of.time)
    if rms(commands) < 1e-12:
        return Trial(NAMES[0], "", "no torque is commanded in this run")
    free = np.abs(h).max(axis=1) < 0.99 * of.parameter("wheel_momentum_max", np.inf).max()
    free = free[1:] & free[:-1]
    given = given[free]
    held = [commands[:-1][free], commands[1:][free]]  # a record has the command before its instant, or after
    command = min(held, key=lambda one: min(apart(given, one), apart(-given, one)))
    left = apart(given, command)
    if left <= SMALL:
        return Trial(NAMES[0], "met", f"within {100 * left:.2g} %")
    gain = float((given * command).sum() / (command * command).sum())
    usual = next((text for factor, text in _USUAL.items() if abs(gain / factor - 1.0) < SMALL), "")
    words = best([(f"wheel_torque_cmd acts times {gain:.3g}" + (f": {usual}" if usual else ""), given, gain * command)])
    symptom = f"dh_w/dt is {rms(given):.3g} N.m rms, commanded {rms(command):.3g}; no gain explains it"
    return Trial(NAMES[0], "failed", words or symptom)


@dataclass(frozen=True)
class _Parts:
    """Changes over each sample (n - 1, 3), N m s along N, each part of the balance for itself."""

    bodies: Floats
    """(n - 1, 3, 6): for each element of the inertia one, the gravity gradient's part taken out."""
    wheels: Floats
    rods: Floats
    """(n - 1, 3, 3): by each rod."""
    rest: Floats
    """By the torques that are told."""
    J: Floats
    """(6,)"""
    step: Floats
    R: Floats
    rods_B: Floats
    """Dipoles (n - 1, 3, 3) along the body's axes by rod, A m2."""

    @property
    def body(self) -> Floats:
        return self.bodies @ self.J


def _parts(of: Signals, falling: bool) -> _Parts:
    R, omega, b, step = of.values["R_NB"], of.values["omega_B"], of.values["b_B"], np.diff(of.time)[:, None]
    J = of.parameter("J_B", 0.0) + of.parameter("J_error_B", np.zeros((3, 3)))
    basis = np.zeros((6, 3, 3))
    for k, (i, j) in enumerate(_SYMMETRIC):
        basis[k, i, j] = basis[k, j, i] = 1.0
    bodies = np.einsum("nij,kjl,nl->nik", R, basis, omega)
    changed = np.diff(bodies, axis=0)
    if falling and bool(of.parameter("gravity_gradient", 0.0)[0]) and not of.lacks("r_N"):
        r = of.values["r_N"]
        size = np.linalg.norm(r, axis=1, keepdims=True)
        up = along(transposed(R), r / size)
        turned = np.cross(up[:, None, :], np.einsum("kij,nj->nki", basis, up))  # (n, 6, 3)
        moments = 3.0 * MU / size[:, :, None] ** 3 * turned
        changed -= between(np.einsum("nij,nkj->nik", R, moments)) * step[:, :, None]
    wheels = np.zeros((len(R), 3))
    if _wheels(of):
        axes = of.parameter("wheel_axis", [1.0, 0.0, 0.0]).reshape(-1, 3)[: of.wide("h_w").shape[1]]
        wheels = along(R, of.wide("h_w") @ (axes / np.maximum(np.linalg.norm(axes, axis=1, keepdims=True), 1e-12)))
    dipole, axes = _dipoles(of), of.parameter("rod_axes", np.eye(3)).reshape(3, 3)
    rods_B = dipole[:, :, None] * axes  # (n - 1, rod, axis)
    over = between(R)
    field = between(along(R, b))
    rods = np.cross(np.einsum("nij,nkj->nki", over, rods_B), field[:, None, :]) * step[:, :, None]
    told = between(along(R, np.broadcast_to(of.parameter("disturbance_torque_B", np.zeros(3)), omega.shape)))
    residual = np.broadcast_to(of.parameter("residual_dipole_B", np.zeros(3)), omega.shape)
    rest = (told + np.cross(between(along(R, residual)), field)) * step
    J6 = np.array([J.reshape(3, 3)[i, j] for i, j in _SYMMETRIC])
    return _Parts(changed, np.diff(wheels, axis=0), rods.transpose(0, 2, 1), rest, J6, step, over, rods_B)


def _dipoles(of: Signals) -> Floats:
    """The dipoles (n - 1, 3) of the rods over each sample."""
    if "dipole_mean" in of.values:
        return of.values["dipole_mean"][1:]
    if "dipole" in of.values:
        return of.values["dipole"][1:]
    most = of.parameter("dipole_max", np.inf) * of.parameter("rod_limits", np.ones(3))
    return np.clip(of.values["dipole_cmd"], -most, most)[1:] * of.parameter("rod_gain", np.ones(3))


def _momentum(parts: _Parts, field_N: Floats | None) -> Trial:
    body, wheels, rods, rest = parts.body, parts.wheels, parts.rods.sum(axis=2), parts.rest
    scale = max(rms(body), rms(wheels), rms(rods)) or 1e-300
    off = body + wheels - rods - rest

    def left(residual: Floats) -> float:
        return rms(residual) / scale

    if left(off) <= SMALL:
        return Trial(NAMES[1], "met", f"within {100 * left(off):.2g} %")
    found: list[tuple[float, str]] = []

    def fitted(columns: Floats, target: Floats) -> tuple[Floats, float]:
        flat = columns.reshape(-1, columns.shape[-1])
        values = np.asarray(np.linalg.lstsq(flat, target.ravel(), rcond=None)[0], np.float64)
        return values, rms(columns @ values - target) / max(rms(columns @ values), scale)

    for name, part, others in (
        ("the wheel's momentum", wheels, body - rods - rest),
        ("the dipole of the rods", -rods, body + wheels - rest),
    ):
        if rms(part) > 0.01 * scale:
            (gain,), rest_ = fitted(part[:, :, None], -others)
            sign = ": the opposite sign" if abs(gain + 1.0) < SMALL else ""
            found.append((rest_, f"{name} acts on the body times {gain:.3g}{sign}"))
    if field_N is not None:
        dipole = along(parts.R, parts.rods_B.sum(axis=1))
        true = np.cross(dipole, between(field_N)) * parts.step
        if (in_model := left(body + wheels - true - rest)) <= SMALL:  # then b_B alone is wrong
            text = f"it holds with the model's field in the place of b_B (leaves {100 * in_model:.2g} %)"
            return Trial(NAMES[1], "failed", text)
    J, rest_ = fitted(parts.bodies, rods + rest - wheels)
    found.append((rest_, _inertia(J, parts.J)))
    gains, rest_ = fitted(parts.rods, body + wheels - rest)
    found.append((1.5 * rest_, f"the rods act times {number(gains)}"))  # one gain of all is preferred
    least, words = min(found)
    if least <= SMALL:
        return Trial(NAMES[1], "failed", f"{words} (leaves {100 * least:.2g} %)")
    text = f"{100 * left(off):.2g} % of it is not explained by rods, wheel and gravity gradient, nor by another inertia"
    return Trial(NAMES[1], "failed", text)


def _inertia(J: Floats, told: Floats) -> str:
    factor = float(J @ told / (told @ told))
    if np.abs(J - factor * told).max() <= _ALIKE * factor * np.abs(told).max():
        return f"its inertia is {factor:.3g} times J_B as it is told"
    names = [f"J_B[{i + 1},{j + 1}]" for i, j in _SYMMETRIC]
    other = [k for k in range(6) if abs(J[k] - told[k]) > _ALIKE * np.abs(told).max()]
    return "its inertia differs: " + ", ".join(f"{names[k]} is {J[k]:.3g}, told {told[k]:.3g} kg.m2" for k in other)


def _energy(of: Signals, parts: _Parts) -> Trial:
    omega, full = of.values["omega_B"], np.zeros((3, 3))
    for k, (i, j) in enumerate(_SYMMETRIC):
        full[i, j] = full[j, i] = parts.J[k]
    changes = 0.5 * np.diff(np.einsum("ni,ij,nj->n", omega, full, omega))
    gradient = np.diff(np.einsum("nij,jk,nk->ni", of.values["R_NB"], full, omega), axis=0) - parts.body
    wheels = parts.wheels.copy()
    moved = parts.rods.sum(axis=2) + parts.rest + gradient - wheels
    work = (along(transposed(parts.R), moved) * between(omega)).sum(axis=1)
    # The wheels' momentum turns with the body, which does no work: R(h u) changes by R(dh u) and R(omega x h u) dt.
    course, worked = np.cumsum(changes), np.cumsum(work)
    left = float(np.abs(course - worked).max() / max(np.abs(course).max(), np.abs(worked).max(), 1e-300))
    return Trial(NAMES[2], "met" if left <= SMALL else "failed", f"within {100 * left:.2g} %")
