"""AEMs of others as truth: written by brahe, and by hand as the standard's first version has them."""

import brahe
import numpy as np
import pytest
from brahe.ccsds import AEM
from scipy.spatial.transform import Rotation

from formats.aem import read
from formats.convert import convert, difference
from formats.frames import from_N
from formats.instants import Instants
from formats.motion import angles
from orchestration import InputError

from .conftest import EPOCH, attitude

FIRST = """CCSDS_AEM_VERS = 1.0
CREATION_DATE = 2020-001T00:00:00
ORIGINATOR = HAND
META_START
OBJECT_NAME = A
OBJECT_ID = A
REF_FRAME_A = {a}
REF_FRAME_B = {b}
ATTITUDE_DIR = {direction}
TIME_SYSTEM = {scale}
ATTITUDE_TYPE = QUATERNION
QUATERNION_TYPE = {kind}
META_STOP
DATA_START
{rows}
DATA_STOP
"""


def turned(frame, t):
    """The attitude at t relative to a frame."""
    return Rotation.from_matrix(from_N(frame, Instants(EPOCH, np.zeros(1)).tt0)) * attitude(t)


@pytest.mark.parametrize("form", ["KVN", "XML"])
def test_an_aem_of_brahe_is_the_attitude_that_it_was_given(flown, tmp_path, form):
    course = brahe.AttitudeTrajectory(
        brahe.ReferenceFrame.celestial(brahe.CelestialFrame.GCRF),
        brahe.ReferenceFrame.body(None, brahe.BodyFrame.SC_BODY("1")),
    )
    epoch = brahe.Epoch.from_datetime(2016, 12, 31, 23, 59, 50.0, 0.0, brahe.TimeSystem.UTC)
    for t in flown.time:
        to_body = brahe.Quaternion.from_rotation_matrix(
            brahe.RotationMatrix.from_matrix(turned("GCRF", t).as_matrix().T)
        )
        course.add(epoch + float(t), to_body, None)
    path = tmp_path / "theirs"
    AEM.from_attitude_trajectory(course, "SPIN", "2009-041A", "BRAHE", "UTC").to_file(str(path), form)
    found = difference(flown, path)
    assert found.instants == len(flown.time)
    assert found.largest < 1e-9


@pytest.mark.parametrize("direction", ["A2B", "B2A"])
@pytest.mark.parametrize("body_first", [False, True])
@pytest.mark.parametrize("kind", ["FIRST", "LAST"])
def test_direction_and_scalar_of_version_1_are_understood(tmp_path, direction, body_first, kind):
    a, b = ("SC_BODY_1", "EME2000") if body_first else ("EME2000", "SC_BODY_1")
    from_inertial = (direction == "A2B") != body_first
    rows = []
    for t in (0.0, 1.0):
        q = turned("EME2000", t)
        x, y, z, w = (q if from_inertial else q.inv()).as_quat()
        values = (w, x, y, z) if kind == "FIRST" else (x, y, z, w)
        rows.append(f"2017-001T00:00:{25.0 + t:06.3f} " + " ".join(map(repr, map(float, values))))  # TAI of 23:59:49
    path = tmp_path / "a.aem"
    path.write_text(FIRST.format(a=a, b=b, direction=direction, kind=kind, scale="TAI", rows="\n".join(rows)))
    found = read(path, EPOCH)
    assert found.instants.time == pytest.approx([-1.0, 0.0], abs=1e-9)
    ours = np.array([np.roll(turned("EME2000", t).as_quat(), 1) for t in (0.0, 1.0)])
    assert angles(found.q, ours).max() < 1e-12


def test_between_its_rows_an_ephemeris_is_interpolated_by_slerp(flown, tmp_path):
    """Exact for a constant rate, whatever lies between two rows."""
    sparse = type(flown)(
        flown.name, flown.time[::40], {k: v[::40] for k, v in flown.signals.items()}, {}, flown.parameters
    )
    (path,) = convert(sparse, "aem", tmp_path / "sparse.xml")
    assert difference(flown, path).largest < 1e-9


def test_a_turned_attitude_differs_by_the_turn(flown, tmp_path):
    (path,) = convert(flown, "aem", tmp_path / "a.aem")
    flown.signals["plant.R_NB"][40] = (attitude(20.0) * Rotation.from_rotvec([0.0, 3e-5, 4e-5])).as_matrix()
    found = difference(flown, path)
    assert (found.time, found.largest) == (20.0, pytest.approx(5e-5, rel=1e-6))
    assert str(found).startswith("attitude at 121 instants: largest 5e-05 rad (0.002865 deg) at 20 s")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("SC_BODY_1", "TEMEOFDATE"), "REF_FRAME_A: expected a body frame"),
        (("= QUATERNION\n", "= SPIN\n"), "expected ATTITUDE_TYPE QUATERNION or .* found SPIN"),
        (("0.0 0.0 0.0 1.0", "0.0 0.0 x 1.0"), "a.aem:15: expected a time and numbers, found"),
        (("0.0 0.0 0.0 1.0", "0.0 0.0 0.0 2.0"), "expected quaternions of length 1, found one of 2"),
        (("2017-001T00", "2017-00T"), "expected a date such as"),
        (("CCSDS_AEM_VERS = 1.0", ""), "expected a CCSDS AEM, found no line CCSDS_AEM_VERS"),
        (("= TAI", "= MET"), "expected a date such as .* in MET"),
    ],
)
def test_what_is_wrong_with_a_file_is_told(tmp_path, change, message):
    row = "2017-001T00:00:25 0.0 0.0 0.0 1.0"
    text = FIRST.format(a="EME2000", b="SC_BODY_1", direction="A2B", kind="LAST", scale="TAI", rows=row)
    path = tmp_path / "a.aem"
    path.write_text(text.replace(*change))
    with pytest.raises(InputError, match=message):
        read(path, EPOCH)


def test_broken_xml_and_times_apart_from_the_run_are_told(flown, tmp_path):
    path = tmp_path / "a.xml"
    path.write_text("<aem id='CCSDS_AEM_VERS'><x></aem>")
    with pytest.raises(InputError, match=r"a.xml: expected a CCSDS AEM in XML, found"):
        read(path)
    (other,) = convert(flown, "aem", tmp_path / "a.aem")
    flown.parameters["plant"]["epoch"] = "2020-01-01T00:00:00Z"
    with pytest.raises(InputError, match=r"a.aem: expected attitude within 0 s to 60 s from 2020-01-01"):
        difference(flown, other)
