"""What a call of the planned controller takes: processor time of every sample, and memory."""

from __future__ import annotations

import ctypes
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from orchestration import load
from orchestration.runner.run import run_blocks

from .. import native
from .cases import SEEDS, flight
from .run import BLOCKS


@dataclass(frozen=True)
class Calls:
    """What a call of the controller takes, in processor time."""

    count: int
    median: float
    """s"""
    rarely: float
    """A thousandth of the calls takes longer than this, s."""
    worst: float
    memory: int | None
    """Bytes of an instance, all it remembers and works in; None where the C library does not tell."""


class _Timed:
    """A block of the loop whose calls are timed, get and set included."""

    def __init__(self, block: Any) -> None:
        self.block = block
        self.spent: list[float] = []
        self.current = 0.0

    def __getattr__(self, name: str) -> Any:
        return getattr(self.block, name)

    def set_inputs(self) -> None:
        self.current = time.thread_time()
        self.block.set_inputs()

    def do_step(self, at: float, step: float) -> None:
        self.block.do_step(at, step)

    def get_live(self) -> None:
        self.block.get_live()
        self.spent.append(time.thread_time() - self.current)

    def get_all(self) -> None:
        self.block.get_all()
        self.spent.append(time.thread_time() - self.current)


def calls(seeds: Sequence[int] = range(SEEDS["errors"], SEEDS["errors"] + 10), duration: float = 2000.0) -> Calls:
    """Flies tumbles under all errors in the loop of Python, and times every sample of the controller."""
    fmus = native.pin(BLOCKS)
    spent: list[float] = []
    memory = None
    for seed in seeds:
        data = {**flight("errors", seed, errors=True).data, "duration": duration}
        with native.instances(load(data), fmus) as (ready, blocks):
            controller = _Timed(blocks["controller"])
            run_blocks(ready, {**blocks, "controller": controller}, compiled=False)
            spent += controller.spent[1:]  # the first is of the initialization
            memory = _memory(controller.block.component)
    times = np.array(spent)
    return Calls(len(times), float(np.median(times)), float(np.quantile(times, 0.999)), float(times.max()), memory)


def _memory(component: Any) -> int | None:
    """Bytes of an instance, which the native FMUs allocate as a whole; None where the C library does not tell."""
    size = getattr(ctypes.CDLL(None), "malloc_usable_size", None) if os.name == "posix" else None
    if size is None:
        return None
    size.restype, size.argtypes = ctypes.c_size_t, [ctypes.c_void_p]
    return int(size(component))
