"""Takes a run to a file of another format, an attitude ephemeris to a timeline, and both to their difference."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import yaml

from orchestration.errors import InputError, Place, Problem, writing
from orchestration.results.data import RunData
from orchestration.results.place import FILES, MANIFEST
from orchestration.results.whole import putting
from orchestration.scenario.scenario import Scenario
from orchestration.session.open import open_fmus
from orchestration.session.read import load

from . import ccsds, foxglove, hdf5, spice
from .aem import read
from .motion import Motion, Ports, angles, epoch_of, in_frame, motion, resampled
from .recorded import Recorded, recorded
from .reference import moving

FORMATS = {"aem": ".aem", "oem": ".oem", "mcap": ".mcap", "ck": "", "hdf5": ".h5"}
"""The formats, and what their files end in; the kernels of ck stand in a folder."""
_INERTIAL = 4
"""The supervisor's command for the mode that points as its input R_goal says."""


def convert(
    result: RunData | Recorded | Path,
    to: str,
    out: Path | None = None,
    ports: Ports = Ports(),  # noqa: B008  (it is frozen)
    frame: str = "EME2000",
    object_name: str | None = None,
    object_id: str = "UNKNOWN",
    naif_id: int = -9999,
) -> list[Path]:
    """Writes a run in one of `FORMATS` and returns the files.

    `out` is a file, for ck a folder; by default a file of the scenario's name in the working folder. AEM and OEM are
    XML where it ends in .xml, else KVN. `frame` (EME2000, GCRF, N) is that of AEM, OEM and CK; MCAP has N, HDF5 what
    was recorded. Raises InputError where a signal or a package is missing, and ResultsError where a file cannot be
    written.
    """
    if to not in FORMATS:
        raise InputError(Problem(expected=f"one of {', '.join(FORMATS)}", found=repr(to), place=Place("to")))
    data = result if isinstance(result, Recorded) else recorded(result)
    target = out if out is not None else Path(f"{data.name}{FORMATS[to]}" if to != "ck" else f"{data.name}-ck")
    if target.name in FILES and target.with_name(MANIFEST).exists():
        expected, found = "a file that is none of a run's own", str(target)
        raise InputError(Problem(expected=expected, found=found, place=Place("--out")))
    if to == "hdf5":
        try:
            epoch: str | None = epoch_of(data, ports.epoch)
        except InputError:
            epoch = None  # a run of other blocks may have none
        return _written(target, lambda path: hdf5.write(data, path, epoch))
    if to == "mcap":
        moving = motion(data, "N", ports)
        return _written(target, lambda path: foxglove.write(data, moving, path))
    moving = motion(data, frame, ports)
    if to == "ck":
        with writing(target):
            return spice.write(moving, target, data.name, naif_id)
    created = data.finished or datetime.now(UTC).isoformat()
    labels = ccsds.Labels(object_name or data.name, object_id, created[:19])
    text = (ccsds.aem if to == "aem" else ccsds.oem)(moving, labels, target.suffix.lower() == ".xml")
    return _written(target, lambda path: path.write_text(text, "utf-8"))


def _written(target: Path, write: Callable[[Path], object]) -> list[Path]:
    with writing(target):
        target.absolute().parent.mkdir(parents=True, exist_ok=True)
        with putting(target) as part:
            write(part)
    return [target]


@dataclass(frozen=True)
class Difference:
    """Difference of the attitude of a run from that of an ephemeris, over the instants of the run within it."""

    instants: int
    largest: float
    """rad."""
    rms: float
    """rad."""
    time: float
    """When it is largest, s."""

    def __str__(self) -> str:
        size = f"largest {self.largest:.4g} rad ({np.degrees(self.largest):.4g} deg) at {self.time:.10g} s"
        return f"attitude at {self.instants} instants: {size}, rms {self.rms:.4g} rad"


def difference(
    result: RunData | Recorded | Path,
    ephemeris: Path,
    ports: Ports = Ports(),  # noqa: B008  (it is frozen)
) -> Difference:
    """Returns the angle between the attitude of a run and that of an AEM, which is interpolated by SLERP.

    Raises InputError where they have no instant in common.
    """
    ours = motion(result if isinstance(result, Recorded) else recorded(result), "N", ports)
    theirs = in_frame(read(ephemeris, ours.instants.epoch), "N")
    time, other = ours.instants.time, theirs.instants.time
    within = (time >= other[0] - 1e-9) & (time <= other[-1] + 1e-9)
    if not within.any():
        expected = f"attitude within {time[0]:.10g} s to {time[-1]:.10g} s from {ours.instants.epoch}"
        found = f"{other[0]:.10g} s to {other[-1]:.10g} s"
        raise InputError(Problem(expected=expected, found=found, place=Place(str(ephemeris))))
    apart = angles(ours.q[within], resampled(time[within], other, theirs.q))
    worst = int(apart.argmax())
    return Difference(
        int(within.sum()), float(apart[worst]), float(np.sqrt(np.mean(apart**2))), float(time[within][worst])
    )


def _check_goal(loaded: Scenario, block: str, port: str, goal: str) -> None:
    """Raises InputError where the block has no such input of nine numbers."""
    try:
        model = open_fmus(loaded)[block].model
        variable, positions = model.find(block, port, of=["input"], kind="input")
    except InputError as error:
        raise InputError(*(problem.at(Place("--goal")) for problem in error.problems)) from None
    if variable.causality != "input" or len(positions) != 9:
        expected, found = "an input that is a real [3, 3]", f"{goal}, {variable.causality}, {variable.kind}"
        raise InputError(Problem(expected=expected, found=found, place=Place("--goal")))


def _course(ephemeris: Path, loaded: Scenario, epoch: str) -> tuple[str, Motion]:
    """The UTC of a scenario's t = 0, and the attitudes of an AEM from then, in N."""
    starts = {name: {**loaded.shared, **entry.start} for name, entry in loaded.blocks.items()}
    parameters = {name: {str(key): value for key, value in start.items()} for name, start in starts.items()}
    zero = epoch_of(Recorded(loaded.name, np.zeros(0), {}, parameters=parameters), epoch)
    return zero, in_frame(read(ephemeris, zero), "N")


def reference(ephemeris: Path, scenario: Path, out: Path, epoch: str) -> int:
    """Writes a scenario whose controllers follow an AEM as it moves, with its rate and acceleration, and a table beside
    it; returns the number of rows. Raises InputError as `moving` does."""
    course = _course(ephemeris, load(scenario), epoch)[1]
    text, table, rows = moving(scenario, out, course.instants.time, course.q, Place(str(ephemeris)))
    _written(out.with_suffix(".csv"), lambda path: path.write_text(table, "utf-8"))
    _written(out, lambda path: path.write_text(text, "utf-8"))
    return rows


def timeline(ephemeris: Path, scenario: Path, out: Path, goal: str, epoch: str) -> int:
    """Writes a scenario that extends another by the attitudes of an AEM, as values of an input; returns their number.

    `goal` is the input, a matrix N from body; of a supervisor it also commands the mode 'inertial'. `epoch` is the
    UTC at t = 0, or the parameter with it. Raises InputError where no attitude lies within the scenario's duration.
    """
    loaded = load(scenario)
    block, _, port = goal.partition(".")
    if block not in loaded.blocks or not port:
        expected, found = f"BLOCK.INPUT, a block of {', '.join(loaded.blocks)}", goal
        raise InputError(Problem(expected=expected, found=found, place=Place("--goal")))
    _check_goal(loaded, block, port, goal)
    zero, course = _course(ephemeris, loaded, epoch)
    last = loaded.duration - loaded.step
    times = course.instants.time
    # A value acts from the next step on; of several for one step the first counts.
    steps = np.ceil(times / loaded.step - 1e-9) + 0.0  # which makes 0 of -0
    kept = np.unique(steps, return_index=True)[1]
    kept = kept[(steps[kept] >= 0) & (steps[kept] * loaded.step <= last)]
    if not len(kept):
        expected = f"attitude within 0 s to {last:.10g} s from {zero}"
        found = f"{times[0]:.10g} s to {times[-1]:.10g} s"
        raise InputError(Problem(expected=expected, found=found, place=Place(str(ephemeris))))
    entries = [
        {"at": f"{steps[i] * loaded.step:.10g} s", "set": {goal: {"quaternion": [float(x) for x in course.q[i]]}}}
        for i in kept
    ]
    if port == "R_goal":
        entries[0]["set"] = {f"{block}.command": _INERTIAL, **entries[0]["set"]}  # type: ignore[dict-item]
    base = Path(scenario).resolve()
    data = {"extends": str(base), "name": out.stem, "expect": [], "timeline": entries}  # expectations are of its own
    text = yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=120)
    _written(out, lambda path: path.write_text(text, "utf-8"))
    return len(kept)
