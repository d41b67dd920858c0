"""Reads CCSDS AEM 1.0 and 2.0, as KVN or XML: the attitude, by quaternions.

In version 1 ATTITUDE_DIR says which frame is turned into which, and QUATERNION_TYPE where the scalar stands.
In version 2 REF_FRAME_A is turned into REF_FRAME_B and the scalar is last.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from orchestration.errors import InputError, Place, Problem, reason
from orchestration.results.whole import content
from orchestration.rotation import quaternions

from .frames import named
from .instants import Instants, seconds_after
from .motion import Motion, rotations

Segment = tuple[dict[str, str], list[tuple[str, list[float]]]]
"""The metadata and the rows of a segment."""
_KEPT = ("QUATERNION", "QUATERNION/ANGVEL", "QUATERNION/DERIVATIVE", "QUATERNION/RATE")


def is_aem(path: Path) -> bool:
    """Returns whether a file begins as an AEM does."""
    try:
        return b"CCSDS_AEM_VERS" in content(path)[:2000]
    except (OSError, ValueError):
        return False


def read(path: Path, epoch: str | None = None) -> Motion:
    """Returns the attitude of a file in the frame that it names, at times from a UTC: by default that of its first row.

    Raises InputError where it is no AEM, has no quaternions, or has no body frame.
    """
    place = str(path)
    try:
        text = content(path).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(Problem(expected="a CCSDS AEM", found="text that is not UTF-8", place=Place(place))) from None
    except (OSError, ValueError) as error:
        why = reason(error) if isinstance(error, OSError) else str(error)
        raise InputError(Problem(expected="a CCSDS AEM", found=why, place=Place(place))) from None
    version, segments = _xml(text, place) if text.lstrip().startswith("<") else _kvn(text, place)
    parts = [_attitude(version, segment, place) for segment in segments]
    if not parts or not parts[0][1]:
        raise InputError(Problem(expected="a segment with attitude", found="none", place=Place(place)))
    frames = {frame for frame, *_ in parts}
    scales = {segment[0].get("TIME_SYSTEM", "UTC") for segment in segments}
    if len(frames) > 1 or len(scales) > 1:
        found = ", ".join(sorted(frames | scales))
        raise InputError(Problem(expected="segments in one frame and time", found=found, place=Place(place)))
    times = [time for _, rows, _ in parts for time in rows]
    scale = scales.pop()
    if epoch is None:
        if scale != "UTC":
            expected, found = "--epoch, the UTC at t = 0", f"times in {scale}"
            raise InputError(Problem(expected=expected, found=found, place=Place(place)))
        epoch = times[0].rstrip("Z") + "Z"
    seconds = seconds_after(epoch, times, scale, place)
    q = np.concatenate([q for _, _, q in parts])
    order = np.unique(seconds, return_index=True)[1]
    matrices = rotations(q[order]).reshape(-1, 9)
    return Motion(
        named(frames.pop(), place), Instants(epoch, seconds[order], place), quaternions(matrices), None, None, None
    )


def _attitude(version: float, segment: Segment, place: str) -> tuple[str, list[str], np.ndarray]:
    """Returns the inertial frame, the times, and the quaternions of its turn into the body's, scalar first."""
    about, rows = segment
    kind = about.get("ATTITUDE_TYPE", "").upper().replace(" ", "_")
    if kind not in _KEPT:
        expected = f"ATTITUDE_TYPE {' or '.join(_KEPT)}"
        raise InputError(Problem(expected=expected, found=kind or "none", place=Place(place)))
    if any(len(values) < 4 for _, values in rows):
        raise InputError(
            Problem(expected="four numbers of a quaternion in each row", found="fewer", place=Place(place))
        )
    q = np.array([values[:4] for _, values in rows]).reshape(-1, 4)
    if version >= 2.0 or about.get("QUATERNION_TYPE", "LAST").upper() == "LAST":
        q = np.roll(q, 1, axis=1)
    a, b = about.get("REF_FRAME_A", ""), about.get("REF_FRAME_B", "")
    if version < 2.0 and about.get("ATTITUDE_DIR", "A2B").upper() == "B2A":
        a, b = b, a
    if _is_body(a) == _is_body(b):
        expected, found = "a body frame (SC_BODY_1 or the like) and an inertial one", f"{a} and {b}"
        raise InputError(Problem(expected=expected, found=found, place=Place(place, name="REF_FRAME_A")))
    if _is_body(a):
        a, q = b, q * [1.0, -1.0, -1.0, -1.0]
    size = np.linalg.norm(q, axis=1, keepdims=True)
    if len(q) and not (np.abs(size - 1.0) < 1e-3).all():
        found = f"one of {float(size[np.abs(size - 1.0).argmax(), 0]):.6g}"
        raise InputError(Problem(expected="quaternions of length 1", found=found, place=Place(place)))
    return a, [time for time, _ in rows], q / size


def _is_body(frame: str) -> bool:
    return frame.upper().replace(" ", "_").startswith(("SC_BODY", "SPACECRAFT_BODY", "SC_B"))


def _kvn(text: str, place: str) -> tuple[float, list[Segment]]:
    version, segments, data = 0.0, list[Segment](), False
    for number, line in enumerate(text.splitlines(), start=1):
        line = line.strip()
        key, equals, value = (part.strip() for part in line.partition("="))
        if not line or line.startswith("COMMENT"):
            continue
        try:
            if key == "CCSDS_AEM_VERS":
                version = float(value)
            elif key == "META_START":
                segments.append(({}, []))
            elif key in ("META_STOP", "DATA_START", "DATA_STOP"):
                data = key == "DATA_START"
            elif data and segments:
                time, *values = line.split()
                segments[-1][1].append((time, _numbers(values)))
            elif segments and equals:
                segments[-1][0][key] = value
        except ValueError:
            expected = "a time and numbers" if data else "the number of a version"
            raise InputError(Problem(expected=expected, found=repr(line[:60]), place=Place(place, number))) from None
    if not version:
        found = "no line CCSDS_AEM_VERS"
        raise InputError(Problem(expected="a CCSDS AEM", found=found, place=Place(place)))
    return version, segments


def _numbers(texts: list[str]) -> list[float]:
    values = [float(text) for text in texts]
    if not np.isfinite(values).all():
        raise ValueError
    return values


def _xml(text: str, place: str) -> tuple[float, list[Segment]]:
    from lxml import etree  # here, as where an FMU's is read, since few files are XML  # noqa: PLC0415

    try:
        parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=True)
        root = etree.fromstring(text.encode(), parser)
        (message,) = [e for e in root.iter() if _tag(e) == "aem"]
        version = float(message.get("version") or "none")
        return version, [_segment(e) for e in message.iter() if _tag(e) == "segment"]
    except (etree.XMLSyntaxError, ValueError, TypeError, StopIteration) as error:
        found = " ".join(str(error).split())[:100] or "another document"
        raise InputError(Problem(expected="a CCSDS AEM in XML", found=found, place=Place(place))) from None


def _segment(element: Any) -> Segment:
    about: dict[str, str] = {}
    rows: list[tuple[str, list[float]]] = []
    for part in element.iter():
        if _tag(part) == "metadata":
            about = {_tag(e): (e.text or "").strip() for e in part}
        elif _tag(part) == "attitudeState":
            time = next(e.text.strip() for e in part.iter() if _tag(e) == "EPOCH")
            found = {_tag(e): e.text for e in part.iter()}
            names = ["Q1", "Q2", "Q3", "QC"]
            if about.get("QUATERNION_TYPE", "LAST").upper() == "FIRST":  # then _attitude takes the first for the scalar
                names = ["QC", "Q1", "Q2", "Q3"]
            rows.append((time, _numbers([found.get(name) or "none" for name in names])))
    return about, rows


def _tag(element: Any) -> str:
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""
