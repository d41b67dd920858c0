"""Basilisk's reaction wheels beside those of `plant_wheels`: four in a pyramid. Optional: needs bsk.

Its motor acts on a wheel's momentum in N, ours on that relative to the body; they are the same where the wheel's
inertia is small beside its momentum over the body's rate. So the wheels here are light and quick.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from evidence.verification.rk4 import angle_between
from tests.authorities.basilisk import by_basilisk
from tests.authorities.registry import authority
from tests.blocks import PYRAMID
from tests.native.driver import running
from tests.plant.motion import FULL_INERTIA, checked

PERIOD, LIGHT = 5792.0, 1e-11
MOMENTA, TORQUES = np.array([0.012, -0.008, 0.004, -0.015]), np.array([2e-6, -1e-6, 1.5e-6, 1.5e-6])
OMEGA = np.array([0.02, -0.03, 0.02])
R0 = Rotation.random(random_state=12).as_matrix()


def difference(duration: float, step: float, inertia: float, start: dict[str, Any], theirs: dict[str, Any]) -> float:
    """rad, between both after `duration`, s: ours in steps of a thousandth of it, theirs in steps of `step`, s."""
    orbit = checked(J_B=FULL_INERTIA).orbit.position_velocity(0.0)

    def wheels(simulation: Any, body: Any) -> Any:
        from Basilisk.architecture import messaging
        from Basilisk.simulation import reactionWheelStateEffector
        from Basilisk.utilities import simIncludeRW

        factory, effector = simIncludeRW.rwFactory(), reactionWheelStateEffector.ReactionWheelStateEffector()
        for axis, momentum in zip(PYRAMID, MOMENTA, strict=True):
            wheel = factory.create("custom", axis.tolist(), Js=inertia, useMaxTorque=False)
            wheel.Omega, wheel.Omega_max = momentum / inertia, -1.0
            wheel.fCoulomb = wheel.cViscous = 0.0
            for name, value in theirs.items():
                setattr(wheel, name, value)
        factory.addToSpacecraft("wheels", effector, body)
        torque = messaging.ArrayMotorTorqueMsgPayload(motorTorque=TORQUES.tolist())
        message = messaging.ArrayMotorTorqueMsg().write(torque)
        effector.rwMotorCmdInMsg.subscribeTo(message)
        simulation.AddModelToTask("step", effector)
        return factory, effector, message

    own = {
        "J_B": FULL_INERTIA,
        "drag": False,
        "wheels": 4,
        "wheel_axis": PYRAMID,
        "wheel_inertia": [inertia] * 4,
        "wheel_momentum_max": [0.1] * 4,
        "h_w0": MOMENTA,
        "initial_attitude": "q_NB0",
        "q_NB0": np.roll(Rotation.from_matrix(R0).as_quat(), 1),
        "omega_B0": OMEGA,
        "integrator_order": 6,
        "step_max": 0.1,
    }
    with running("plant_wheels", **own, **start) as it:
        it.set("wheel_torque_cmd", TORQUES)
        for i in range(1000):
            it.step(i * duration / 1000.0, duration / 1000.0)
        found = it.get("R_NB")
    gravity = start.get("gravity_gradient", True)
    return angle_between(found, by_basilisk(R0, OMEGA, *orbit, duration, step, gravity, wheels))  # type: ignore[call-arg]


@authority(
    "Wheels",
    "Attitude of plant_wheels against Basilisk's after an orbit of 5792 s with four driven wheels in a pyramid, order "
    "6, 0.1 s",
    source="Basilisk, reactionWheelStateEffector",
    unit="rad",
    tolerance=1e-8,
    needs="bsk:Basilisk",
)
def basilisk_four_wheels() -> float:
    return difference(PERIOD, 0.5, LIGHT, {}, {})


@authority(
    "Wheels",
    "The same with viscous and Coulomb friction, none of the wheels standing still",
    source="Basilisk, reactionWheelStateEffector",
    unit="rad",
    tolerance=1e-8,
    needs="bsk:Basilisk",
)
def basilisk_friction_of_wheels() -> float:
    own = {"wheel_viscous_friction": [1e-5 * LIGHT] * 4, "wheel_coulomb_friction": [2e-7] * 4}
    return difference(PERIOD, 0.5, LIGHT, own, {"cViscous": 1e-5 * LIGHT, "fCoulomb": 2e-7})


@authority(
    "Wheels",
    "Turn of the body in 0.25 s by static and dynamic imbalance of four wheels at 100 to 375 rad/s, relative "
    "difference",
    source="Basilisk, reactionWheelStateEffector, JitterSimple",
    tolerance=1e-3,
    needs="bsk:Basilisk",
)
def basilisk_imbalance_of_wheels() -> float:
    duration, inertia, product, moment, position = 0.25, 4e-5, 1e-7, 1e-6, [0.1, -0.2, 0.15]
    free = {"gravity_gradient": False}
    own: dict[str, Any] = {"wheel_dynamic_imbalance": [product] * 4, "wheel_static_imbalance": [moment] * 4}
    own["wheel_position_B"] = [position] * 4
    theirs = {"RWModel": 1, "U_d": product, "U_s": moment, "rWB_B": [[x] for x in position]}
    effect = difference(duration, 1e-4, inertia, free, theirs)
    assert effect > 1e-6, "the imbalance must matter for the comparison to say anything"
    return difference(duration, 1e-4, inertia, free | own, theirs) / effect
