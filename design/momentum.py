"""The least time in which the balance of angular momentum allows a manoeuvre: a proven lower bound.

Longer than 250 lines: the proof stands here.

Rods and wheel cannot change the momentum H_N = R (J Omega + l_w e_w) as they like: the wheel's torque is internal,
and a dipole m in the field B gives m x B only. Over [0, T]

    H_N(T) - H_N(0) = integral of (m x B_N + disturbances) dt,      |m| <= rho,

where the ball of radius rho contains every rotation of the rods' polytope, so nothing need be known of the attitude
on the way. At the end the motion is the desired one (to a tolerance), so that H_N(T) = R_d (J Omega_d + l e_w) for some
|l| <= l_max; of a set, the sum over its wheels. For a unit vector p, p.(m x B) = m.(B x p) <= rho |B x p|.
Hence no dipole history does it within T if for some p

    g(p, T) = p.D - l_max |p.a| - rho (integral of |B_N x p| dt) - slack |p| > 0,
    D = R_d J Omega_d - H_N(0),  a = R_d e_w,  slack: disturbances over T and the tolerances.

The end states and the reachable momenta are convex compact sets, so such a p exists whenever they are disjoint; g is
concave in p, and its maximum over the unit ball is a convex problem. Whatever p the optimiser returns is a proof by
itself: it need only be inserted. The integral is bounded from above (impulse.py).

As T grows by dT, g falls by at most `_fall` dT, so that every time in [T, T + g/_fall) is impossible too: from T = 0
on, such steps end where g vanishes, and all times before are excluded, not only those that were looked at.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

import plant
from controller import Parameters as Law
from controller import reference as references
from controller.reference import Reference
from orchestration import InputError
from plant.solar_pressure import at_distance
from plant.sun import AU

from .exact import Array
from .impulse import Impulse, across
from .loop import Setup

PERIHELION = 0.983
"""au"""


@dataclass(frozen=True)
class Tolerance:
    """Largest errors at the end: attitude, rad, and rate, rad/s."""

    attitude: float = math.radians(2.0)
    rate: float = 1e-3


@dataclass(frozen=True)
class Verdict:
    """Result of the balance for one time T."""

    time: float
    gap: float
    """Largest g found, N m s: momentum that is short. Positive: T is proven impossible."""
    direction: Array
    """p (3,) in N, the certificate."""
    needed: float
    """p.D - l_max |p.a|, N m s, along p/|p|; l_max |p.a| of each wheel."""
    impulse: float
    """rho times the integral of |B x p|, N m s, the most that the rods give along p/|p|."""
    slack: float
    """Disturbances and tolerances, N m s."""

    @property
    def possible(self) -> bool:
        """Returns whether nothing is proven against T."""
        return self.gap <= 0.0


@dataclass(frozen=True)
class Bound:
    """The least time that conservation allows."""

    least: float | None
    """No time below it is possible, s; None: none up to `horizon` is."""
    simple: float | None
    """The same with the simple directions only."""
    horizon: float


def farthest(rod_axes: Array) -> float:
    """Norm of the farthest vertex of {sum mu_i u_i, |mu_i| <= 1}: radius of the least ball about 0 that holds it."""
    axes = rod_axes / np.linalg.norm(rod_axes, axis=1)[:, None]
    return max(float(np.linalg.norm(np.array(signs) @ axes)) for signs in itertools.product((-1.0, 1.0), repeat=3))


class MomentumBalance:
    """The balance of momentum of one manoeuvre."""

    def __init__(
        self,
        p: plant.Parameters,
        law: Law,
        dipole_max: float | None = None,
        tolerance: Tolerance = Tolerance(),
        horizon: float = 6000.0,
    ) -> None:
        """`dipole_max` of each rod, A m2, instead of the plant's; `horizon`, s: the longest time asked for."""
        self.plant, self.law, self.horizon = p, law, horizon
        self.rho = farthest(p.rod_axes) * (p.dipole_max if dipole_max is None else dipole_max)
        self.rho += float(np.linalg.norm(p.residual_dipole_B))
        self.l_max = np.array(p.of_wheels(p.wheel_momentum_max)[: p.wheels])
        moments = np.linalg.eigvalsh(p.body.J)
        spread = float(moments[2] - moments[0])
        self.field = Impulse(p.field.at, self.rho, horizon)
        times = self.field.times
        x = plant.start(p, plant.Inputs(np.zeros(3), 0.0))
        self.H0 = x.R @ x.Pi
        held = float(self.l_max.sum())
        self._turn = max(float(np.linalg.norm(self._reference(t).Omega_d)) for t in times[:: max(1, len(times) // 50)])
        rate = self._turn * 1.0001
        chord = 2.0 * math.sin(0.5 * min(tolerance.attitude, math.pi))
        self._tolerance = float(moments[2]) * tolerance.rate + chord * (held + spread * rate)
        self._disturbance = self._disturbances(spread, times)
        self._J = p.body.J
        self._fall = rate * (float(moments[2]) * rate + held) + self.rho * self.field.B_max + self._disturbance
        # An Omega_d that changes (an eccentric orbit) moves D as well: |J dOmega_d|, at its largest sampled value.
        change = max(float(np.linalg.norm(self._reference(t).dOmega_d)) for t in times[:: max(1, len(times) // 50)])
        self._fall += 1.1 * float(moments[2]) * change

    @property
    def H0_size(self) -> float:
        """|H_N(0)|, N m s."""
        return float(np.linalg.norm(self.H0))

    def _reference(self, t: float) -> Reference:
        law = self.law
        if law.reference == "lvlh":
            return references.lvlh(*self.plant.orbit.position_velocity(t))
        if law.reference == "inertial":
            return references.inertial(law.desired_attitude_0)
        return references.rate(law.desired_attitude_0, law.Omega_d0, t)

    def _disturbances(self, spread: float, times: Array) -> float:
        """A bound on the disturbing moments, N m, whatever the attitude."""
        p = self.plant
        total = float(np.linalg.norm(p.disturbance_torque_B))
        orbit = p.orbit
        nearest = orbit.semi_major_axis * (1.0 - orbit.eccentricity)
        if p.gravity_gradient:  # |3 mu/r^3 r_hat x J r_hat| <= 3/2 mu/r^3 (J_max - J_min)
            total += 1.5 * p.gravitational_parameter / nearest**3 * spread
        if p.drag:
            pressure = 0.0
            for t in times[::10]:
                v, density = p.air.flow(float(t))
                pressure = max(pressure, density * float(v @ v))
            # Twice the sampled pressure: between samples 10 s apart it moves by a few per cent.
            total += 2.0 * pressure * float(np.linalg.norm(p.surface.arms, axis=1).sum())
        if p.solar_pressure:  # |F_i| <= p A_i (1 - s + 2 s + 2/3 d), at perihelion
            arms = np.linalg.norm(p.light.arms, axis=1) * p.light.plates.areas
            push = at_distance(PERIHELION * AU) * (1.0 + p.solar_specular + 2.0 / 3.0 * p.solar_diffuse)
            total += push * float(arms.sum())
        return total

    def needed(self, T: float) -> tuple[Array, Array]:
        """D (3,) and a (n,3) at time T: momentum to be given with empty wheels, N m s, and the wheels' axes, in N."""
        reference = self._reference(T)
        return reference.R_d @ (self._J @ reference.Omega_d) - self.H0, self.plant.wheel_axes @ reference.R_d.T

    def slack(self, T: float) -> float:
        return self._tolerance + self._disturbance * T

    def gap(self, p: Array, T: float) -> float:
        """g(p, T), N m s, from below; p (3,) with |p| <= 1."""
        D, a = self.needed(T)
        size = float(np.linalg.norm(p))
        return float(p @ D) - float(self.l_max @ abs(a @ p)) - self.field.impulse(p, T) - self.slack(T) * size

    def at(self, T: float, guess: Array | None = None) -> Verdict:
        """The best certificate against T, s, that the optimiser finds."""
        D, a = self.needed(T)
        simple = D / np.linalg.norm(D)
        starts = [simple] if guess is None else [guess, simple]
        candidates = [simple, *(self._optimise(p, D, a, T) for p in starts)]
        best = max(candidates, key=lambda p: self.gap(p, T))
        return Verdict(
            time=T,
            gap=self.gap(best, T),
            direction=best,
            needed=float(best @ D) - float(self.l_max @ abs(a @ best)),
            impulse=self.field.impulse(best, T),
            slack=self.slack(T),
        )

    def _optimise(self, start: Array, D: Array, a: Array, T: float) -> Array:
        """Maximises g over the unit ball; l_max |p.a| becomes l_max u with -u <= p.a <= u, of each wheel.

        Returns a unit vector."""
        B, w = self.field.chords(T)
        G = across(B)
        scale = 1.0 / float(np.linalg.norm(D))
        steady = self.slack(T) + self.rho * float(w.sum()) * self.field.error

        def cost(x: Array) -> tuple[float, Array]:
            p, u = x[:3], x[3:]
            size = math.sqrt(p @ p) + 1e-300
            Gp = G @ p
            size_across = np.sqrt(np.maximum(Gp @ p, 1e-300))
            value = p @ D - self.l_max @ u - self.rho * (w @ size_across) - steady * size
            slope = D - self.rho * ((w / size_across) @ Gp) - steady * p / size
            return -scale * value, -scale * np.append(slope, -self.l_max)

        one = np.eye(len(a))
        limits = [
            {"type": "ineq", "fun": lambda x: x[3:] - a @ x[:3], "jac": lambda x: np.hstack((-a, one))},
            {"type": "ineq", "fun": lambda x: x[3:] + a @ x[:3], "jac": lambda x: np.hstack((a, one))},
            {
                "type": "ineq",
                "fun": lambda x: 1.0 - x[:3] @ x[:3],
                "jac": lambda x: np.append(-2.0 * x[:3], 0.0 * x[3:]),
            },
        ]
        from scipy.optimize import minimize  # optional, for this command alone  # noqa: PLC0415

        found = minimize(
            cost,
            np.append(start, abs(a @ start)),
            jac=True,
            method="SLSQP",
            constraints=limits,
            options={"ftol": 1e-12, "maxiter": 100},
        )
        p = found.x[:3]
        size = float(np.linalg.norm(p))
        return p / size if size > 1e-9 and np.isfinite(size) else start

    def least_time(self, resolution: float = 0.01) -> Bound:
        """Excludes times from 0 on until g vanishes; steps below `resolution`, s, end the search."""
        return Bound(self._march(resolution, False), self._march(resolution, True), self.horizon)

    def _march(self, resolution: float, simple: bool) -> float | None:
        T, p = 0.0, None
        while self.horizon > T:
            if simple:
                gap = self.at_simple(T)
            else:
                found = self.at(T, p)
                gap, p = found.gap, found.direction
            if gap <= 0.0 or gap / self._fall < resolution:
                return float(T + max(gap, 0.0) / self._fall)
            T += gap / self._fall
        return None

    def at_simple(self, T: float) -> float:
        """g of p = D/|D|, N m s."""
        D, _ = self.needed(T)
        return self.gap(D / np.linalg.norm(D), T)


def balance(setup: Setup, dipole_max: float | None = None, horizon: float = 6000.0) -> MomentumBalance:
    """The balance of a scenario. Raises InputError, with the place, for what gives no bound."""
    p = setup.loop.plant
    if find_spec("scipy") is None:
        raise InputError("momentum-bound needs the package scipy: pip install scipy")
    if not horizon > 0.0 or not math.isfinite(horizon):
        raise InputError(f"horizon: expected a time above zero, found {horizon:g} s")
    if dipole_max is not None and not 0.0 < dipole_max < math.inf:
        raise InputError(f"dipole_max: expected a limit above zero, found {dipole_max:g} A.m2")
    if dipole_max is None and not p.dipole_max > 0.0:
        raise setup.error(
            "plant",
            "dipole_max",
            "expected a limit above zero, found 0 A.m2: rods that give nothing take no momentum out",
        )
    return MomentumBalance(p, setup.loop.controller, dipole_max, horizon=horizon)
