"""Writes CCSDS AEM 2.0 (504.0-B-2) and OEM 2.0 (502.0-B-2), as KVN or as XML.

The quaternion of an AEM is that of the rotation of the axes of REF_FRAME_A into those of REF_FRAME_B, so that of
x_A = q x_B q*, with the scalar last; rates are in deg/s, in REF_FRAME_B. An OEM has km and km/s.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from orchestration.errors import InputError, Place, Problem

from .frames import NAMES
from .motion import Motion

BODY = "SC_BODY_1"
_SCHEMA = "https://sanaregistry.org/files/ndmxml_unqualified/ndmxml-3.0.0-master-3.0.xsd"
_XSI = "http://www.w3.org/2001/XMLSchema-instance"
Pairs = list[tuple[str, str]]


@dataclass(frozen=True)
class Labels:
    """Whose motion a message tells."""

    name: str
    """OBJECT_NAME."""
    id: str
    """OBJECT_ID: the international designator, such as 2009-041A."""
    created: str
    """CREATION_DATE, UTC."""


@dataclass(frozen=True)
class _Message:
    kind: str
    """aem or oem."""
    version: str
    header: Pairs
    metadata: Pairs
    rows: list[tuple[str, list[float]]]
    element: Callable[[str, list[float]], ET.Element]
    """A row in XML."""


def aem(motion: Motion, labels: Labels, xml: bool) -> str:
    """Returns the attitude as an AEM. With rates its type is QUATERNION/ANGVEL, else QUATERNION."""
    q = np.roll(motion.q, -1, axis=1)
    rates = motion.rate
    times = motion.instants.utc()
    metadata = [
        *_object(labels, times),
        ("REF_FRAME_A", NAMES[motion.frame]),
        ("REF_FRAME_B", BODY),
        ("ATTITUDE_TYPE", "QUATERNION" if rates is None else "QUATERNION/ANGVEL"),
        *([] if rates is None else [("ANGVEL_FRAME", BODY)]),
    ]
    order = "COMMENT OBJECT_NAME OBJECT_ID REF_FRAME_A REF_FRAME_B TIME_SYSTEM START_TIME STOP_TIME"
    order += " ATTITUDE_TYPE ANGVEL_FRAME"
    rows = q if rates is None else np.column_stack([q, np.degrees(rates)])
    return _text(_message("aem", "2.0", labels, _sorted(metadata, motion, order), times, rows, _attitude), xml)


def oem(motion: Motion, labels: Labels, xml: bool) -> str:
    """Returns the orbit as an OEM. Raises InputError where position or velocity were not recorded."""
    if motion.position is None or motion.velocity is None:
        place = Place("--velocity" if motion.velocity is None else "--position")
        raise InputError(Problem("an OEM needs position and velocity", remedy="record both", place=place))
    times = motion.instants.utc()
    frame = [("CENTER_NAME", "EARTH"), ("REF_FRAME", NAMES[motion.frame])]
    if motion.frame == "N":
        frame.append(("REF_FRAME_EPOCH", motion.instants.epoch.rstrip("Z")))
    order = "COMMENT OBJECT_NAME OBJECT_ID CENTER_NAME REF_FRAME REF_FRAME_EPOCH TIME_SYSTEM START_TIME STOP_TIME"
    rows = np.column_stack([motion.position, motion.velocity]) / 1000.0
    metadata = _sorted([*_object(labels, times), *frame], motion, order)
    return _text(_message("oem", "2.0", labels, metadata, times, rows, _state), xml)


def _object(labels: Labels, times: list[str]) -> Pairs:
    named = [("OBJECT_NAME", labels.name), ("OBJECT_ID", labels.id)]
    return [*named, ("TIME_SYSTEM", "UTC"), ("START_TIME", times[0]), ("STOP_TIME", times[-1])]


def _sorted(pairs: Pairs, motion: Motion, order: str) -> Pairs:
    """The standard has an order of the keywords."""
    epoch = motion.instants.epoch
    note = [("COMMENT", f"MOE_EARTH: mean equator and equinox of {epoch}")] if motion.frame == "N" else []
    return sorted([*note, *pairs], key=lambda pair: order.split().index(pair[0]))


def _message(
    kind: str,
    version: str,
    labels: Labels,
    metadata: Pairs,
    times: list[str],
    rows: np.ndarray,
    element: Callable[[str, list[float]], ET.Element],
) -> _Message:
    header = [("CREATION_DATE", labels.created), ("ORIGINATOR", "ATTITUDE-COSIM")]
    return _Message(kind, version, header, metadata, list(zip(times, rows.tolist(), strict=True)), element)


def _text(message: _Message, xml: bool) -> str:
    return _xml(message) if xml else "\n".join(_kvn(message)) + "\n"


def _kvn(message: _Message) -> Iterable[str]:
    yield f"CCSDS_{message.kind.upper()}_VERS = {message.version}"
    yield from map(_pair, message.header)
    yield from ("", "META_START", *map(_pair, message.metadata), "META_STOP", "")
    marks = message.kind == "aem"  # an OEM has none
    yield from ["DATA_START"] * marks
    for time, values in message.rows:
        yield " ".join([time, *map(repr, values)])
    yield from ["DATA_STOP"] * marks


def _pair(pair: tuple[str, str]) -> str:
    return f"COMMENT {pair[1]}" if pair[0] == "COMMENT" else f"{pair[0]} = {pair[1]}"


def _xml(message: _Message) -> str:
    root = ET.Element(message.kind, id=f"CCSDS_{message.kind.upper()}_VERS", version=message.version)
    root.set("xmlns:xsi", _XSI)
    root.set("xsi:noNamespaceSchemaLocation", _SCHEMA)
    header, body = _element("header", message.header), ET.Element("body")
    root.extend([header, body])
    segment = ET.SubElement(body, "segment")
    segment.append(_element("metadata", message.metadata))
    ET.SubElement(segment, "data").extend([message.element(*row) for row in message.rows])
    ET.indent(root)
    return ET.tostring(root, "unicode", xml_declaration=True).replace("encoding='utf-8'", 'encoding="UTF-8"', 1) + "\n"


def _element(tag: str, pairs: Iterable[tuple[str, str]], units: str = "") -> ET.Element:
    made = ET.Element(tag)
    for name, text in pairs:
        ET.SubElement(made, name, {"units": units} if units else {}).text = text
    return made


def _attitude(time: str, values: list[float]) -> ET.Element:
    state = ET.Element("attitudeState")
    inner = ET.SubElement(state, "quaternionEphemeris" if len(values) == 4 else "quaternionAngVel")
    ET.SubElement(inner, "EPOCH").text = time
    inner.append(_element("quaternion", zip(("Q1", "Q2", "Q3", "QC"), map(repr, values[:4]), strict=True)))
    if len(values) > 4:
        names = ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z")
        inner.append(_element("angVel", zip(names, map(repr, values[4:]), strict=True), "deg/s"))
    return state


def _state(time: str, values: list[float]) -> ET.Element:
    state = ET.Element("stateVector")
    ET.SubElement(state, "EPOCH").text = time
    for names, part, unit in (("X Y Z", values[:3], "km"), ("X_DOT Y_DOT Z_DOT", values[3:], "km/s")):
        state.extend(_element("_", zip(names.split(), map(repr, part), strict=True), unit))
    return state
