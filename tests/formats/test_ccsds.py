"""AEM and OEM, read back by brahe, which this project did not write; tests/authorities/orekit.py has Orekit."""

import re

import brahe
import numpy as np
import pytest
from brahe.ccsds import AEM, OEM

from formats.convert import convert
from formats.frames import from_N
from formats.instants import Instants
from orchestration import InputError

from .conftest import EPOCH, RATE, attitude

FORMS = ["message.kvn", "message.xml"]


@pytest.mark.parametrize("name", FORMS)
@pytest.mark.parametrize("frame", ["EME2000", "GCRF"])
def test_brahe_reads_the_attitude_of_an_aem_in_a_rotated_frame(flown, tmp_path, name, frame):
    (path,) = convert(flown, "aem", tmp_path / name, frame=frame)
    course = AEM.from_file(str(path)).to_attitude_trajectories()[0]
    assert (str(course.frame_a), str(course.frame_b)) == (frame, "SC_BODY_1")
    assert len(course) == len(flown.time)
    epoch = brahe.Epoch.from_datetime(2016, 12, 31, 23, 59, 50.0, 0.0, brahe.TimeSystem.UTC)
    turn = from_N(frame, Instants(EPOCH, flown.time).tt0)
    for t in (0.0, 9.5, 10.5, 11.0, 60.0):  # before, within and after the leap second
        to_body = course.rotation_matrix(epoch + t).to_matrix()
        assert to_body @ (turn @ attitude(t).as_matrix()) == pytest.approx(np.eye(3), abs=1e-9)
        assert course.angular_velocity(epoch + t) == pytest.approx(RATE, abs=1e-12)


def test_the_leap_second_of_a_run_is_a_second_of_its_own(flown, tmp_path):
    text = convert(flown, "aem", tmp_path / "a.aem")[0].read_text()
    times = re.findall(r"^(20\S+) ", text, re.MULTILINE)
    assert times[20] == "2016-12-31T23:59:60.000000000"
    assert times[21] == "2016-12-31T23:59:60.500000000"
    assert times[22] == "2017-01-01T00:00:00.000000000"


@pytest.mark.parametrize("name", FORMS)
def test_brahe_reads_position_and_velocity_of_an_oem_in_N_with_its_epoch(flown, tmp_path, name):
    (path,) = convert(flown, "oem", tmp_path / name, frame="N", object_id="2009-041A")
    segment = OEM.from_file(str(path)).segments[0]
    assert (segment.ref_frame, segment.object_id, segment.center_name) == ("MOE_EARTH", "2009-041A", "EARTH")
    assert segment.ref_frame_epoch is not None
    for i in (0, 60, 120):
        state = segment.states[i]
        assert state.position == pytest.approx(flown.signals["plant.r_N"][i], abs=1e-6)
        assert state.velocity == pytest.approx(flown.signals["plant.v_N"][i], abs=1e-9)


def test_samples_without_attitude_are_left_out(flown, tmp_path):
    flown.signals["plant.R_NB"][:3] = 0.0
    text = convert(flown, "aem", tmp_path / "a.aem")[0].read_text()
    assert "START_TIME = 2016-12-31T23:59:51.5" in text


def test_what_is_missing_is_told_with_its_option_and_remedy(flown, tmp_path):
    del flown.signals["plant.v_N"]
    with pytest.raises(InputError, match=r"--velocity: an OEM needs position and velocity; remedy: record both"):
        convert(flown, "oem", tmp_path / "a.oem")
    flown.parameters["plant"].clear()
    with pytest.raises(
        InputError, match=r"--epoch: the run has no parameter plant.epoch with a date; remedy: --epoch 2009"
    ):
        convert(flown, "aem", tmp_path / "a.aem")
    assert not list(tmp_path.iterdir())
