"""Orekit's TorqueFree attitude, an implementation of Jacobi's functions by others. Optional: needs orekit-jpype and a
Java runtime."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import erfa
import numpy as np
from scipy.spatial.transform import Rotation

from evidence.verification.rk4 import angle_between
from formats.convert import convert
from formats.frames import from_N
from formats.instants import Instants
from formats.recorded import Recorded
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


@authority(
    "Formats",
    "Attitude of an AEM in GCRF, as Orekit reads it and turns it to its mean equator and equinox of date (IAU 1976)",
    source="Orekit",
    unit="rad",
    tolerance=1e-9,
    needs="orekit-jpype:orekit_jpype",
)
def orekit_aem() -> float:
    import orekit_jpype

    orekit_jpype.initVM()
    from java.io import File
    from org.orekit.data import DataContext, DataSource, DirectoryCrawler
    from org.orekit.files.ccsds.ndm import ParserBuilder
    from org.orekit.frames import FramesFactory
    from org.orekit.time import AbsoluteDate, TimeScalesFactory

    epoch = "2009-08-10T00:00:00"
    R = Rotation.random(20, random_state=12).as_matrix()
    data = Recorded("aem", np.arange(20.0), {"plant.R_NB": R}, {}, {"plant": {"epoch": epoch}})
    with TemporaryDirectory() as folder:
        (path,) = convert(data, "aem", Path(folder, "a.xml"), frame="GCRF")
        Path(folder, "tai-utc.dat").write_text("".join(_leap_seconds()), "ascii")
        DataContext.getDefault().getDataProvidersManager().addProvider(DirectoryCrawler(File(folder)))
        date = AbsoluteDate(epoch, TimeScalesFactory.getUTC())
        message = ParserBuilder().buildAemParser().parseMessage(DataSource(str(path)))
        states = list(message.getSegments().get(0).getData().getAngularCoordinates())
        to_N = _matrix(FramesFactory.getGCRF().getTransformTo(FramesFactory.getMOD(False), date).getRotation())
    ours = from_N("GCRF", Instants(epoch, np.zeros(1)).tt0)
    assert np.allclose(to_N @ ours, np.eye(3), atol=1e-10)
    assert [state.getDate().durationFrom(date) for state in states] == data.time.tolist()
    turned = [to_N @ _matrix(state.getRotation()).T for state in states]
    return max(angle_between(a, b) for a, b in zip(R, turned, strict=True))


def _leap_seconds() -> list[str]:
    """The lines of the US Naval Observatory's tai-utc.dat, which Orekit reads."""
    months = "JAN FEB MAR APR MAY JUN JUL AUG SEP OCT NOV DEC".split()
    return [
        f" {year} {months[month - 1]}  1 =JD {sum(erfa.cal2jd(year, month, 1)):.1f}  TAI-UTC=  {ahead:.7f} S "
        "+ (MJD - 41317.) X 0.0      S\n"
        for year, month, ahead in erfa.leap_seconds.get().tolist()
        if year >= 1972
    ]
