"""Many closed loops at once: plant, law and allocator of the blocks, written for arrays of cases.

A sweep of a thousand runs through the FMUs would take an hour; this takes seconds. It is the blocks' loop at
integrator order 2 with sequential exchange, and agrees with it to rounding, which tests/studies/test_loops.py
holds it to. What it leaves out, it refuses: eccentric orbits, other references than LVLH, wheel friction.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

import plant
from plant.along_orbit import NODE_INTERVAL, _lagrange6
from plant.drag import octagonal_cylinder

from .law import Law, stack
from .setup import Loop
from .vectors import Array, cayley, cross, dot, hat, inverse, norm, product, solve, times, transposed_times

FRACTION_CAP = 1e6
Exact = Callable[[plant.Parameters, float], Array]


@dataclass
class Sample:
    """What is seen of every case at one instant; names and units as at the blocks' ports, components first."""

    t: float
    attitude_error: Array
    rate_error_B: Array
    lyapunov: Array
    tau_cmd_B: Array
    dipole_cmd: Array
    wheel_torque_cmd: Array
    holding: Array
    demand_fraction: Array
    rod_fraction: Array
    """Largest demand of a rod over its limit, before the hold."""
    b_wheel: Array
    b_B: Array
    h_w: Array
    dipole: Array
    dipole_saturated: Array
    wheel_momentum_saturated: Array


class Loops:
    """Closed loops, one for each of `cases`, stepped together."""

    def __init__(self, cases: Sequence[Loop]) -> None:
        for loop in cases:
            _require(loop)
        plants = [c.plant for c in cases]
        limits = [c.allocator for c in cases]
        self.n = len(cases)
        self.environment = Environment(plants)
        self.J = stack([p.body.J for p in plants])
        self.J_inverse = inverse(self.J)
        self.law = Law([c.controller for c in cases])
        self.gravity = np.array([1.0 if p.gravity_gradient else 0.0 for p in plants])
        self.U_T_inverse = inverse(stack([p.U.T for p in limits]))
        self.limits = {
            name: np.array([getattr(p, name) for p in limits])
            for name in ("dipole_max", "wheel_torque_max", "wheel_momentum_max", "hold_fraction")
        }
        self.rods = stack([p.rods_to_body for p in plants])
        self.residual = stack([p.residual_dipole_B for p in plants])
        self.disturbance = stack([p.disturbance_torque_B for p in plants])
        self.true_limits = {
            name: np.array([getattr(p, name) for p in plants])
            for name in ("dipole_max", "wheel_torque_max", "wheel_momentum_max")
        }
        self.substep = min(p.step_max for p in plants)
        self.t = 0.0
        self.R = stack([p.R_NB0 for p in plants])
        self.l_w = np.array([p.h_w0 for p in plants])
        self.Pi = times(self.J, stack([p.omega_B0 for p in plants]))
        self.Pi[0] += self.l_w
        self.dipole_cmd = np.zeros((3, self.n))
        self.wheel_cmd = np.zeros(self.n)

    def fly(self, step: float, duration: float, look: Callable[[Sample], object]) -> None:
        """Runs to the first step at or after `duration`, s; `look` is called at 0 and after each step."""
        look(self._command())
        for i in range(math.ceil(duration / step * (1.0 - 1e-12))):
            self._move(step)
            self.t = (i + 1) * step
            look(self._command())

    # ------------------------------------------------------------------ flight software

    def _command(self) -> Sample:
        """Law [8] and allocation [14]-[24] of the state as it stands, with the hold; commits the commands."""
        P, X = self.environment.plane(self.t)
        Omega = self._rate()
        # LVLH: Q = R_d^T R, columns of R_d along the velocity, -normal, nadir.
        R_d = self.environment.frame(P, X)
        Q = product(np.swapaxes(R_d, 0, 1), self.R)
        d = self.law(Q, Omega, self.environment.rate)
        b_B = transposed_times(self.R, self.environment.field(self.t))
        wanted, dh_w, fraction, rod_fraction, b_wheel = self._allocate(d.tau, b_B, Omega)
        holding = fraction >= self.limits["hold_fraction"]
        self.dipole_cmd = np.where(holding, self.dipole_cmd, wanted)
        self.wheel_cmd = np.where(holding, self.wheel_cmd, dh_w)
        top = self.true_limits["dipole_max"]
        dipole = np.clip(self.dipole_cmd, -top, top)
        drive = self._drive()
        return Sample(
            t=self.t,
            attitude_error=d.zeta,
            rate_error_B=d.omega,
            lyapunov=d.V,
            tau_cmd_B=d.tau,
            dipole_cmd=self.dipole_cmd,
            wheel_torque_cmd=self.wheel_cmd,
            holding=holding,
            demand_fraction=fraction,
            rod_fraction=rod_fraction,
            b_wheel=b_wheel,
            b_B=b_B,
            h_w=self.l_w.copy(),
            dipole=dipole,
            dipole_saturated=np.any(np.abs(self.dipole_cmd) > top, axis=0),
            wheel_momentum_saturated=(drive != 0.0) & self._at_limit(drive),
        )

    def _allocate(self, tau: Array, b_B: Array, Omega: Array) -> tuple[Array, Array, Array, Array, Array]:
        B = norm(b_B)
        b = b_B / B
        along = dot(tau, b) + self.l_w * (Omega[2] * b[1] - Omega[1] * b[2])
        singular = (np.abs(b[0]) < 1e-9) & (along != 0.0)
        dh_w = np.where(along == 0.0, 0.0, -along / np.where(np.abs(b[0]) < 1e-9, np.inf, b[0]))
        tau_MT = tau - np.array((-dh_w, -Omega[2] * self.l_w, Omega[1] * self.l_w))
        # The least dipole in another way than [24]: U^T m = (b x tau_MT)/B + alpha b, alpha such that |m| is least.
        across, free = times(self.U_T_inverse, cross(b, tau_MT) / B), times(self.U_T_inverse, b)
        m = across - (dot(across, free) / dot(free, free)) * free
        rods = np.abs(m).max(axis=0) / self.limits["dipole_max"]
        fraction = np.minimum(np.maximum(rods, np.abs(dh_w) / self.limits["wheel_torque_max"]), FRACTION_CAP)
        fraction[singular] = FRACTION_CAP
        return np.where(singular, 0.0, m), np.where(singular, 0.0, dh_w), fraction, rods, b[0]

    # ------------------------------------------------------------------ plant

    def _rate(self) -> Array:
        Pi = self.Pi.copy()
        Pi[0] -= self.l_w
        return times(self.J_inverse, Pi)

    def _drive(self) -> Array:
        top = self.true_limits["wheel_torque_max"]
        return np.clip(self.wheel_cmd, -top, top)

    def _at_limit(self, drive: Array) -> Array:
        return (np.abs(self.l_w) >= self.true_limits["wheel_momentum_max"]) & (drive * self.l_w >= 0.0)

    def _move(self, step: float) -> None:
        top = self.true_limits["dipole_max"]
        dipole_B = times(self.rods, np.clip(self.dipole_cmd, -top, top)) + self.residual
        parts = max(1, math.ceil(step / self.substep * (1.0 - 1e-12)))
        h = step / parts
        for i in range(parts):
            t = self.t + i * h
            drive = self._drive()
            drive = np.where(self._at_limit(drive), 0.0, drive)
            target = np.copysign(self.true_limits["wheel_momentum_max"], drive)
            with np.errstate(divide="ignore", invalid="ignore"):
                until = np.where(drive == 0.0, np.inf, (target - self.l_w) / drive)
            split = until < h
            l_end = np.where(split, target, self.l_w + drive * h)
            everyone = np.arange(self.n)
            self._lgvi(everyone, t, np.where(split, until, h), l_end, dipole_B, h)
            if split.any():  # the wheel has met its limit: it stays there for the rest of the step
                late = everyone[split]
                self._lgvi(late, t + until[late], h - until[late], target[late], dipole_B, None)

    def _lgvi(self, at: Array, t: Array | float, h: Array, l_end: Array, dipole_B: Array, whole: float | None) -> None:
        """The variational step of plant/attitude.py for the cases `at`, over h (n,), the wheel ending at l_end."""
        full = len(at) == self.n
        pick = slice(None) if full else at
        R, Pi, J, l_w = self.R[..., pick], self.Pi[:, pick], self.J[..., pick], self.l_w[pick]
        kicked = Pi + 0.5 * h * self._moment(R, t, pick, dipole_B)
        a = h * kicked
        p = np.zeros_like(a)
        p[0] = h * 0.5 * (l_w + l_end)
        f = self._cayley_vector(a, p, J, self.J_inverse[..., pick])
        F = cayley(f)
        R = product(R, F)
        end = t + whole if whole is not None and (h == whole).all() else t + h
        Pi = transposed_times(F, kicked)
        Pi = Pi + 0.5 * h * self._moment(R, end, pick, dipole_B)
        self.R[..., pick], self.Pi[:, pick], self.l_w[pick] = R, Pi, l_end

    @staticmethod
    def _cayley_vector(a: Array, p: Array, J: Array, J_inverse: Array) -> Array:
        difference, total = a - p, a + p
        f = 0.5 * times(J_inverse, difference)
        linear = hat(a) - 2.0 * J
        for _ in range(12):
            along = dot(total, f)
            jacobian = linear + f[:, None] * total[None]
            for i in range(3):
                jacobian[i, i] += along
            change = solve(jacobian, difference + times(linear, f) + along * f)
            f = f - change
            if np.abs(change).max() <= 1e-10:
                return f
        raise ValueError("the attitude step does not converge: a case turns too far in one internal step")

    def _moment(self, R: Array, t: Array | float, pick: slice | Array, dipole_B: Array) -> Array:
        """External moment (3, n), N m, in body axes."""
        e = self.environment
        moment = cross(dipole_B[:, pick], transposed_times(R, e.field(t, pick))) + self.disturbance[:, pick]
        P, _ = e.plane(t, pick)
        r_B = transposed_times(R, P)
        moment += self.gravity[pick] * (3.0 * e.rate[pick] ** 2) * cross(r_B, times(self.J[..., pick], r_B))
        return moment + e.drag(R, t, pick) if e.has_drag else moment


class Environment:
    """Field, air and orbit of each case; cases on the same orbit share the nodes that they are interpolated from."""

    def __init__(self, plants: Sequence[plant.Parameters]) -> None:
        known: dict[tuple[object, ...], int] = {}
        shared: list[plant.Parameters] = []
        self._which = np.empty(len(plants), int)
        for i, p in enumerate(plants):
            key = (*(getattr(p, name) for name in _ORBITAL), p.drag)
            if key not in known:
                known[key] = len(shared)
                shared.append(p)
            self._which[i] = known[key]
        self._shared = shared
        self._nodes: dict[int, Array] = {}
        self._air_nodes: dict[int, Array] = {}
        self.rate = np.array([p.orbit.mean_motion for p in plants])
        self._phase = np.array([p.orbit.mean_anomaly for p in plants])
        self._towards = np.array([p.orbit.towards_perigee for p in plants]).T.copy()
        self._along = np.array([p.orbit.along_perigee for p in plants]).T.copy()
        self._minus_normal = -cross(self._towards, self._along)
        self.has_drag = any(p.drag and p.drag_factor for p in plants)
        self._surface = [_surface(p) for p in plants] if self.has_drag else []
        if self.has_drag:
            self._normals = np.array([s[0] for s in self._surface]).transpose(1, 2, 0).copy()
            self._arms = np.array([s[1] for s in self._surface]).transpose(1, 2, 0).copy()

    def plane(self, t: Array | float, pick: slice | Array = slice(None)) -> tuple[Array, Array]:
        """Unit position and unit velocity in N, (3, n)."""
        u = self._phase[pick] + self.rate[pick] * t
        c, s = np.cos(u), np.sin(u)
        P, X = self._towards[:, pick], self._along[:, pick]
        return c * P + s * X, c * X - s * P

    def frame(self, P: Array, X: Array) -> Array:
        """R_LVLH (3, 3, n) of unit position and velocity of every case."""
        return np.stack((X, self._minus_normal, -P), axis=1)

    def field(self, t: Array | float, pick: slice | Array = slice(None)) -> Array:
        """B_N (3, n), T."""
        return self._at(t, pick, self._nodes, lambda p, s: p.field.exact(s))

    def drag(self, R: Array, t: Array | float, pick: slice | Array) -> Array:
        air = self._at(t, pick, self._air_nodes, lambda p, s: p.air.exact(s) if p.drag else np.array((0, 0, 0, -700.0)))
        v_B, density = transposed_times(R, air[:3]), np.exp(air[3])
        normals, arms = self._normals[..., pick], self._arms[..., pick]
        facing = np.maximum(normals[:, 0] * v_B[0] + normals[:, 1] * v_B[1] + normals[:, 2] * v_B[2], 0.0)
        return cross((facing[:, None] * arms).sum(axis=0), -density * v_B)

    def _at(
        self,
        t: Array | float,
        pick: slice | Array,
        nodes: dict[int, Array],
        exact: Callable[[plant.Parameters, float], Array],
    ) -> Array:
        if isinstance(t, np.ndarray):
            one = [
                self._at(float(s), np.array([i]), nodes, exact)
                for s, i in zip(t, np.arange(len(self._which))[pick], strict=True)
            ]
            return np.concatenate(one, axis=1)
        k = math.floor(t / NODE_INTERVAL)
        for i in range(k - 2, k + 4):
            if i not in nodes:
                nodes[i] = np.array([exact(p, i * NODE_INTERVAL) for p in self._shared]).T
        weights = _lagrange6(t / NODE_INTERVAL - k)
        found = np.tensordot(np.array(weights), np.array([nodes[k - 2 + j] for j in range(6)]), axes=1)
        return np.asarray(found[:, self._which[pick]])


_ORBITAL = (
    "orbit_radius inclination node_longitude argument_of_latitude epoch gravitational_parameter field_model "
    "field_degree field_extrapolate f107 f107_average ap"
).split()


def _surface(p: plant.Parameters) -> tuple[Array, Array]:
    plates = octagonal_cylinder(p.body_width, p.body_length, p.body_axis)
    factor = 0.5 * p.drag_factor * p.drag_coefficient if p.drag else 0.0
    return plates.normals, factor * plates.areas[:, None] * (plates.centres - p.center_of_mass_B)


def _require(loop: Loop) -> None:
    p, c = loop.plant, loop.controller
    for name, found, expected in (
        ("plant.orbit_start", p.orbit_start, "circular"),
        ("plant.j2_node_drift", p.j2_node_drift, False),
        ("plant.integrator_order", p.integrator_order, 2),
        ("plant.rod_gain", p.rod_gain.tolist(), [1.0, 1.0, 1.0]),
        ("plant.rod_period", p.rod_period, 0.0),
        ("plant.wheel_viscous_friction", p.wheel_viscous_friction, 0.0),
        ("plant.wheel_coulomb_friction", p.wheel_coulomb_friction, 0.0),
        ("controller.reference", c.reference, "lvlh"),
    ):
        if found != expected:
            raise ValueError(f"{name} is {found!r}; many loops at once are flown with {expected!r} only")
