"""Orekit's TorqueFree attitude, an implementation of Jacobi's functions by others. Optional: needs orekit-jpype and a
Java runtime."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from evidence.verification.rk4 import angle_between
from tests.authorities.registry import authority
from tests.plant.motion import FULL_INERTIA, checked, command, fly


@authority(
    "Torque-free",
    "Attitude of the plant block against Orekit's TorqueFree after 600 s, order 6, 0.1 s, inertia with products",
    source="Orekit",
    unit="rad",
    tolerance=1e-10,
    needs="orekit-jpype:orekit_jpype",
)
def orekit_torque_free() -> float:
    import orekit_jpype

    orekit_jpype.initVM()
    from org.hipparchus.geometry.euclidean.threed import Rotation as OrekitRotation
    from org.hipparchus.geometry.euclidean.threed import Vector3D
    from org.orekit.attitudes import Attitude, Inertia, InertiaAxis, TorqueFree
    from org.orekit.frames import FramesFactory
    from org.orekit.time import AbsoluteDate
    from org.orekit.utils import AngularCoordinates

    omega, duration = np.array([0.06, -0.08, 0.05]), 600.0
    R0 = Rotation.random(random_state=11).as_matrix()
    q0 = np.roll(Rotation.from_matrix(R0).as_quat(), 1)
    p = checked(
        J_B=FULL_INERTIA,
        gravity_gradient=False,
        initial_attitude="q_NB0",
        q_NB0=q0,
        omega_B0=omega,
        integrator_order=6,
        step_max=0.1,
    )
    moments, axes = np.linalg.eigh(FULL_INERTIA)
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    date, frame = AbsoluteDate.ARBITRARY_EPOCH, FramesFactory.getGCRF()
    # Orekit's rotation takes inertial components to the body's, and so does its quaternion with the vector part of
    # ours.
    to_body = OrekitRotation(*map(float, q0), True)
    assert np.allclose(_matrix(to_body), R0.T, atol=1e-12)
    spin = Vector3D(*map(float, omega))
    start = Attitude(date, frame, AngularCoordinates(to_body, spin, Vector3D.ZERO))
    inertia = Inertia(
        *(InertiaAxis(float(moment), Vector3D(*map(float, axis))) for moment, axis in zip(moments, axes.T, strict=True))
    )
    theirs = TorqueFree(start, inertia).getAttitude(None, date.shiftedBy(duration), frame).getRotation()
    R = fly(p, command(), 0.1, round(duration / 0.1))[-1].R
    return angle_between(R, _matrix(theirs).T)


def _matrix(rotation) -> np.ndarray:
    return np.array([list(row) for row in rotation.getMatrix()])
