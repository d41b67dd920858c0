"""What a call of the planned controller takes: processor time of every sample, and memory."""

from __future__ import annotations

import ctypes
import os
import time
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from orchestration.session.flight import with_values
from orchestration.session.open import open_scenario
from orchestration.session.run import run_blocks

from .cases import SEEDS, tumbles


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


def calls(tumbled: int = 10, duration: float = 2000.0) -> Calls:
    """Flies the first tumbles under all errors in the loop of Python, and times every sample of the controller."""
    spent: list[float] = []
    memory = None
    wanted = replace(tumbles("calls", SEEDS["errors"], tumbled, errors=True), duration=duration, early=duration).case
    draws = wanted.job.draws
    for point in wanted.job.design.points(range(tumbled)).tolist():
        opened = open_scenario(with_values(wanted.scenario, draws.given(draws.at(point))))
        with ExitStack() as stack:
            blocks = opened.instantiate(stack)
            controller = _Timed(blocks["controller"])
            run_blocks(opened.plan, {**blocks, "controller": controller}, compiled=False)
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
