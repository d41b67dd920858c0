"""Whether the proof of a block finds the faults that are planted in its C: that decides what the proof is worth."""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from fmus.places import PACKAGES
from orchestration import InputError
from orchestration.cli.console import say

from ..tools import side_by_side
from .analysis import Alarm
from .argued import arguments, unproved
from .contracts import CONTRACTS, Contract
from .faults import Fault, faults
from .rounds import FLIGHT_CODE
from .subjects import SUBJECTS, Subject


def found(fault: Fault, folder: Path) -> list[Alarm]:
    """The alarms of the expected kind that the fault gives, in copies of the sources in `folder`. Raises InputError."""
    root = folder / "packages"
    for package in FLIGHT_CODE:
        shutil.copytree(PACKAGES / package, root / package, ignore=_other_files)
    fault.plant(root)
    result = subject_of(fault.subject).prove(folder / "proof", root)
    return [alarm for alarm in unproved(result.alarms, arguments(), root) if alarm.kind == fault.kind]


def _other_files(folder: str, names: list[str]) -> list[str]:
    return [name for name in names if Path(folder, name).is_file() and Path(name).suffix not in (".c", ".h")]


def subject_of(title: str) -> Subject | Contract:
    """The proof of this title. Raises InputError where there is none."""
    proofs: tuple[Subject | Contract, ...] = (*SUBJECTS, *CONTRACTS)
    known = {proof.title: proof for proof in proofs}
    if title not in known:
        raise InputError(f"there is no proof {title!r}; expected one of {', '.join(known)}")
    return known[title]


def make(numbers: Sequence[int]) -> None:
    """Plants those of these numbers, from 1, or all. Raises InputError where one is not found."""
    missed = []
    began = time.monotonic()
    planted = [(n, fault) for n, fault in enumerate(faults(), start=1) if not numbers or n in numbers]
    for (number, fault), alarms in zip(planted, side_by_side(_found, [fault for _, fault in planted]), strict=True):
        say(f"{number}. {fault.subject}: {fault.about}: " + (f"found, {alarms[0]}" if alarms else "not found"))
        missed += [] if alarms else [number]
    say(f"{time.monotonic() - began:.0f} s")
    if missed:
        raise InputError(f"not found: {', '.join(map(str, missed))}")


def _found(fault: Fault) -> list[Alarm]:
    with tempfile.TemporaryDirectory() as temporary:
        return found(fault, Path(temporary))
