"""Writes attitude as a SPICE CK of type 3, with leap-second, clock and frame kernels and a meta-kernel that loads all.

The clock counts microseconds of TT from the epoch of the run, so a sample's ticks are exact. The C matrix of SPICE
takes components in the base frame to the body's, and angular velocities are in the base frame. SPICE has one frame
J2000 for EME2000 and GCRF, which it takes for the same. N is a frame with a fixed turn from J2000.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from orchestration.errors import InputError, Place, Problem

from .frames import from_N
from .instants import erfa, missing
from .motion import Motion

TICKS = 1_000_000
"""Of the clock in a second."""
_TT_AHEAD = 32.184
_MONTHS = "JAN FEB MAR APR MAY JUN JUL AUG SEP OCT NOV DEC".split()


def write(motion: Motion, folder: Path, name: str, spacecraft: int) -> list[Path]:
    """Writes the kernels `name.bc`, `.tls`, `.tsc`, `.tf` and the meta-kernel `.tm` into a folder, and returns them.

    `spacecraft` is its NAIF number, negative; that of the body's frame is 1000 times as much.
    Raises InputError without SpiceyPy, and OSError where a file cannot be written.
    """
    if not -1_000_000 < spacecraft < 0:
        expected, place = "a negative number of six digits at most", Place("--naif-id")
        raise InputError(Problem(expected=expected, found=str(spacecraft), place=place))
    try:
        import spiceypy  # optional, and slow to import  # noqa: PLC0415
    except ModuleNotFoundError:
        raise missing("spiceypy") from None
    folder.mkdir(parents=True, exist_ok=True)
    body = re.sub(r"\W+", "_", name.upper())[:20]
    texts = {
        ".tls": leap_seconds(),
        ".tsc": _clock(motion, spacecraft),
        ".tf": _frames(motion, body, spacecraft),
        ".tm": _meta(name),
    }
    for suffix, text in texts.items():
        (folder / f"{name}{suffix}").write_text(text, "ascii")
    pointing = folder / f"{name}.bc"
    pointing.unlink(missing_ok=True)
    _pointing(spiceypy, motion, pointing, body, spacecraft)
    return [pointing, *(folder / f"{name}{suffix}" for suffix in texts)]


def _pointing(spice: Any, motion: Motion, path: Path, body: str, spacecraft: int) -> None:
    ticks = motion.instants.time * TICKS
    to_body = np.ascontiguousarray(motion.q * [1.0, -1.0, -1.0, -1.0])
    rates = np.zeros((len(ticks), 3)) if motion.rate is None else np.einsum("nij,nj->ni", motion.R, motion.rate)
    base = f"{body}_N" if motion.frame == "N" else "J2000"
    handle = spice.ckopn(str(path), "attitude-cosim", 0)
    spice.furnsh(str(path.with_suffix(".tf")))  # SPICE looks up the base frame, and the frame kernel alone knows ours
    try:
        spice.ckw03(
            *(handle, ticks[0], ticks[-1], spacecraft * 1000, base, motion.rate is not None, "attitude of a run"),
            *(len(ticks), np.ascontiguousarray(ticks), to_body, np.ascontiguousarray(rates), 1, [ticks[0]]),
        )
        spice.ckcls(handle)
    finally:
        spice.unload(str(path.with_suffix(".tf")))


def leap_seconds() -> str:
    """Returns a leap-second kernel: the table of ERFA, and the series by which SPICE makes TDB of TT."""
    table = erfa().leap_seconds.get()
    rows = [
        f"{row['tai_utc']:.0f}, @{row['year']}-{_MONTHS[row['month'] - 1]}-1" for row in table if row["year"] >= 1972
    ]
    data = [
        f"DELTET/DELTA_T_A = {_TT_AHEAD}",
        "DELTET/K = 1.657D-3",
        "DELTET/EB = 1.671D-2",
        "DELTET/M = ( 6.239996D0 1.99096871D-7 )",
        "DELTET/DELTA_AT = ( " + "\n                    ".join(rows) + " )",
    ]
    return _kernel("LSK", "Leap seconds of the table of ERFA; TDB - TT = K sin(M + EB sin M).", data)


def _clock(motion: Motion, spacecraft: int) -> str:
    key, number = "SCLK", -spacecraft
    data = [
        f"{key}_KERNEL_ID = ( @{motion.instants.utc()[0][:19]} )",
        f"{key}_DATA_TYPE_{number} = ( 1 )",
        f"{key}01_TIME_SYSTEM_{number} = ( 2 )",
        f"{key}01_N_FIELDS_{number} = ( 2 )",
        f"{key}01_MODULI_{number} = ( 4294967296 {TICKS} )",
        f"{key}01_OFFSETS_{number} = ( 0 0 )",
        f"{key}01_OUTPUT_DELIM_{number} = ( 1 )",
        f"{key}_PARTITION_START_{number} = ( 0.0 )",
        f"{key}_PARTITION_END_{number} = ( {4294967296 * TICKS - 1}.0 )",
        f"{key}01_COEFFICIENTS_{number} = ( 0.0 {motion.instants.tt0_seconds!r} 1.0 )",
    ]
    return _kernel("SCLK", f"Seconds and microseconds of TT from {motion.instants.epoch} UTC.", data)


def _frames(motion: Motion, body: str, spacecraft: int) -> str:
    number = spacecraft * 1000
    data = [
        *_frame(f"{body}_BODY", number, 3, number, spacecraft),
        f"CK_{number}_SCLK = {spacecraft}",
        f"CK_{number}_SPK = {spacecraft}",
        f"NAIF_BODY_NAME += ( '{body}' )",
        f"NAIF_BODY_CODE += ( {spacecraft} )",
    ]
    if motion.frame == "N":
        turn = from_N("EME2000", motion.instants.tt0).T.ravel().tolist()  # SPICE reads it column by column
        other = number - 1
        data += [
            *_frame(f"{body}_N", other, 4, other, 399),
            f"TKFRAME_{other}_RELATIVE = 'J2000'",
            f"TKFRAME_{other}_SPEC = 'MATRIX'",
            f"TKFRAME_{other}_MATRIX = ( " + "\n    ".join(map(repr, turn)) + " )",
        ]
    about = f"{body}_BODY: the body. {body}_N: mean equator and equinox of {motion.instants.epoch} (IAU 1976)."
    return _kernel("FK", about, data)


def _frame(name: str, number: int, kind: int, id: int, center: int) -> list[str]:
    about = [("NAME", f"'{name}'"), ("CLASS", kind), ("CLASS_ID", id), ("CENTER", center)]
    return [f"FRAME_{name} = {number}", *(f"FRAME_{number}_{key} = {value}" for key, value in about)]


def _meta(name: str) -> str:
    files = ", ".join(f"'{name}{suffix}'" for suffix in (".tls", ".tsc", ".tf", ".bc"))
    return _kernel("MK", "Loads all kernels; to be loaded in their folder.", [f"KERNELS_TO_LOAD = ( {files} )"])


def _kernel(kind: str, about: str, data: list[str]) -> str:
    lines = [line for entry in data for line in entry.split("\n")]
    return "\n".join([f"KPL/{kind}", "", about, "", "\\begindata", "", *lines, "", "\\begintext", ""])
