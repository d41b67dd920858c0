"""MCAP, read by the decoder of the mcap project from the schemas in the file."""

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from formats.convert import convert

from .conftest import RATE, attitude


@pytest.fixture
def messages(flown, tmp_path):
    (path,) = convert(flown, "mcap", tmp_path / "run.mcap")
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        read = [(c.topic, s.name, m.log_time, d) for s, c, m, d in reader.iter_decoded_messages()]
    return {topic: [entry[1:] for entry in read if entry[0] == topic] for topic in {entry[0] for entry in read}}


def test_each_topic_has_the_schema_that_foxglove_draws(messages, flown):
    schemas = {topic: rows[0][0] for topic, rows in messages.items()}
    assert schemas == {
        "/tf": "foxglove.FrameTransforms",
        "/pose": "foxglove.PoseInFrame",
        "/scene": "foxglove.SceneUpdate",
        "/plant": "run.plant",
    }
    assert len(messages["/tf"]) == len(messages["/plant"]) == len(flown.time)


def test_frames_and_pose_have_the_attitude_at_their_times(messages, flown):
    zero = 1483228790  # 2016-12-31T23:59:50 in Unix time
    for i, t in enumerate(flown.time):
        _, at, message = messages["/tf"][i]
        assert at == round((zero + t) * 1e9)
        body, lvlh = message.transforms
        q = body.rotation
        apart = attitude(t).inv() * Rotation.from_quat([q.x, q.y, q.z, q.w])
        assert (body.parent_frame_id, body.child_frame_id, lvlh.child_frame_id) == ("N", "body", "lvlh")
        assert apart.magnitude() < 1e-9
        assert str(messages["/pose"][i][2].pose.orientation) == str(q)
        p, q = lvlh.translation, lvlh.rotation
        nadir = Rotation.from_quat([q.x, q.y, q.z, q.w]).apply([0.0, 0.0, 1.0])
        r = flown.signals["plant.r_N"][i]
        assert [p.x, p.y, p.z] == r.tolist()
        assert nadir == pytest.approx(-r / np.linalg.norm(r), abs=1e-12)


def test_the_signals_of_a_block_are_lists_to_plot(messages, flown):
    message = messages["/plant"][7][2]
    assert list(message.omega_B) == RATE.tolist()
    assert list(message.R_NB) == flown.signals["plant.R_NB"][7].ravel().tolist()
    assert list(message.h_w) == [flown.signals["plant.h_w"][7]]
