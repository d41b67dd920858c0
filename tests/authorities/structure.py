"""What must be conserved, because mechanics says so: no numbers from outside are needed."""

from __future__ import annotations

from functools import cache

import numpy as np

from tests.authorities.registry import authority
from tests.plant.motion import FULL_INERTIA, checked, command, fly

NOETHER = "conservation law of [13] without external moments"


@authority(
    "Structure",
    "Drift of the inertial momentum over 20,000 steps of 0.1 s, order 2, while the wheel spins up and down, relative",
    source=NOETHER,
    tolerance=3e-14,
)
@cache
def momentum_over_20000_steps() -> float:
    p = checked(J_B=FULL_INERTIA, gravity_gradient=False, omega_B0=[0.06, -0.08, 0.05], integrator_order=2)
    x, worst = None, 0.0
    H0 = p.R_NB0 @ (FULL_INERTIA @ p.omega_B0)
    for torque in (1.4e-5, -2.8e-5, 3e-3, 2e-5):  # the third runs the wheel into its limit
        states = fly(p, command(wheel_torque_cmd=torque), 0.1, 5000, x)
        x = states[-1]
        worst = max(worst, *(float(np.abs(s.R @ s.Pi - H0).max()) for s in states[::50]))
    return worst / float(np.linalg.norm(H0))


def _tumble_on_orbit(order: int, orbits: float, step: float):
    p = checked(J_B=FULL_INERTIA, omega_B0=[0.02, -0.03, 0.02], h_w0=0.02, integrator_order=order, step_max=step)
    return p, round(orbits * 2.0 * np.pi / p.orbit.mean_motion / step)


@cache
def energy_over_an_orbit(order: int, step: float = 2.0) -> float:
    """Largest change of the conserved energy over an orbit, relative to the kinetic energy."""
    import plant

    p, n = _tumble_on_orbit(order, 1.0, step)
    u = command()
    x = plant.start(p, u)
    energy = [plant.outputs(x, u, p).energy]
    for _ in range(n):
        x, y = plant.step(x, u, p, step)
        energy.append(y.energy)
    T0 = 0.5 * float(p.omega_B0 @ FULL_INERTIA @ p.omega_B0)
    return float(np.abs(np.array(energy) - energy[0]).max()) / T0


CIRCULAR = "Jacobi integral of the attitude on a circular orbit (Hughes, Spacecraft Attitude Dynamics, 8.1)"


@authority(
    "Structure",
    "Conserved energy over an orbit with gravity gradient and a spinning wheel, order 2, 2 s: bounded error, relative",
    source=CIRCULAR,
    tolerance=1e-3,
)
def energy_order_2() -> float:
    return energy_over_an_orbit(2)


@authority("Structure", "The same, order 4, 2 s", source=CIRCULAR, tolerance=3e-7)
def energy_order_4() -> float:
    return energy_over_an_orbit(4)


@authority("Structure", "The same, order 6, 2 s", source=CIRCULAR, tolerance=3e-8)
def energy_order_6() -> float:
    return energy_over_an_orbit(6)


@authority(
    "Structure",
    "Largest element of R^T R - I after ten tumbling orbits, order 2, 1 s, never reprojected",
    source="definition of SO(3)",
    tolerance=1e-12,
)
@cache
def orthogonality_over_ten_orbits() -> float:
    from tests.plant.motion import bare

    J, Omega, worst = FULL_INERTIA, np.array([0.04, -0.0789, 0.04]), []
    bare(2, 1.0, 57910, np.eye(3), Omega, J, seen=lambda R, Pi: worst.append(R))
    return float(max(np.abs(R.T @ R - np.eye(3)).max() for R in worst[::100]))
