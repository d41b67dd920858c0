"""The reaction wheel: closed forms over a step, its limits, friction, and steps split where its law changes."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import plant
from evidence.verification.rk4 import angle_between, environment, pack, truth
from plant.attitude import lgvi_step
from plant.wheel import Part, Segment, Wheel, net_torque, parts
from tests.plant.motion import FULL_INERTIA, checked, command, fly, measured_order

I_W, MAX = 1.47e-5, 0.03
IDEAL = Wheel(I_W, MAX, 0.003)


def segments(momentum: float, command: float, h: float, wheel: Wheel) -> list[Segment]:
    """Those of one wheel."""
    return [part.segments[0] for part in parts([momentum], [command], h, [wheel])]


def test_a_wheel_driven_into_its_limit_inside_a_step_stops_there_and_so_does_the_torque_on_the_body():
    """25 + 3 t = 30 mN m s at 5/3 s of a 4 s step; about a principal axis the body takes exactly the 5 mN m s."""
    p = checked(gravity_gradient=False, h_w0=0.025, omega_B0=[0.01, 0.0, 0.0], integrator_order=6, step_max=4.0)
    u = command(wheel_torque_cmd=0.003)
    x, y = plant.step(plant.start(p, u), u, p, 4.0)
    assert x.l_w[0] == 0.03
    assert y.omega_B[0] == pytest.approx(0.01 - 0.005 / 2.13, rel=1e-14)
    assert y.wheel_torque == 0.0
    assert y.wheel_momentum_saturated
    assert not y.wheel_torque_saturated
    # the angle: the torque acts for 5/3 s, then the rate is constant
    angle = 0.01 * 4.0 - 0.5 * 0.003 / 2.13 * (5 / 3) ** 2 - 0.005 / 2.13 * (4.0 - 5 / 3)
    turned = p.R_NB0.T @ x.R
    assert math.atan2(turned[2, 1], turned[1, 1]) == pytest.approx(angle, abs=1e-11)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_wheel_leaves_its_limit_as_soon_as_it_is_told_to(sign):
    found = segments(sign * MAX, -sign * 0.002, 1.0, IDEAL)
    assert [part.l_end for part in found] == [pytest.approx(sign * (MAX - 0.002))]
    assert net_torque(sign * MAX, -sign * 0.002, IDEAL) == -sign * 0.002
    assert net_torque(sign * MAX, sign * 0.002, IDEAL) == 0.0


def test_a_step_with_an_event_has_parts_that_join_and_fill_it():
    wheel = Wheel(I_W, MAX, 0.003, 1e-6, 2e-4)
    for start in (-0.03, -0.01, -1e-4, 0.0, 1e-4, 0.02, 0.03):
        for torque in (-0.004, -1e-3, -1e-4, 0.0, 1e-4, 1e-3, 0.004):
            found = segments(start, torque, 40.0, wheel)
            assert sum(part.duration for part in found) == pytest.approx(40.0, rel=1e-15)
            assert [part.l_start for part in found] == [start, *(part.l_end for part in found[:-1])]
            for part in found:
                assert part.momentum(part.duration) == pytest.approx(part.l_end, abs=1e-15)
                assert abs(part.l_end) <= MAX


@pytest.mark.parametrize("viscous", [0.0, 1.47e-8, 1.47e-6, 3e-5])
@pytest.mark.parametrize("coulomb", [0.0, 4e-4])
@pytest.mark.parametrize(
    ("start", "torque"), [(0.02, -1.2e-3), (-0.02, -3e-4), (0.004, 0.0), (0.0, 1e-3), (0.0, -3e-4), (0.029, 3e-3)]
)
def test_momentum_under_friction_and_limit_is_what_solve_ivp_gives(viscous, coulomb, start, torque):
    wheel = Wheel(I_W, MAX, 0.003, viscous, coulomb)
    found = start
    for part in segments(start, torque, 20.0, wheel):
        found = part.momentum(part.duration)
    assert found == pytest.approx(_by_solve_ivp(start, torque, 20.0, viscous, coulomb), abs=2e-9)


def _by_solve_ivp(start, torque, duration, viscous, coulomb):
    """The law with its events left to SciPy's root finder, restarted after each."""
    t, l_w = 0.0, start
    while True:
        if l_w == 0.0 and abs(torque) <= coulomb:
            return 0.0
        side = math.copysign(1.0, l_w if l_w != 0.0 else torque)

        def law(t, y, side=side):
            return [torque - viscous / I_W * y[0] - coulomb * side]

        if abs(l_w) >= MAX and law(0.0, [l_w])[0] * l_w >= 0.0:
            return l_w

        def standstill(t, y, armed=l_w != 0.0 and coulomb > 0.0):
            return y[0] if armed else 1.0

        def limit(t, y):
            return MAX - abs(y[0])

        standstill.terminal = limit.terminal = True  # type: ignore[attr-defined]
        limit.direction = -1.0  # type: ignore[attr-defined]
        s = solve_ivp(law, (t, duration), [l_w], method="DOP853", rtol=1e-11, atol=1e-14, events=[standstill, limit])
        if s.status == 0:
            return s.y[0, -1]
        t, l_w = s.t[-1], 0.0 if s.t_events[0].size else math.copysign(MAX, s.y[0, -1])


def test_a_wheel_runs_down_against_viscous_friction_as_an_exponential():
    p = checked(h_w0=0.02, wheel_viscous_friction=1.47e-6, gravity_gradient=False, step_max=50.0)
    x = fly(p, command(), 10.0, 3)[-1]
    assert x.l_w[0] == pytest.approx(0.02 * math.exp(-0.1 * 30.0), rel=1e-13)


def test_a_wheel_runs_down_against_coulomb_friction_in_a_straight_line_and_stays_at_rest():
    p = checked(h_w0=0.02, wheel_coulomb_friction=1e-3, gravity_gradient=False, step_max=50.0)
    states = fly(p, command(), 8.0, 4)
    assert [x.l_w[0] for x in states] == pytest.approx([0.02, 0.012, 0.004, 0.0, 0.0], abs=1e-16)
    # a motor torque below the friction does not move it, one above does with what is left
    stuck = fly(p, command(wheel_torque_cmd=-9e-4), 8.0, 1, states[-1])[-1]
    assert stuck.l_w == 0.0
    moved = fly(p, command(wheel_torque_cmd=-1.5e-3), 8.0, 1, states[-1])[-1]
    assert moved.l_w == pytest.approx(-0.5e-3 * 8.0, rel=1e-14)


def test_the_final_speed_under_viscous_friction_is_motor_torque_over_the_coefficient():
    p = checked(wheel_viscous_friction=2e-6, gravity_gradient=False, step_max=100.0)
    y = plant.step(plant.start(p, command()), command(wheel_torque_cmd=2e-3), p, 2000.0)[1]
    assert y.wheel_speed == pytest.approx(2e-3 / 2e-6, rel=1e-12)
    assert y.wheel_torque == pytest.approx(0.0, abs=1e-15)


def test_a_torque_beyond_the_motors_is_clipped_and_flagged():
    p = checked(gravity_gradient=False)
    for torque in (0.0031, -5.0):
        u = command(wheel_torque_cmd=torque)
        x, y = plant.step(plant.start(p, u), u, p, 1.0)
        assert x.l_w[0] == pytest.approx(math.copysign(0.003, torque), rel=1e-14)
        assert y.wheel_torque == math.copysign(0.003, torque)
        assert y.wheel_torque_saturated
    assert not plant.outputs(plant.start(p, command()), command(wheel_torque_cmd=0.003), p).wheel_torque_saturated


def test_momentum_saturation_is_flagged_only_where_the_demand_drives_it_further():
    p = checked(h_w0=-0.03)
    x = plant.start(p, command())
    flags = [
        plant.outputs(x, command(wheel_torque_cmd=torque), p).wheel_momentum_saturated for torque in (-1e-3, 0.0, 1e-3)
    ]
    assert flags == [True, False, False]


def test_friction_at_the_limit_slows_the_wheel_and_nothing_is_flagged():
    p = checked(h_w0=0.03, wheel_coulomb_friction=1e-3)
    u = command(wheel_torque_cmd=4e-4)
    y = plant.outputs(plant.start(p, u), u, p)
    assert y.wheel_torque == pytest.approx(-6e-4)
    assert not y.wheel_momentum_saturated


def test_a_wheel_without_any_momentum_takes_none():
    p = checked(wheel_momentum_max=0.0)
    u = command(wheel_torque_cmd=1e-3)
    x, y = plant.step(plant.start(p, u), u, p, 1.0)
    assert x.l_w[0] == 0.0
    assert y.wheel_torque == 0.0
    assert y.wheel_momentum_saturated


@pytest.mark.parametrize("decay", [0.0, 1e-9, 1e-3, 0.049, 0.051, 0.5, 3.0, -0.5])
@pytest.mark.parametrize("duration", [1.0, -1.0, 0.3])
def test_the_mean_momentum_of_a_part_is_its_integral_over_its_length(decay, duration):
    part = Segment(1.0, 0.02, 0.0, 1e-3, decay)
    closed = lambda s: 0.02 * math.exp(-decay * s) + (1e-3 * -math.expm1(-decay * s) / decay if decay else 1e-3 * s)  # noqa: E731
    assert part.momentum(0.7) == pytest.approx(closed(0.7), rel=1e-14)
    nodes, weights = np.polynomial.legendre.leggauss(30)
    by_quadrature = 0.5 * sum(w * closed(0.2 + duration * 0.5 * (x + 1.0)) for x, w in zip(nodes, weights, strict=True))
    assert part.mean(0.2, duration) == pytest.approx(by_quadrature, rel=1e-13)


@pytest.mark.parametrize("order", [2, 4, 6])
def test_each_substep_is_told_the_wheels_mean_and_end_momentum(order, monkeypatch):
    """l_w = 0.01 + 1e-3 t: the mean over a substep is that at its middle."""
    told = []
    monkeypatch.setattr("plant.block.lgvi_step", lambda *a: told.append(a[5:]) or lgvi_step(*a))
    p = checked(h_w0=0.01, integrator_order=order, step_max=2.0)
    plant.step(plant.start(p, command()), command(wheel_torque_cmd=1e-3), p, 2.0)
    assert len(told) == {2: 1, 4: 5, 6: 7}[order]
    for t, h, mean, end in told:
        assert mean == pytest.approx([0.01 + 1e-3 * (t + 0.5 * h), 0.0, 0.0], abs=1e-16)
        assert end == pytest.approx([0.01 + 1e-3 * (t + h), 0.0, 0.0], abs=1e-16)


class Case:
    """A step of 8 s in which the wheel's law changes at `event`, s: what the integrator makes of it, against DOP853."""

    after: Any
    """The law from the last event on."""
    duration = 8.0
    dipole = (400.0, -300.0, 200.0)

    def __init__(self, h_w0, torque, events, viscous=0.0, coulomb=0.0):
        self.torque, self.events, self.viscous, self.coulomb = torque, events, viscous, coulomb
        self.start = {
            "J_B": FULL_INERTIA,
            "omega_B0": [0.08, -0.1, 0.07],
            "h_w0": h_w0,
            "dipole_max": 500.0,
            "wheel_viscous_friction": viscous,
            "wheel_coulomb_friction": coulomb,
        }

    def errors(self, order, steps):
        found = {}
        u = command(self.dipole, self.torque)
        y = self.truth()
        for step in steps:
            p = checked(**self.start, integrator_order=order, step_max=step)
            x, _ = plant.step(plant.start(p, u), u, p, self.duration)
            assert x.l_w[0] == pytest.approx(y[12], abs=4e-3)
            found[step] = angle_between(x.R, y[:9].reshape(3, 3)) + np.abs(x.Omega(p) - y[9:12]).max()
        return found

    def truth(self):
        p = checked(**self.start)
        moment = environment(p, p.rods_to_body @ np.array(self.dipole))
        y, t = pack(p.R_NB0, p.omega_B0, p.h_w0), 0.0
        for until, law in [*self.events, (self.duration, self.events[-1][1] if not self.events else self.after)]:
            y = truth(y, t, until, p.J_B, moment, law)
            t = until
        return y


def limit_case():
    case = Case(0.025, 0.003, [(0.005 / 0.003, lambda l_w: 0.003)])
    case.after = lambda l_w: 0.0
    return case


def standstill_case():
    case = Case(0.004, -1e-3, [(0.004 / 1.2e-3, lambda l_w: -1.2e-3)], coulomb=2e-4)
    case.after = lambda l_w: -0.8e-3
    return case


def viscous_case():
    case = Case(0.02, -2e-3, [(4.0, lambda l_w: -2e-3 - 0.1 * l_w)], viscous=1.47e-6)
    case.after = lambda l_w: -2e-3 - 0.1 * l_w
    return case


CASES = {"limit": limit_case, "standstill": standstill_case, "viscous": viscous_case}


@pytest.mark.parametrize("order", [2, 4, 6])
@pytest.mark.parametrize("case", CASES)
def test_the_order_is_kept_where_the_wheel_clips_stands_still_or_is_braked(case, order):
    """The event falls inside a step, at a place that differs from step to step, so the slope is taken end to end."""
    errors = CASES[case]().errors(
        order, {2: (1.0, 0.5, 0.25, 0.125), 4: (2.0, 1.0, 0.5, 0.25), 6: (2.0, 1.0, 0.5)}[order]
    )
    assert measured_order(errors) > order - 0.35
    assert min(errors.values()) < {2: 2e-4, 4: 5e-8, 6: 2e-8}[order]


def unsplit(momenta, commands, h, wheels):
    """A double of `parts` that does not divide the step: it takes the law at the start for all of it."""
    (momentum,), (command,), (wheel,) = momenta, commands, wheels
    rate = net_torque(momentum, command, wheel)
    decay = wheel.viscous_friction / wheel.inertia
    whole = Segment(h, momentum, 0.0, rate + decay * momentum, decay)
    return [Part(h, (Segment(h, momentum, whole.momentum(h), whole.drive, decay),))]


@pytest.mark.parametrize("case", ["limit", "standstill"])
def test_without_splitting_the_step_order_4_falls_to_1(case, monkeypatch):
    monkeypatch.setattr("plant.block.parts", unsplit)
    errors = CASES[case]().errors(4, (1.0, 0.5, 0.25, 0.125, 0.0625))
    assert measured_order(errors) < 1.5
    assert min(errors.values()) > 1e-5


def test_an_unsplit_step_is_as_good_where_the_law_does_not_change(monkeypatch):
    """So the loss above is the splitting's, not the double's."""
    split = viscous_case().errors(4, (1.0,))
    monkeypatch.setattr("plant.block.parts", unsplit)
    assert viscous_case().errors(4, (1.0,)) == pytest.approx(split, rel=1e-6)


@pytest.mark.parametrize("decay", [0.3, 30.0])
def test_the_mean_under_strong_friction_keeps_its_digits_on_substeps_that_go_back(decay):
    # Suzuki's third substep of a long step: from 0.83 of it back to 0.17. Witness: the integral in sixty decimal
    # digits.
    part = Segment(1.7, 0.01, 0.0, 2e-4, decay)
    with localcontext() as context:
        context.prec = 60
        a, b, l0, drive, k = (Decimal(v) for v in (1.41, 0.29, 0.01, 2e-4, decay))
        limit = drive / k
        integral = limit * (b - a) - (l0 - limit) / k * ((-k * b).exp() - (-k * a).exp())
        expected = float(integral / (b - a))
    assert part.mean(1.41, 0.29 - 1.41) == pytest.approx(expected, rel=1e-11)
