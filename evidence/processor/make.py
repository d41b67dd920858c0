"""docs/evidence/processor.md: what the flight code costs on a Cortex-M7, from flights with each block on the emulated
processor."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from orchestration import InputError, run

from .. import markdown
from ..paper import FOLDER, ROOT
from .flights import Flight, fly

FOLDER_OF = FOLDER / "processor"
FLOWN = {"paper_no_singularity": ("controller", "allocator"), "flight_tumble": ("controller", "allocator")}
"""Scenarios, and in each the places of the blocks that fly on the processor, one at a time."""
BOUNDS = {"controller_planned": 18_000_000}
"""The most instructions of a call, by construction."""
PAGE = ROOT / "docs" / "evidence" / "processor.md"


def make() -> Path:
    """Flies, and writes the page.

    Raises InputError where a program is not installed or a call takes more than BOUNDS, BlockError where a call fails.
    """
    flights = []
    for scenario, places in FLOWN.items():
        path = ROOT / "scenarios" / f"{scenario}.yaml"
        native = run(path)
        flights += [fly(path, place, FOLDER_OF / scenario, native) for place in places]
    for f in flights:
        _check(f)
    PAGE.write_text(markdown.render(Path(__file__).parent, **fields(flights)), "utf-8")
    return PAGE


def _check(f: Flight) -> None:
    longest, bound = max(f.start, int(f.calls.max())), BOUNDS.get(f.block)
    if bound is not None and longest > bound:
        raise InputError(
            f"{f.block} in {f.scenario}: a call took {longest} instructions, expected at most {bound}; "
            "remedy: measure the parts in controller/planned/native/work.h again"
        )


def fields(flights: Sequence[Flight]) -> dict[str, object]:
    """Returns what the page's template shows."""
    return {
        "bounds": [f"`{block}` {_thousands(bound)}" for block, bound in BOUNDS.items()],
        "sizes": [_size(f) for f in flights],
        "calls": [_calls(f) for f in flights],
        "same": f"{sum(not f.differing for f in flights)} of {len(flights)}",
        "bits": [(f.block, f"`{f.scenario}`", str(f.samples), _same(f)) for f in flights],
    }


def _size(f: Flight) -> tuple[str, ...]:
    firmware = f.firmware
    numbers = (firmware.code, firmware.ram, firmware.stack, f.stack, firmware.whole_code, firmware.whole_ram)
    return (f"`{f.block}`", *(_thousands(n) for n in numbers))


def _calls(f: Flight) -> tuple[str, ...]:
    longest = int(f.calls.max())
    numbers = (f.start, int(np.median(f.calls)), int(np.quantile(f.calls, 0.99, method="higher")), longest)
    clock = longest / f.period / 1e6
    return (f"`{f.block}`", *(_thousands(n) for n in numbers), f"{f.period:g} s", f"{clock:.3g} MHz")


def _same(f: Flight) -> str:
    return "all" if not f.differing else f"all but {', '.join(f'`{name}`' for name in f.differing)}"


def _thousands(n: int) -> str:
    return f"{n:,}".replace(",", " ")
