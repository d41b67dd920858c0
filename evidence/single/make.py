"""docs/evidence/single.md: the flight code in single precision, flown beside double precision, and its bits on an
emulated Cortex-M4."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fmus.block import Block
from orchestration import InputError, Result, load, run
from orchestration.session.read import read
from orchestration.swap.option import swapped, swaps_of

from .. import markdown
from ..paper import FOLDER, ROOT
from ..processor.firmware import CORTEX_M4
from ..processor.flights import Flight
from ..processor.flights import fly as fly_on_board
from .build import fmu, parts_of
from .translate import write

PAGE = ROOT / "docs" / "evidence" / "single.md"
SETTLED = "1 deg"
TIME, RMS, LEAST_RMS = 0.02, 0.1, math.radians(0.01)
"""Required: settled within 2% of the time in double precision, the hold's rms within 10% of it or 0.01 deg."""
FLOWN: tuple[tuple[str, dict[str, str]], ...] = (
    ("paper_no_singularity", {"controller": "controller"}),
    ("paper_no_singularity", {"allocator": "allocator"}),
    ("flight_tumble", {"allocator": "allocator_bounded"}),
    ("flight_tumble", {"controller": "controller_planned"}),
    ("flight_estimated", {"estimator": "estimator"}),
    ("track_ground_station", {"supervisor": "supervisor"}),
    ("flight_pyramid_planned", {"allocator": "allocator_bounded_wheels"}),
    ("flight_pyramid_planned", {"controller": "controller_planned_wheels"}),
    ("paper_no_singularity", {"controller": "controller", "allocator": "allocator"}),
    (
        "flight_estimated",
        {"estimator": "estimator", "controller": "controller_planned", "allocator": "allocator_bounded"},
    ),
    (
        "mission_day",
        {
            "estimator": "estimator",
            "supervisor": "supervisor",
            "controller": "controller_planned",
            "allocator": "allocator_bounded",
        },
    ),
)
"""Scenarios, and the blocks that fly in single precision, by their places."""
ON_BOARD = "60 s"
"""How long a block flies on the emulated processor."""
STEPS = (0.1, 0.5, 1.0, 2.0)


@dataclass(frozen=True)
class Pointing:
    """Pointing of one flight: settled from, s; rms and largest error after, rad; NaN where it does not settle."""

    settled: float
    rms: float
    largest: float


@dataclass(frozen=True)
class Pair:
    """A flight in both precisions."""

    scenario: str
    blocks: tuple[str, ...]
    double: Pointing
    single: Pointing
    apart: float
    """Largest difference of the attitude error once both have settled, rad."""

    @property
    def fits(self) -> bool:
        """Returns whether what is required holds."""
        slow = abs(self.single.settled - self.double.settled) <= TIME * max(self.double.settled, 1.0)
        return slow and abs(self.single.rms - self.double.rms) <= max(RMS * self.double.rms, LEAST_RMS)


BLOCKS = sorted({block for _, places in FLOWN for block in places.values()})


def sources(folder: Path) -> list[Path]:
    """Writes the translated C of each block, and returns its folders."""
    for block in BLOCKS:
        write(Block.named(block), folder / block)
    return [folder / block for block in BLOCKS]


def make() -> Path:
    """Flies, and writes the page. Raises InputError, CompilerError, BlockError."""
    fmus = {block: fmu(block, FOLDER / "single" / block) for block in BLOCKS}
    doubles = {name: run(ROOT / "scenarios" / f"{name}.yaml") for name in dict.fromkeys(name for name, _ in FLOWN)}
    pairs = [pair(name, places, doubles[name], flown(name, places, fmus)) for name, places in FLOWN]
    boards = [on_board(name, *place, fmus) for name, places in FLOWN if len(places) == 1 for place in places.items()]
    PAGE.write_text(page(pairs, boards), "utf-8")
    return PAGE


def page(pairs: list[Pair], boards: list[Flight]) -> str:
    """The page's text."""
    shown = {
        "flights": [_flight(p) for p in pairs],
        "boards": [_board(b) for b in boards],
        "fitting": f"{sum(p.fits for p in pairs)} of {len(pairs)}",
        "same": f"{sum(not b.differing for b in boards)} of {len(boards)}",
        "clocks": [_clock(h) for h in STEPS],
        "rounded": [f"to {np.spacing(np.float32(86400 * d)) / 2:.2g} s after {d} days" for d in (1, 10, 100)],
    }
    return markdown.render(Path(__file__).parent, **shown)


def flown(name: str, places: dict[str, str], fmus: dict[str, Path], **settings: str) -> Result:
    """The scenario with these blocks in single precision."""
    swaps = swaps_of([f"{place}={fmus[block]}" for place, block in places.items()])
    return run(load(swapped(read(ROOT / "scenarios" / f"{name}.yaml"), swaps), settings))


def on_board(name: str, place: str, block: str, fmus: dict[str, Path]) -> Flight:
    """The block on the emulated Cortex-M4, held against this machine's flight in single precision."""
    settings = {"duration": ON_BOARD}
    here = flown(name, {place: block}, fmus, **settings)
    path, folder = ROOT / "scenarios" / f"{name}.yaml", FOLDER / "single" / "firmware"
    return fly_on_board(path, place, folder, here, CORTEX_M4, parts_of, settings)


def pair(name: str, places: dict[str, str], double: Result, single: Result) -> Pair:
    """Both flights by the judge's attitude error. Raises InputError where they have other samples."""
    errors = [np.asarray(result["judge.attitude_error"], float) for result in (double, single)]
    if len(errors[0]) != len(errors[1]):
        raise InputError(f"{name}: expected {len(errors[0])} samples in single precision, found {len(errors[1])}")
    of_double, of_single = _pointing(double), _pointing(single)
    since = np.asarray(double.time) >= max(of_double.settled, of_single.settled)
    apart = float(np.max(np.abs(errors[0] - errors[1])[since])) if since.any() else math.nan
    return Pair(name, tuple(places.values()), of_double, of_single, apart)


def _pointing(result: Result) -> Pointing:
    found = result.settling("judge.attitude_error", SETTLED)
    return Pointing(math.nan if found.time is None else found.time, found.rms, found.largest)


def clock(h: float) -> tuple[float, float]:
    """Until when t + h in single precision is right to 1 s, and where it stands still, s; infinite beyond a year."""
    n = min(int(3.2e7 / h), 40_000_000)
    t = np.add.accumulate(np.full(n, h, np.float32))
    exact = np.arange(1, n + 1) * h
    wrong, still = np.abs(t - exact) > 1.0, np.diff(t) == 0.0
    until = [float(exact[np.argmax(x)]) if x.any() else math.inf for x in (wrong, still)]
    return until[0], until[1]


def _flight(p: Pair) -> tuple[str, ...]:
    blocks = ", ".join(f"`{block}`" for block in p.blocks)
    times = f"{p.double.settled:.1f}, {p.single.settled:.1f}"
    rms, largest = (f"{_degrees(getattr(p.double, x))}, {_degrees(getattr(p.single, x))}" for x in ("rms", "largest"))
    return (blocks, f"`{p.scenario}`", times, rms, largest, _degrees(p.apart), "met" if p.fits else "failed")


def _degrees(x: float) -> str:
    return f"{math.degrees(x):.2g}"


def _board(f: Flight) -> tuple[str, ...]:
    same = "all" if not f.differing else f"all but {', '.join(f'`{name}`' for name in f.differing)}"
    longest = max(f.start, int(f.calls.max()))
    numbers = (f"{n:,}".replace(",", " ") for n in (f.samples, f.firmware.code, f.firmware.stack, longest))
    samples, *rest = numbers
    return (f"`{f.block}`", samples, same, *rest, "the date" if f.firmware.doubles else "nothing")


def _clock(h: float) -> tuple[str, ...]:
    return (f"{h:g} s", *(_time(t) for t in clock(h)))


def _time(t: float) -> str:
    if not math.isfinite(t):
        return "not within a year"
    return f"{t / 3600.0:.1f} h" if t < 86400.0 else f"{t / 86400.0:.0f} days"
