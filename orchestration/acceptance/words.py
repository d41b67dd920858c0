"""The field's words: which of them mean one thing, and what tells a direction or a side.

A port of another team is matched with one of ours by these, beside its unit and shape. Tests:
tests/orchestration/acceptance/test_suggest.py.
"""

from __future__ import annotations

import re
import unicodedata
from itertools import pairwise

_MEANINGS = {
    "attitude": "attitude att dcm cosine quaternion quat q mrp rodrigues euler rotvec orientation rotmat rpy",
    "rate": "rate rates gyro gyros omega angular angvel ang imu w spin drehrate winkelgeschwindigkeit",
    "field": "magnetic magnetometer mag field bfield mfield geomagnetic tam b mtm magnetfeld champ campo",
    "position": "position pos r location radius posicion",
    "velocity": "velocity vel v geschwindigkeit vitesse velocidad",
    "torque": "torque trq moment moments t tau couple ctrl control drehmoment sollmoment stellmoment",
    "wheel": "wheel rw reaction rotor motor flywheel tacho rwa l rad schwungrad radmoment roue rueda",
    "momentum": "momentum h speed tacho tach mom drall drehimpuls drehzahl",
    "dipole": "dipole dipoles mtq magnetorquer magnetorquers torquer torquers rod rods coil coils current currents mtr "
    "dipolmoment dipolmomente spule spulen bobine bobines dipolo",
    "sun": "sun css fss solar",
    "acceleration": "acceleration accel",
    "reference": "ref reference desired target guidance setpoint",
    "error": "error err residual",
    "planned": "ff feedforward planned",
    "sample": "sample counter count number valid",
}
"""By meaning: whole words, in small letters. `moment` and `reaction` have two; what stands beside them decides."""
_OF = {
    word: tuple(m for m, words in _MEANINGS.items() if word in words.split())
    for words in _MEANINGS.values()
    for word in words.split()
}
_OVERRULED = {
    "dipole": ("torque", "field"),
    "wheel": ("dipole",),
    "attitude": ("rate",),
}
"""A meaning beside which others are only part of its words: a magnetic dipole moment is no torque."""
FRAMES = {
    "B": ("body", "b", "bf", "spacecraft", "satellite", "sc"),
    "N": ("inertial", "n", "eci", "i", "j2000", "gcrf", "reference"),
}
SIDES = (("rotor", "motor"), ("body", "spacecraft", "satellite", "reaction"))
"""Of a wheel's torque: on what it acts; on the other side it has the opposite sign."""
_MAGNETIC_MOMENT = re.compile(r"\b(?:magnet\w*|magn)[ _]?moments?\b|\bmoments? magnet\w*", re.I)
_OF_ORBIT = re.compile(r"\b(?:relative to|with respect to|wrt|w\.r\.t\.|against)(?: the)? (?:lvlh|orbit)", re.I)
_ORBIT_AXES = re.compile(
    r"\b(?:to|from|into|2)(?: the)? (?:lvlh|orbit)|\b(?:lvlh|orbit(?:al)?)(?: frame| axes)? (?:to|into)\b", re.I
)
_ASIDE = {
    "a reference": "ref reference target des desired cmd commanded goal setpoint guidance",
    "an earlier value": "prev previous old",
    "a bias": "bias offset drift",
    "axes of the Earth": "ecef ecr itrf ned enu",
    "a measurement": "meas measured measurement noisy",
}
"""What a port is beside the quantity that its other words and its unit tell."""
_OF_INPUTS, _OF_OUTPUTS = {"a reference"}, {"a measurement"}
"""What is beside the quantity of an input alone (outputs are commands), and of an output."""
_FRAME = re.compile(r"\breference (?:frame|axes|system|coordinates)", re.I)
_WORD = r"[A-Za-z0-9]+"
_TO = re.compile(rf"\b({_WORD})(?:[- ](?:frame|axes|coordinates))?(?: to |[- ]to[- ]|->|2| into )(?:the )?({_WORD})\b")


def words_of(text: str) -> list[str]:
    """Returns the words of a name or a description, in small letters and without accents."""
    text = unicodedata.normalize("NFKD", text)
    text = "".join(letter for letter in text if not unicodedata.combining(letter))
    parts = re.sub(r"([a-z])([A-Z])", r"\1 \2", re.sub(r"_[A-Z]{1,2}\d*$", "", text))
    return [word.lower() for word in re.split(r"[^A-Za-z]+", parts) if word]


def meanings(name: str, description: str = "") -> set[str]:
    """Returns what a port means by its name; by its description as well, but for single letters."""
    found = {m for word in words_of(name) for m in _OF.get(word, ())}
    found |= {m for word in words_of(description.partition(":")[0]) if len(word) > 2 for m in _OF.get(word, ())}
    if any(_MAGNETIC_MOMENT.search(" ".join(words_of(text))) for text in (name, description)):
        found.add("dipole")
    for strong, weak in _OVERRULED.items():
        if strong in found:
            found -= set(weak)
    return found


def _frame(word: str) -> str:
    return next((frame for frame, words in FRAMES.items() if word.lower() in words), "")


def direction(text: str) -> tuple[str, str] | None:
    """Returns from which frame to which a rotation is told to lead, such as B to N; None where it is not told."""
    for match in _TO.finditer(text):
        pair = _frame(match[1]), _frame(match[2])
        if all(pair) and pair[0] != pair[1]:
            return pair
    return None


def axes(text: str) -> str:
    """Returns along which frame's axes a vector is told to have its components; empty where it is not told."""
    match = re.search(
        rf"\b(?:in|along)(?: the)? ({_WORD})(?:[- ]fixed)? (?:axes|frame|coordinates|components)", text, re.I
    )
    return _frame(match[1]) if match else ""


def of_orbit(text: str, rotation: bool = False) -> bool:
    """Returns whether a rate, or a rotation, is told to be relative to the orbit's axes."""
    return _OF_ORBIT.search(text) is not None or (rotation and _ORBIT_AXES.search(text) is not None)


def asides(name: str, description: str, output: bool) -> set[str]:
    """Returns what a port is told to be beside its quantity, such as a reference."""
    words = {*words_of(name), *words_of(_FRAME.sub("", description))}
    told = {what for what, those in _ASIDE.items() if words & set(those.split())}
    return told - (_OF_INPUTS if output else _OF_OUTPUTS)


def opposite(ours: str, theirs: str) -> bool:
    """Returns whether two descriptions of a torque name opposite sides."""

    def side(text: str) -> int | None:
        words = set(words_of(text))
        if "reaction" in words and words & {"body", "spacecraft", "satellite"}:
            return 1
        found = [i for i, side in enumerate(SIDES) if words & set(side[:3])]
        return found[0] if len(found) == 1 else None

    one, other = side(ours), side(theirs)
    return one is not None and other is not None and one != other


def scalar_last(names: tuple[str, ...], text: str) -> bool | None:
    """Returns whether a quaternion is told to have its scalar last; None where it is not told."""
    last, first = names[-1][-1:] in "wsWS", names[0][-1:] in "wsWS"
    told_last = r"scalar.{0,12}last|last.{0,12}scalar|vector.{0,8}first|x\W*y\W*z\W*[ws]\b|jpl"
    told_first = r"scalar.{0,12}first|first.{0,12}scalar|vector.{0,8}last|\b[ws]\W*x\W*y\W*z|hamilton"
    last = last or re.search(told_last, text, re.I) is not None
    first = first or re.search(told_first, text, re.I) is not None
    return last if last != first else None


ROLL_FIRST = re.compile(r"rpy|roll.*pitch.*yaw", re.DOTALL)
SEQUENCE = re.compile(r"\b([xyz]{3})\b|\b([XYZ]{3})\b|\b([123])-?([123])-?([123])\b")


def rotation_form(text: str) -> str:
    """Returns which three numbers a text tells a rotation to be, as a mapping names them; empty where it does not."""
    low = text.lower()
    if "mrp" in words_of(text) or "rodrigues" in low:
        return "mrp"
    if re.search(r"rotation[ _-]?vector|rotvec", low):
        return "rotation vector"
    if not re.search(r"euler|roll|yaw|rpy", low):
        return ""
    match = SEQUENCE.search(text)
    if ROLL_FIRST.search(low) and (match is None or "".join(filter(None, match.groups())).lower() in ("zyx", "321")):
        return "euler xyz"  # the same rotation, by its angles in the other order
    letters = (
        "zyx" if match is None else (match[1] or match[2] or "".join("xyz"[int(d) - 1] for d in match.groups()[2:]))
    )
    if any(a == b for a, b in pairwise(letters)):
        return ""
    return f"euler {letters.lower() if re.search('fixed|extrinsic', low) else letters.upper()}"
