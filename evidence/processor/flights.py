"""The loop with one block on the emulated processor, in lock-step, held against the native FMU's run sample by
sample."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fmus import link
from fmus.block import Block
from fmus.interface import load as load_interface
from orchestration import Result, load, run
from orchestration.session.read import read
from orchestration.swap.option import swapped, swaps_of

from .emulator import Emulator
from .firmware import CORTEX_M7, Board, Firmware, Part, build, parts_of

TIME_OUT = 60.0  # s of wall time for the longest call


@dataclass(frozen=True)
class Flight:
    """A block's flight on the emulated processor."""

    scenario: str
    place: str
    block: str
    firmware: Firmware
    start: int
    """Instructions of the call that starts the run."""
    calls: npt.NDArray[np.int64]
    """Instructions of each call after it."""
    stack: int
    """Bytes of stack, by painting."""
    differing: list[str]
    """Signals that differ from the native FMU's run in any bit of any sample."""
    samples: int
    period: float
    """Between two samples of the block, s."""


def fly(
    path: Path,
    place: str,
    folder: Path,
    native: Result,
    board: Board = CORTEX_M7,
    made_of: Callable[[Block, Path], list[Part]] = parts_of,
    settings: Mapping[str, Any] | None = None,
) -> Flight:
    """Flies a scenario, with other settings, with the block at `place` on the processor, against the run `native`.

    Raises InputError, and BlockError where a call fails.
    """
    name = str(read(path).data["blocks"][place]["fmu"])
    firmware = build(name, folder / name, board, made_of)
    fmu = folder / f"{name}_link.fmu"
    fmu.write_bytes(link.package(load_interface(name), "host"))
    with Emulator(firmware.elf, board) as running:
        line = {"link_transport": "tcp", "link_address": running.address, "link_time_out": TIME_OUT}
        linked = swapped(read(path), swaps_of([f"{place}={fmu}"]))
        flown = run(load(linked, {**(settings or {}), **{f"{place}.{key}": value for key, value in line.items()}}))
        calls = running.calls
    return Flight(
        flown.scenario.name,
        place,
        name,
        firmware,
        int(calls[calls[:, 2] == 1, 0].max()),
        calls[calls[:, 2] == 0, 0],
        int(calls[-1, 1]),
        [s for s in native.signals if flown[s].tobytes() != native[s].tobytes()],
        len(native.time),
        flown.scenario.step * flown.scenario.blocks[place].every,
    )
