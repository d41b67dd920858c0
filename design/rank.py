"""`orchestrate rank`: laws in Python and those to compare with, on the same tumbles, as a table."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np

from fmus.interface import BLOCKS
from fmus.interface import load as interface
from orchestration import InputError, rotation
from orchestration import load as load_scenario
from orchestration.cli.console import Progress, complain, say, say_table
from orchestration.cli.help import examples
from orchestration.cli.options import Between
from orchestration.cli.status import BLOCK_FAILED, EXPECTATION_FAILED
from orchestration.cli.watch import watched
from orchestration.errors import BlockError, writing
from orchestration.results.settling import Settling, settling
from orchestration.results.whole import putting
from orchestration.scenario.source import Source
from orchestration.session.read import read
from orchestration.session.run import whole

from .allocated import allocated
from .lasting import LASTING
from .plausible import NONE, goal

LAWS = Path(__file__).parent / "laws"
COMPARED = ("bdot", "pd", "unloading", "lqr", "paper")
ERROR, WHEELS = "judge.attitude_error", "plant.h_w"
OWN = "the scenario's own"
COLUMNS = ("median, s", "worst, s", "rms after, deg", "largest after, deg", "wheel, N.m.s")


@dataclass(frozen=True)
class Row:
    """Results of a law over all tumbles, in degrees, seconds and N m s."""

    law: str
    settled: int
    runs: int
    failed: int
    median: float
    """Of the time to settle; infinite where less than half of them settled."""
    worst: float
    rms: float
    """Median, of those that settled, of the rms of the error after it."""
    largest: float
    momentum: float
    """The largest of a wheel over all runs."""


def tumbles(count: int, rate: float, seed: int) -> list[dict[str, Any]]:
    """Returns start values: attitudes uniform over all, rates of one size, rad/s, in all directions."""
    rng = np.random.default_rng(seed)
    drawn = []
    for number in range(count):
        q = rng.normal(size=4)
        Q = np.array(rotation.matrix((q / np.linalg.norm(q)).tolist())).reshape(3, 3).tolist()
        axis = rng.normal(size=3)
        drawn.append(
            {"plant.Q0": Q, "plant.omega_B0": (rate * axis / np.linalg.norm(axis)).tolist(), "sensors.seed": number + 1}
        )
    return drawn


def with_law(source: Source, place: str, law: Path) -> Source:
    """Returns the scenario with a law in the place of a block, with the ports of what stood there."""
    entry = dict(source.data["blocks"][place])
    entry["interface"] = entry.get("interface") or entry.pop("fmu", place)
    entry.pop("fmu", None)
    return source.with_entry(("blocks", place), {**entry, "python": str(law.resolve())})


def ranked(laws: Mapping[str, Source], starts: Sequence[Mapping[str, Any]], below: float, bar: Progress) -> list[Row]:
    """Flies the scenario of each law on each tumble and returns its rows, the one that settles most and soonest first.

    `below` rad is the error below which a flight is settled for good. Raises InputError.
    """
    rows: list[Row] = []
    for name, source in laws.items():
        rows.append(_row(name, source, starts, below))
        bar(len(rows))
    return sorted(rows, key=lambda row: (-row.settled, row.median, row.rms))


def for_good(time: np.ndarray, error: np.ndarray, below: float) -> Settling:
    """Returns how an error (n,) settles; one that was at or above `below` in the last sixth of the flight does not."""
    one = settling(time, error, below)
    late = one.time is not None and one.time > (1.0 - LASTING) * time[-1]
    return Settling(below, None, math.nan, math.nan) if late else one


def _row(name: str, source: Source, starts: Sequence[Mapping[str, Any]], below: float) -> Row:
    found, momenta, failed = [], [0.0], 0
    said: set[str] = set()
    for values in starts:
        flown = source
        for start, value in values.items():
            if start.partition(".")[0] in source.data["blocks"]:
                flown = flown.with_start(start, value)
        try:
            result = whole(load_scenario(flown))
        except BlockError as error:
            raise InputError(str(error)) from None
        if result.failure is not None:
            failed += 1
            if (told := f"{name}: {result.failure}") not in said:
                say(told, error=True, fg="yellow")
            said.add(told)
            continue
        found.append(for_good(result.time, np.asarray(result[ERROR]), below))
        momenta.append(float(np.abs(result[WHEELS]).max()))
    settled = [one for one in found if one.time is not None]
    times = sorted([one.time if one.time is not None else math.inf for one in found] + [math.inf] * failed)
    degrees = [math.degrees(one.rms) for one in settled]
    return Row(
        name,
        len(settled),
        len(starts),
        failed,
        times[(len(times) - 1) // 2],
        times[-1],
        float(np.median(degrees)) if degrees else math.nan,
        max((math.degrees(one.largest) for one in settled), default=math.nan),
        max(momenta),
    )


def compared(source: Source, place: str) -> dict[str, Source]:
    """Returns by name the scenarios to compare with: the file's own, and laws that demand a torque in the place of a
    block. Where that block commands a set of wheels, the bounded allocator stands behind them, and the planned
    controller flies, too; none where it commands anything else."""
    entry = source.data["blocks"][place]
    kind = entry.get("interface") or entry.get("fmu")
    outputs = set(interface(kind).variables) if kind in BLOCKS else {"tau_cmd_B"}
    files = {name: LAWS / f"{name}.py" for name in COMPARED}
    if "tau_cmd_B" in outputs:
        return {OWN: source, **{name: with_law(source, place, file) for name, file in files.items()}}
    if kind == "controller_wheels":
        laws = {name: allocated(source, place, file) for name, file in files.items()}
        return {OWN: source, **laws, "planned": allocated(source, place, None)}
    say(f"note: {', '.join(COMPARED)} are left out: they give tau_cmd_B, which {kind} does not have", error=True)
    return {OWN: source}


@click.command(
    epilog=examples(
        "orchestrate rank my_law.py --scenario mine/tumble.yaml",
        "orchestrate rank my_law.py other.py --scenario mine/tumble.yaml --runs 20 --out ranked.csv",
    )
)
@click.argument("laws", nargs=-1, type=click.Path(path_type=Path), metavar="LAW...")
@click.option("--scenario", required=True, type=click.Path(path_type=Path), metavar="FILE", help="The loop to fly in.")
@click.option("--place", default="controller", show_default=True, help="The block in whose place the laws stand.")
@click.option("--runs", default=5, show_default=True, type=click.IntRange(1), help="Tumbles that each law flies.")
@click.option("--rate", default=4.0, show_default=True, type=Between(0.0, 500.0),
              help="Size of the body rate at the start, deg/s.")  # fmt: skip
@click.option("--below", type=Between(0.0, 181.0, min_open=True), metavar="DEG",
              help="Error below which a flight is settled for good, deg: to its end, and for its last sixth at least; "
              "if not given, what the scenario expects, else 15."
)  # fmt: skip
@click.option("--duration", metavar="T", help="Of each flight, instead of the scenario's.")
@click.option("--seed", default=1, show_default=True, type=click.IntRange(0), help="Of the tumbles.")
@click.option("--alone", is_flag=True, help="Only these laws, without those to compare with.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Write the table to this CSV file.")
@click.pass_context
def command(
    ctx: click.Context,
    laws: tuple[Path, ...],
    scenario: Path,
    place: str,
    runs: int,
    rate: float,
    below: float | None,
    duration: str | None,
    seed: int,
    alone: bool,
    out: Path | None,
) -> None:
    """Fly laws in Python on the same tumbles and write a table.

    Beside them fly what stands in the scenario itself, B-dot, quaternion feedback (pd), the same with a wheel that the
    rods empty (unloading), a linear-quadratic regulator (lqr) and the paper's law with gains for the satellite (paper),
    unless --alone is given.

    Exit status: 0 a law settles in a tumble, 1 none does, 2 wrong input, 3 every flight of a law failed.
    """
    source = read(scenario)
    if not isinstance(source.data, dict) or place not in source.data.get("blocks", {}):
        raise InputError(f"{scenario}: expected a scenario with a block {place!r}")
    below = below or math.degrees(goal(load_scenario(source)) or math.radians(15.0))
    source = source.without([("expect",), ("figures",), ("live",)])
    source = source.with_entry(("record",), {"interval": "2 s", "signals": [ERROR, WHEELS]})
    if duration is not None:
        source = source.with_value("duration", duration, "--duration")
    others = {} if alone else compared(source, place)
    own = dict.fromkeys(others, "a law to compare with, unless --alone is given")
    flown = {}
    for law in laws:
        if law.stem in own:
            raise InputError(f"{law}: the name {law.stem!r} is that of {own[law.stem]}; remedy: rename the file")
        flown[law.stem], own[law.stem] = with_law(source, place, law), str(law)
    for law in laws[:1]:  # the others stand in the same place
        ctx.with_resource(watched(load_scenario(flown[law.stem]), lost="no table is written"))
    flown |= others  # the new ones first, so that their errors are told soon
    bar = Progress(len(flown), True, "laws")
    try:
        rows = ranked(flown, tumbles(runs, math.radians(rate), seed), math.radians(below), bar)
    finally:
        bar.close()
    say(f"settled: attitude error below {below:.4g} deg for good")
    say_table(
        ("law", "settled", *COLUMNS),
        [
            (
                r.law,
                f"{r.settled} of {r.runs}",
                _shown(r.median, ".0f"),
                _shown(r.worst, ".0f"),
                _shown(r.rms, ".3g"),
                _shown(r.largest, ".3g"),
                _shown(r.momentum if r.momentum > NONE else math.inf, ".3g"),
            )
            for r in rows
        ],
    )
    if out is not None:
        with writing(out), putting(out) as part, part.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(("law", "settled", "runs", "failed", *COLUMNS))
            writer.writerows(["" if v == math.inf or v != v else v for v in asdict(row).values()] for row in rows)
        say(f"written: {out}")
    if lost := [row.law for row in rows if row.failed == row.runs]:
        complain(f"every flight of {', '.join(lost)} failed")
        ctx.exit(BLOCK_FAILED)
    if not any(row.settled for row in rows):
        complain(f"no law settles for good below {below:g} deg; remedy: a longer --duration, or --below")
        ctx.exit(EXPECTATION_FAILED)


def _shown(value: float, form: str) -> str:
    return f"{value:{form}}" if math.isfinite(value) else "–"
