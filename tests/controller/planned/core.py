"""The planned controller's C functions behind numpy: compiled as the FMUs are, reached through probe.c."""

from __future__ import annotations

import ctypes
import re
from ctypes import byref, c_double, c_int32, c_size_t, c_ubyte
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fmus.interface import load
from fmus.native import generated_sources
from fmus.native.toolchain import FLAGS, FREESTANDING, PLATFORMS, compile_library, compiler, host_platform
from tests.once import built
from tests.structures import filled, record

from .flat import MU, Ahead, Around, Array, FlatAround, FlatMotion, Motion, Satellite, doubles, room_for

ROOT = Path(__file__).parents[3]
NATIVE = ROOT / "controller" / "planned" / "native"
MODELS = ("igrf14", "wmm2010", "wmm2015", "wmm2020", "wmm2025")
STAGES, WORK_OF_SAMPLE = (
    int(re.findall(rf"\b{name} = (\d+)", (NATIVE / "plan" / file).read_text("utf-8"))[0])
    for name, file in (("STAGES", "plan.h"), ("WORK_OF_SAMPLE", "work.h"))
)
_BLOCK = "controller_planned"


@cache
def library() -> ctypes.CDLL:
    """The controller's C with the probe as a shared library."""
    texts = generated_sources(load(_BLOCK), NATIVE.parent)
    sources = sorted(NATIVE.rglob("*.c"))
    probes = sorted(Path(__file__).parent.glob("probe*.c"))
    common = [ROOT / "fmus" / "native" / "common", NATIVE]
    host = host_platform()

    def make(path: Path) -> None:
        for name, text in texts.items():
            path.with_name(name).write_text(text, "utf-8")
        path.write_bytes(compile_library("probe", [*probes, *sources], [*common, path.parent], [host])[host])

    made_of = [compiler(), *FLAGS, *texts.values(), *probes, probes[0].with_name("probe_flat.h"), *common, FREESTANDING]
    lib = ctypes.CDLL(str(built(f"probe{PLATFORMS[host].suffix}", made_of, make)))
    for name in (
        "probe_year",
        "probe_sidereal",
        "probe_cost_rate",
        "probe_weight_far",
        "probe_plan_cost",
        "probe_guessed",
        "probe_steer",
        "probe_learn",
    ):
        getattr(lib, name).restype = c_double
    return lib


def days(text: str) -> float | None:
    """Days from 2000-01-01T12:00; None where the text is no date."""
    found = c_double()
    return found.value if library().probe_days(text.encode(), byref(found)) else None


def year(of_days: float) -> float:
    return float(library().probe_year(c_double(of_days)))


def sidereal(of_days: float) -> float:
    return float(library().probe_sidereal(c_double(of_days)))


def field_at(
    model: str, of_days: float, degree: int, r_N: Array, t: float = 0.0, error: ArrayLike = (0, 0, 0)
) -> Array:
    """B_N (..., 3) T at r_N (..., 3)."""
    r = np.atleast_2d(r_N)
    room, values = room_for(*r.shape)
    library().probe_field(
        MODELS.index(model) + 1, c_double(of_days), degree, doubles(error), c_double(t), len(r), doubles(r), room
    )
    return np.reshape(values(), np.shape(r_N))


def orbit_at(r: Array, v: Array, dt: float, mu: float = MU) -> tuple[Array, Array]:
    room, values = room_for(2, 3)
    library().probe_orbit(c_double(mu), doubles(r), doubles(v), c_double(dt), room)
    return values()[0], values()[1]


def logs(R: Array) -> Array:
    """(n, 3) of (n, 3, 3)."""
    room, values = room_for(len(R), 3)
    library().probe_log(len(R), doubles(R), room)
    return values()


def lvlh(r: Array, v: Array) -> tuple[Array, Array]:
    """R_d (3, 3) and Omega_d (3,)."""
    (a, R), (b, w) = room_for(3, 3), room_for(3)
    library().probe_target(doubles(r), doubles(v), a, b)
    return R(), w()


def targets_ahead(inputs: list[Array], times: Array) -> tuple[Array, Array]:
    """R_d (n, 3, 3) and Omega_d (n, 3) at `times`, from r, v, R_ref, Omega_ref, dOmega_ref, t_ahead, turn_ahead,
    Omega_ahead at 0."""
    (a, R), (b, w) = room_for(len(times), 3, 3), room_for(len(times), 3)
    given = np.concatenate([np.ravel(value) for value in inputs])
    library().probe_target_ahead(doubles(given), len(times), doubles(times), a, b)
    return R(), w()


def box_qp(H: Array, g: Array, low: Array, high: Array, start: Array, passes: int = 12) -> tuple[Array, Array]:
    """Solutions (n, 4) and which variables are free (n, 4) of n problems."""
    n = len(H)
    u = doubles(start)
    free = (c_ubyte * (4 * n))()
    library().probe_box_qp(n, doubles(H), doubles(g), doubles(low), doubles(high), passes, u, free)
    return np.array(u).reshape(n, 4), np.array(free).reshape(n, 4).astype(bool)


def acceleration(m: Satellite, a: Around, x: Motion, u: ArrayLike) -> Array:
    room, values = room_for(3)
    library().probe_acceleration(m.c(), a.c(), x.c(), doubles(u), room)
    return values()


def advanced(m: Satellite, a: Around, x: Motion, u: ArrayLike, h: float) -> Motion:
    found = FlatMotion()
    library().probe_advanced(m.c(), a.c(), x.c(), doubles(u), c_double(h), byref(found))
    return Motion.of(found)


def linearised(m: Satellite, a: Around, x: Motion, u: ArrayLike, h: float) -> tuple[Array, Array]:
    """A (7, 7), G (7, 4)."""
    (p, A), (q, G) = room_for(7, 7), room_for(7, 4)
    library().probe_linearised(m.c(), a.c(), x.c(), doubles(u), c_double(h), p, q)
    return A(), G()


def cost_rate(m: Satellite, R_d: Array, Omega_d: Array, x: Motion) -> tuple[float, Array]:
    """Cost rate and its gradient (7,)."""
    room, values = room_for(7)
    return float(library().probe_cost_rate(m.c(), doubles(R_d), doubles(Omega_d), x.c(), room)), values()


def weight_far(m: Satellite, stages: int, share: float) -> float:
    """By rods alone, after a plan of so many stages, at a share of the cost from which it is challenged."""
    return float(library().probe_weight_far(m.c(), c_int32(stages), c_double(share)))


def controls_for(m: Satellite, tau: Array, B_B: Array, h_w: float) -> Array:
    room, values = room_for(4)
    library().probe_controls_for(m.c(), doubles(tau), doubles(B_B), c_double(h_w), room)
    return values()


@dataclass(frozen=True)
class Plan:
    """h (n,) s, u (n, 4), its cost, and the motions at the stages' beginnings and at the end."""

    h: Array
    u: Array
    cost: float
    path: list[Motion]


def plan(m: Satellite, a: Ahead, x: Motion, iterations: int, rate: float = 0.0, t: float = 0.0) -> Plan:
    (hs, h), (us, u), cost = room_for(STAGES), room_for(STAGES, 4), c_double()
    path = (FlatMotion * (STAGES + 1))()
    n = library().probe_plan(m.c(), a.c(), x.c(), c_double(t), c_double(rate), iterations, hs, us, byref(cost), path)
    return Plan(h()[:n], u()[:n], cost.value, [Motion.of(path[i]) for i in range(n + 1)])


def feedback(m: Satellite, a: Ahead, x: Motion) -> tuple[Array, Array, list[Motion]]:
    """h (n,) s, the feedback gains (n, 4, 7) about the motion without controls, and that motion."""
    (hs, h), (gains, K) = room_for(STAGES), room_for(STAGES, 4, 7)
    path = (FlatMotion * (STAGES + 1))()
    n = library().probe_gains(m.c(), a.c(), x.c(), hs, gains, path)
    return h()[:n], K()[:n], [Motion.of(path[i]) for i in range(n + 1)]


def plan_cost(m: Satellite, a: Ahead, x: Motion, u: Array, t: float = 0.0) -> float:
    """Of controls u (n, 4) on the stages that a plan without controls has."""
    return float(library().probe_plan_cost(m.c(), a.c(), x.c(), c_double(t), doubles(u)))


def controls_at(t: float, before: Array) -> Array:
    """Controls (4,) at t of the plan of `probe_controls_at`, where those `before` were given last."""
    u = doubles(before)
    library().probe_controls_at(c_double(t), u)
    return np.array(u)


def followed(m: Satellite, expected: Motion, x: Motion) -> tuple[float, float]:
    """Costs from x of the last plan that `plan` made: of its controls alone, and following its motion from
    `expected`."""
    store, costs = room_for(2)
    library().probe_followed(m.c(), expected.c(), x.c(), store)
    alone, following = costs()
    return float(alone), float(following)


def replanned(m: Satellite, a: Ahead, x: Motion, was: Plan, t: float, t_next: float) -> tuple[Array, Array]:
    """Stages h (n,) and controls u (n, 4) of a plan from t that is laid anew from t_next."""
    (hs, h), (us, u) = room_for(STAGES), room_for(STAGES, 4)
    n = library().probe_replanned(
        m.c(), a.c(), x.c(), c_double(t), len(was.h), doubles(was.h), doubles(was.u), c_double(t_next), hs, us
    )
    return h()[:n], u()[:n]


@dataclass(frozen=True)
class Renewed:
    """Stages h (n,) s; how many the plan has behind its usual horizon, negative: lacks; its cost, s; when it settles
    and when the next one is to do so, s; what is left of the account of work."""

    h: Array
    longer: int
    cost: float
    settles: float
    until: float
    left: int


def renewed(
    m: Satellite, a: Ahead, x: Motion, phase: int, longer: int = 0, account: int = WORK_OF_SAMPLE, until: float = 0.0
) -> Renewed:
    """A plan without controls, to reach the target by `until`, s, that is renewed in a phase (2: acquisition, 3: hold);
    without stages where it is not to be flown."""
    (hs, h), found, count, left = room_for(STAGES), doubles([0.0, 0.0, until]), c_int32(longer), c_int32(account)
    n = library().probe_renew(m.c(), a.c(), x.c(), phase, byref(left), byref(count), hs, found)
    return Renewed(h()[:n], count.value, found[0], found[1], found[2], left.value)


def guessed(m: Satellite, a: Ahead, x: Motion, iterations: int) -> float:
    """The cost of a plan after iterations that begin with a motion at the target."""
    return float(library().probe_guessed(m.c(), a.c(), x.c(), iterations))


def strained(m: Satellite, a: Ahead, x: Motion, renewals: int) -> tuple[Array, Array, Array]:
    """A strained hold from a motion: length of each plan, s, wheel momentum, N m s, and attitude error, rad, before it;
    each (n,)."""
    (p, lengths), (q, wheel), (r, angles) = room_for(renewals), room_for(renewals), room_for(renewals)
    library().probe_strained(m.c(), a.c(), x.c(), renewals, p, q, r)
    return lengths(), wheel(), angles()


def profile_change(period: float, t: Array, d: Array, good: Array, ahead: Array) -> Array:
    """By how much the disturbance changes until times ahead (m,), s, from the last of the estimates d (n, 3) at t (n,),
    N m (m, 3)."""
    flags = (c_ubyte * len(t))(*good.astype(int).tolist())
    p, change = room_for(len(ahead), 3)
    times = doubles(t), doubles(d), flags, len(ahead), doubles(ahead)
    library().probe_profile(c_double(period), len(t), *times, p)
    return change()


@dataclass(frozen=True)
class Searched:
    """The controls u (208, 4) of a search and their cost, the calls that it took and the least that they left of their
    account."""

    u: Array
    cost: float
    calls: int
    least: int


def search(m: Satellite, a: Ahead, x: Motion, account: int = WORK_OF_SAMPLE) -> Searched:
    """A search for a plan from t = 0, by calls with an account of work each."""
    (us, u), cost, least = room_for(STAGES, 4), c_double(), c_int32()
    calls = library().probe_search(m.c(), a.c(), x.c(), c_int32(account), byref(least), byref(cost), us)
    return Searched(u(), cost.value, calls, least.value)


def around(a: Ahead, t: float) -> tuple[Around, Array, Array]:
    """What surrounds the satellite, and the target's R_d, Omega_d."""
    found = FlatAround()
    (p, R), (q, w) = room_for(3, 3), room_for(3)
    library().probe_around(a.c(), c_double(t), byref(found), p, q)
    return Around(np.array(found.B_N), np.array(found.r_hat_N), float(found.rate_squared)), R(), w()


def steer(a: Ahead, t: float, D: Array, dipole: float, calls: int = 1) -> tuple[Array, float]:
    """lambda (3,) and the time, s, after a number of calls from nothing."""
    lam = doubles(np.zeros(3))
    time = 0.0
    for _ in range(calls):
        time = float(library().probe_steer(a.c(), c_double(t), doubles(D), c_double(dipole), lam))
    return np.array(lam), time


def steering_rods(lam: Array, time: float, R: Array, B_B: Array, rods: Array) -> Array:
    room, values = room_for(3)
    library().probe_steering_rods(doubles(lam), c_double(time), doubles(R), doubles(B_B), doubles(rods), room)
    return values()


def after_glitch(rate: float, after: int, heavier: float = 1.0, **inputs: Any) -> dict[str, Array]:
    """Outputs of the flight code some samples after one with this rate about x, rad/s; of a body so much heavier."""
    y = record(_BLOCK, "output")()
    J_B = heavier * np.array(load(_BLOCK).variables["J_B"].start, float)
    p, u = filled(_BLOCK, "parameter", J_B=J_B), filled(_BLOCK, "input", **inputs)
    assert library().probe_glitch(byref(p), byref(u), c_double(rate), after, byref(y))
    return {v.name: np.array(getattr(y, v.name)) for v in load(_BLOCK).of("output")}


def _flags(n: int) -> tuple[Any, Any]:
    """A C array of n flags to be written to, and its values."""
    room = (c_ubyte * n)()
    return room, lambda: np.array(room, bool)


def rods_suspected(
    dt: float, T: float, pause: float, effect: float, body: Array, innovations: Array, begun: Array
) -> Array:
    """Whether a rod is suspected at each of n samples, of rates body (n,) and innovations (n, 3) of variance 1; where
    begun (n,) the filter begins anew before it."""
    n, (room, values) = len(body), _flags(len(body))
    flags = (c_ubyte * n)(*np.asarray(begun).astype(int).tolist())
    numbers = [c_double(value) for value in (dt, T, pause, effect)]
    library().probe_watch_rods(*numbers, n, doubles(body), doubles(innovations), flags, room)
    return values()


def attitudes_frozen(dt: float, T: float, noise: float, R: Array, Omega: Array) -> tuple[Array, Array]:
    """Whether each of n attitudes (n, 3, 3) is frozen, at rates (n, 3), and what stands in for them (n, 3, 3)."""
    n = len(R)
    (flags, frozen), (room, turned) = _flags(n), room_for(n, 3, 3)
    numbers = [c_double(value) for value in (dt, T, noise)]
    library().probe_watch_attitude(*numbers, n, doubles(R), doubles(Omega), flags, room)
    return frozen(), turned()


def fields_failed(dt: float, T: float, tolerance: float, b_B: Array, model_B: Array) -> Array:
    """Whether the measured field has failed at each of n samples, (n, 3) each."""
    room, values = _flags(len(b_B))
    numbers = [c_double(value) for value in (dt, T, tolerance)]
    library().probe_watch_field(*numbers, len(b_B), doubles(b_B), doubles(model_B), room)
    return values()


def momenta_frozen(dt: float, h_w: Array, given: Array) -> tuple[Array, Array, Array]:
    """Whether the measured momentum, at most 0.03 N m s, is frozen, and blind, at each of n samples (n,), and what
    stands in for it."""
    n, l = len(h_w), (c_double * len(h_w))()  # noqa: E741
    (a, frozen), (b, blind) = _flags(n), _flags(n)
    library().probe_watch_momentum(c_double(dt), c_double(0.03), n, doubles(h_w), doubles(given), a, b, l)
    return frozen(), blind(), np.array(l)


def wheel_failed(dt: float, T: float, torque: Array, h_w: Array, h_w_next: Array) -> tuple[Array, Array]:
    """Whether the default wheel has failed, and is stuck, at each of n samples (n,)."""
    n, p = len(torque), filled(_BLOCK, "parameter")
    (a, failed), (b, stuck) = _flags(n), _flags(n)
    given = doubles(torque), doubles(h_w), doubles(h_w_next)
    library().probe_watch_wheel(byref(p), c_double(dt), c_double(T), n, *given, a, b)
    return failed(), stuck()


def friction(dt: float, T: float, torque: Array, h_w: Array, h_w_next: Array) -> Array:
    """Coulomb friction, N m, and viscous friction, 1/s, as the default wheel's are known after each of n samples
    (n, 2)."""
    n, p, (room, values) = len(torque), filled(_BLOCK, "parameter"), room_for(len(torque), 2)
    given = doubles(torque), doubles(h_w), doubles(h_w_next)
    library().probe_friction(byref(p), c_double(dt), c_double(T), n, *given, room)
    return values()


def wheel_rates(dt: float, T: float, torque: Array, h_w: Array, h_w_next: Array) -> Array:
    """N m (n,), at which the momentum of the default wheel, without friction, is taken to change after each of n
    samples."""
    n, p, (room, values) = len(torque), filled(_BLOCK, "parameter"), room_for(len(torque))
    given = doubles(torque), doubles(h_w), doubles(h_w_next)
    library().probe_wheel_rate(byref(p), c_double(dt), c_double(T), n, *given, room)
    return values()


def propagated(m: Satellite, a: Around, x: Motion, u: ArrayLike, dt: float, P: Array) -> Array:
    """The filter's covariance (24, 24) after a sample, without noise of the model."""
    after = doubles(P)
    library().probe_propagate(m.c(), a.c(), x.c(), doubles(u), c_double(dt), after)
    return np.array(after).reshape(24, 24)


def corrected(
    variance: ArrayLike, excess: ArrayLike, sigma: ArrayLike, innovation: Array, P: Array
) -> tuple[Array, Array, Array]:
    """Covariance (24, 24), change of the unknowns (18,) and gain (6, 6) of a measurement with innovations (6,);
    `sigma` (3,) is that of an estimated attitude, or 0."""
    after, (p, unknowns), (k, gain) = doubles(P), room_for(18), room_for(6, 6)
    library().probe_correct(doubles(variance), doubles(excess), doubles(sigma), doubles(innovation), after, p, k)
    return np.array(after).reshape(24, 24), unknowns(), gain()


def filter_start(**parameters: Any) -> tuple[Array, Array, Array]:
    """The filter's covariance (24, 24) before the flight, and once rods are suspected; and its noises: (sigma T)^2
    of the rate at rest, of the bias, rad2/s3, and of the disturbance over the one with which it is forgotten."""
    p, u = filled(_BLOCK, "parameter", **parameters), filled(_BLOCK, "input")
    (a, before), (b, suspected), (c, noise) = room_for(24, 24), room_for(24, 24), room_for(3)
    library().probe_start(byref(p), byref(u), a, b, c)
    return before(), suspected(), noise()


@dataclass(frozen=True)
class Learned:
    """What the filter has after each sample: excess (n, 3) of attitude, rate and model, mean cosine (n, 2) of
    attitude and rate, evidence (n,), samples rejected in turn (n,), gain (n,) of the rate about x; and T, s."""

    excess: Array
    alike: Array
    evidence: Array
    rejected: Array
    gain: Array
    T: float


def learned(dt: float, turn: Array, rate: Array, nominal: Array, **parameters: Any) -> Learned:
    """Of innovations (n, 3) each, from the start on, of the default satellite."""
    p, u = filled(_BLOCK, "parameter", **parameters), filled(_BLOCK, "input")
    room, values = room_for(len(turn), 8)
    given = doubles(turn), doubles(rate), doubles(nominal)
    T = float(library().probe_learn(byref(p), byref(u), c_double(dt), len(turn), *given, room))
    found = values()
    return Learned(found[:, :3], found[:, 3:5], found[:, 5], found[:, 6], found[:, 7], T)


def sizes() -> tuple[int, int]:
    """Bytes of the state and of the law with its workspace."""
    found = (c_size_t * 2)()
    library().probe_sizes(found)
    return found[0], found[1]


def doubted(bound: Array, rate: Array, wanted: Array, holds: Array, lost: Array) -> tuple[Array, Array, float]:
    """Whether the attitude is doubted, and drives, at each of n samples (n,) each; and T, s."""
    p, n = filled(_BLOCK, "parameter"), len(bound)
    given, found = np.column_stack((bound, rate, wanted)), (c_ubyte * (2 * n))()
    flags = (c_ubyte * (2 * n))(*np.column_stack((holds, lost)).astype(int).ravel().tolist())
    lib = library()
    lib.probe_doubt.restype = c_double
    T = float(lib.probe_doubt(byref(p), n, doubles(given), flags, found))
    values = np.array(found, bool).reshape(n, 2)
    return values[:, 0], values[:, 1], T


@dataclass(frozen=True)
class Held:
    """Of a hold at each sample (n,): whether it has settled, is turned away and is strained."""

    settled: Array
    away: Array
    strained: Array


def held(dt: float, angle: Array, rate: Array, torque: Array, loaded: Array) -> Held:
    """Of n samples of a hold that is loaded or not, with this error, rad, rate, rad/s, and disturbance, N m."""
    p, n = filled(_BLOCK, "parameter"), len(angle)
    given, found = np.column_stack((angle, rate, torque)), (c_ubyte * (3 * n))()
    flags = (c_ubyte * n)(*np.asarray(loaded).astype(int).tolist())
    library().probe_hold(byref(p), c_double(dt), n, doubles(given), flags, found, (c_double * 3)())
    return Held(*np.array(found, bool).reshape(n, 3).T)


def hold_scales() -> tuple[float, float, float]:
    """T and the period of the orbit, s, and the largest disturbance, N m, of the default satellite."""
    p, found = filled(_BLOCK, "parameter"), (c_double * 3)()
    library().probe_hold(byref(p), c_double(1.0), 0, doubles([]), (c_ubyte * 0)(), (c_ubyte * 0)(), found)
    return found[0], found[1], found[2]


def changed_phase(from_: int, *events: int) -> int:
    """The phase to which events lead; negative where a plan or a steering is due."""
    return int(library().probe_change(byref(filled(_BLOCK, "parameter")), from_, sum(events)))


def standing(m: Satellite, a: Ahead, x: Motion, phase: int) -> tuple[float, float, bool, bool, bool]:
    """Error, rad, and rate, rad/s, of a motion from the target, and whether it is lost, near and loaded."""
    room, values = room_for(5)
    library().probe_standing(m.c(), a.c(), x.c(), phase, room)
    angle, rate, lost, near, loaded = values()
    return angle, rate, bool(lost), bool(near), bool(loaded)


def failed_rod(
    gains: ArrayLike, sigma: ArrayLike, dipole: ArrayLike, sigma_dipole: float, wide: bool = True, **parameters: Any
) -> tuple[int, bool]:
    """The rod, 1 to 3, that has failed, 0: none, and whether one is stuck on, of gains and a dipole that are known so
    well; `wide`: a rod is suspected."""
    p, u = filled(_BLOCK, "parameter", **parameters), filled(_BLOCK, "input")
    given = doubles(gains), doubles(sigma), doubles(dipole), c_double(sigma_dipole), int(wide)
    found = int(library().probe_failed_rod(byref(p), byref(u), *given))
    return found % 10, found >= 10


def commanded(**changes: Any) -> Array:
    """The controls (4,) at 0 on a plan that gives the first rod 0.1 more of its dipole every 0.1 s from then on."""
    p, u, (room, values) = filled(_BLOCK, "parameter", **changes), filled(_BLOCK, "input"), room_for(4)
    assert library().probe_commanded(byref(p), byref(u), room)
    return values()


def foreseen(torque: Array) -> tuple[float, float]:
    """How long after now, s, a search begins that is started in an acquisition, whose plan has these wheel torques in
    turn, N m, a control period each; and how much more momentum the wheel has then, N m s."""
    p, u, momentum, lib = filled(_BLOCK, "parameter"), filled(_BLOCK, "input"), c_double(), library()
    lib.probe_foreseen.restype = c_double
    return lib.probe_foreseen(byref(p), byref(u), len(torque), doubles(torque), byref(momentum)), momentum.value
