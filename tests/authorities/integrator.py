"""The integrator's order and accuracy under forcing, against SciPy's DOP853 on the paper's equations in the body
rate."""

from __future__ import annotations

from functools import cache

from evidence.verification.rk4 import angle_between, environment, pack, truth
from tests.authorities.registry import authority
from tests.plant import manoeuvre
from tests.plant.motion import checked, command, fly, measured_order

DOP853 = "scipy.integrate.solve_ivp, DOP853 at 3e-14, on [1], [2], [14]"
FORCING = (
    "gravity gradient, rods in the moving field, wheel spinning up and down, full inertia, commands of a fixed period"
)


@cache
def order(asked: int) -> float:
    return measured_order(manoeuvre.errors(asked))


@authority("Integrator", f"Measured order where 2 is asked: {FORCING}", source=DOP853, expected=2.0, tolerance=0.06)
def order_2() -> float:
    return order(2)


@authority(
    "Integrator", "Measured order where 4 is asked (Suzuki), same forcing", source=DOP853, expected=4.0, tolerance=0.06
)
def order_4() -> float:
    return order(4)


@authority(
    "Integrator", "Measured order where 6 is asked (Yoshida), same forcing", source=DOP853, expected=6.0, tolerance=0.06
)
def order_6() -> float:
    return order(6)


@cache
def paper_run(asked: int) -> float:
    """rad: the paper's satellite tumbling as in V.B for 386 s at 0.1 s, rods at half their range, wheel driven."""
    p = checked(omega_B0=[0.0400, -0.0789, 0.0400], integrator_order=asked)
    u = command([12.5, -12.5, 12.5], 5e-5)
    x = fly(p, u, 0.1, 3860)[-1]
    moment = environment(p, p.rods_to_body @ u.dipole_cmd)
    y = truth(pack(p.R_NB0, p.omega_B0, 0.0), 0.0, 386.0, p.J_B, moment, lambda l_w: 5e-5)
    return angle_between(x.R, y[:9].reshape(3, 3))


@authority(
    "Integrator",
    "Attitude of the plant block after 386 s of V.B's tumble under rods and wheel, order 2, 0.1 s",
    source=DOP853,
    unit="rad",
    tolerance=3e-3,
)
def paper_run_2() -> float:
    return paper_run(2)


@authority("Integrator", "The same run, order 4", source=DOP853, unit="rad", tolerance=2e-8)
def paper_run_4() -> float:
    return paper_run(4)


@authority("Integrator", "The same run, order 6", source=DOP853, unit="rad", tolerance=1e-10)
def paper_run_6() -> float:
    return paper_run(6)
