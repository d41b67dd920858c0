"""Basilisk's spacecraft under its gravity-gradient effector. Optional: needs bsk."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from evidence.verification.rk4 import angle_between
from tests.authorities.registry import authority
from tests.plant.motion import FULL_INERTIA, checked, command, fly

MU, PERIOD = 3.986004418e14, 5792.0


def by_basilisk(
    R0, omega, r, v, duration: float, step: float, gravity_gradient: bool, more: Callable[..., Any] | None = None
) -> np.ndarray:
    """R after `duration`, s, by Basilisk's eighth-order integrator at a step, s; `more` adds to the spacecraft what it
    is given with the simulation."""
    from Basilisk.simulation import GravityGradientEffector, spacecraft, svIntegrators
    from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros, simIncludeGravBody

    simulation = SimulationBaseClass.SimBaseClass()
    process = simulation.CreateNewProcess("dynamics")
    process.addTask(simulation.CreateNewTask("step", macros.sec2nano(step)))
    body = spacecraft.Spacecraft()
    body.hub.mHub = 50.0
    body.hub.IHubPntBc_B = FULL_INERTIA.tolist()
    body.hub.r_CN_NInit = r.tolist()
    body.hub.v_CN_NInit = v.tolist()
    body.hub.sigma_BNInit = RigidBodyKinematics.C2MRP(R0.T).tolist()
    body.hub.omega_BN_BInit = omega.tolist()
    simulation.AddModelToTask("step", body)
    integrator = svIntegrators.svIntegratorRKF78(body)
    body.setIntegrator(integrator)
    gravity = simIncludeGravBody.gravBodyFactory()
    earth = gravity.createEarth()
    earth.mu = MU
    earth.isCentralBody = True
    gravity.addBodiesTo(body)
    if gravity_gradient:
        effector = GravityGradientEffector.GravityGradientEffector()
        effector.ModelTag = "gravity gradient"
        effector.addPlanetName(earth.planetName)
        body.addDynamicEffector(effector)
        simulation.AddModelToTask("step", effector)
    kept = None if more is None else more(simulation, body)  # C++ points to it
    log = body.scStateOutMsg.recorder(macros.sec2nano(duration))
    simulation.AddModelToTask("step", log)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(duration))
    simulation.ExecuteSimulation()
    assert log.times()[-1] == macros.sec2nano(duration)
    del kept
    return RigidBodyKinematics.MRP2C(np.array(log.sigma_BN[-1])).T


@cache
def difference(gravity_gradient: bool) -> float:
    omega = np.array([0.02, -0.03, 0.02])
    R0 = Rotation.random(random_state=12).as_matrix()
    p = checked(
        J_B=FULL_INERTIA,
        gravity_gradient=gravity_gradient,
        initial_attitude="q_NB0",
        q_NB0=np.roll(Rotation.from_matrix(R0).as_quat(), 1),
        omega_B0=omega,
        integrator_order=6,
        step_max=0.1,
    )
    theirs = by_basilisk(R0, omega, *p.orbit.position_velocity(0.0), PERIOD, 0.5, gravity_gradient)  # type: ignore[call-arg]
    return angle_between(fly(p, command(), PERIOD / 10.0, 10)[-1].R, theirs)


@authority(
    "Gravity gradient",
    "Attitude of the plant block against Basilisk's after one tumbling orbit of 5792 s, order 6, 0.1 s, inertia "
    "with products",
    source="Basilisk, spacecraft and GravityGradientEffector, svIntegratorRKF78",
    unit="rad",
    tolerance=1e-8,
    needs="bsk:Basilisk",
)
def basilisk_gravity_gradient() -> float:
    assert difference_made_by_gravity() > 1e-2, "the gravity gradient must matter for the comparison to say anything"
    return difference(True)


def difference_made_by_gravity() -> float:
    """rad: how far the same orbit without gravity gradient ends from the one with it, both by Basilisk."""
    omega = np.array([0.02, -0.03, 0.02])
    p = checked(J_B=FULL_INERTIA)
    start = (Rotation.random(random_state=12).as_matrix(), omega, *p.orbit.position_velocity(0.0), PERIOD, 0.5)
    return angle_between(by_basilisk(*start, True), by_basilisk(*start, False))  # type: ignore[call-arg]


@authority(
    "Torque-free",
    "Attitude of the plant block against Basilisk's after 5792 s without moments, order 6, 0.1 s, inertia with "
    "products",
    source="Basilisk, spacecraft, svIntegratorRKF78",
    unit="rad",
    tolerance=1e-8,
    needs="bsk:Basilisk",
)
def basilisk_torque_free() -> float:
    return difference(False)
