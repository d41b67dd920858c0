"""Writes a run as MCAP with Foxglove's Protobuf schemas: frames, pose, a body to look at, all signals to plot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from orchestration.rotation import quaternions

from .instants import missing
from .motion import Motion
from .recorded import Recorded

ROOT, BODY, LVLH = "N", "body", "lvlh"


def write(data: Recorded, motion: Motion, path: Path) -> None:
    """Writes `/tf` (frames N, body, lvlh), `/pose`, `/scene` and a topic for the signals of each block.

    Times are Unix time, that of the epoch plus t. A matrix of a signal is a list, row by row.
    Raises InputError without the packages of MCAP and Foxglove.
    """
    try:
        from foxglove_schemas_protobuf import FrameTransforms_pb2, PoseInFrame_pb2  # optional  # noqa: PLC0415
        from mcap_protobuf.writer import Writer  # optional  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise missing(str(error.name)) from None
    times = motion.instants.unix_ns().tolist()
    rows = np.searchsorted(data.time, motion.instants.time)
    blocks = {
        block: [name for name in data.signals if name.partition(".")[0] == block]
        for block in dict.fromkeys(name.partition(".")[0] for name in data.signals)
    }
    messages = {block: _message(block, names) for block, names in blocks.items()}
    values = {name: array.reshape(len(data.time), -1)[rows].tolist() for name, array in data.signals.items()}
    orbit = _lvlh(motion)
    with path.open("wb") as file, Writer(file) as writer:

        def put(topic: str, message: Any, at: int) -> None:
            writer.write_message(topic, message, log_time=at, publish_time=at)

        put("/scene", _scene(times[0]), times[0])
        for i, at in enumerate(times):
            transforms = FrameTransforms_pb2.FrameTransforms()
            where = None if motion.position is None else motion.position[i]
            _transform(transforms.transforms.add(), BODY, at, where, motion.q[i])
            if orbit is not None:
                _transform(transforms.transforms.add(), LVLH, at, where, orbit[i])
            put("/tf", transforms, at)
            pose = PoseInFrame_pb2.PoseInFrame(frame_id=ROOT)
            pose.timestamp.FromNanoseconds(at)
            _set(pose.pose.position, pose.pose.orientation, where, motion.q[i])
            put("/pose", pose, at)
            for block, names in blocks.items():
                message = messages[block]()
                for field, name in zip(message.DESCRIPTOR.fields, names, strict=True):
                    getattr(message, field.name).extend(values[name][i])
                put(f"/{block}", message, at)


def _message(block: str, names: list[str]) -> Any:
    """Returns a Protobuf class with a list of doubles for each signal of a block."""
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory  # optional  # noqa: PLC0415

    file = descriptor_pb2.FileDescriptorProto(name=f"{block}.proto", package="run", syntax="proto3")
    kind = descriptor_pb2.FieldDescriptorProto
    message = file.message_type.add(name=_plain(block))
    for number, name in enumerate(names, start=1):
        field = _plain(name.partition(".")[2])
        message.field.add(name=field, number=number, type=kind.TYPE_DOUBLE, label=kind.LABEL_REPEATED)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(f"run.{_plain(block)}"))


def _plain(name: str) -> str:
    """Returns a name of Protobuf: letters, digits and `_`, any other character by its number."""
    return "".join(c if c.isascii() and (c.isalnum() or c == "_") else f"_x{ord(c):04X}_" for c in name)


def _transform(transform: Any, child: str, at: int, position: Any, q: Any) -> None:
    transform.parent_frame_id, transform.child_frame_id = ROOT, child
    transform.timestamp.FromNanoseconds(at)
    _set(transform.translation, transform.rotation, position, q)


def _set(place: Any, turn: Any, position: Any, q: Any) -> None:
    if position is not None:
        place.x, place.y, place.z = position.tolist()
    turn.w, turn.x, turn.y, turn.z = q.tolist()


def _lvlh(motion: Motion) -> Any:
    """Returns (n, 4), x_N = q x_LVLH q*; None without orbit."""
    if motion.position is None or motion.velocity is None:
        return None
    nadir = -motion.position / np.linalg.norm(motion.position, axis=1, keepdims=True)
    against = -np.cross(motion.position, motion.velocity)
    against /= np.linalg.norm(against, axis=1, keepdims=True)
    return quaternions(np.stack([np.cross(against, nadir), against, nadir], axis=2).reshape(-1, 9))


def _scene(at: int) -> Any:
    """Returns a cube with the three body axes, of 1 m."""
    from foxglove_schemas_protobuf import SceneUpdate_pb2  # optional  # noqa: PLC0415

    update = SceneUpdate_pb2.SceneUpdate()
    entity = update.entities.add(id="body", frame_id=BODY, frame_locked=True)
    entity.timestamp.FromNanoseconds(at)
    cube = entity.cubes.add()
    cube.size.x = cube.size.y = cube.size.z = 0.5
    cube.pose.orientation.w = 1.0
    cube.color.r = cube.color.g = cube.color.b = cube.color.a = 0.6
    half = np.sqrt(0.5)
    for axis, q in enumerate(([1.0, 0.0, 0.0, 0.0], [half, 0.0, 0.0, half], [half, 0.0, -half, 0.0])):
        arrow = entity.arrows.add(shaft_length=0.8, shaft_diameter=0.04, head_length=0.2, head_diameter=0.1)
        _set(arrow.pose.position, arrow.pose.orientation, None, np.array(q))
        arrow.color.a = 1.0
        setattr(arrow.color, "rgb"[axis], 1.0)
    return update
