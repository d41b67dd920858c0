"""The commands `orchestrate calibrate`, `orchestrate identify` and `orchestrate ephemeris`, registered in
pyproject.toml.

Exit status: 0 all well; 1 the record does not show what is asked for; 2 wrong input. Tests:
tests/inflight/test_commands.py."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import click
import numpy as np

from estimator.bank import Noise
from orchestration import InputError
from orchestration.cli.console import say, say_table
from orchestration.cli.help import examples
from orchestration.errors import writing
from orchestration.quantities import SECOND, QuantityError, parse_unit, value_in
from orchestration.results.whole import parsed
from plant.time_scales import parse_epoch

from .attitude import attitudes
from .gyro import spin
from .magnetometer import Calibration, calibrate, symmetric
from .nutation import Motion, forecast, identify, left_out, starting
from .orbit import borders, followed, orbit_at, read_elements
from .records import Flight, read

NOT_SHOWN = 1
FILE = click.Path(path_type=Path, exists=False)
_ROWS_MAX = 10_000_000
"""Of an ephemeris: half a gigabyte."""
OUT = click.option("--out", type=FILE, metavar="FILE", help="Also write the result as JSON.")


@click.group(
    "calibrate",
    epilog=examples("orchestrate calibrate magnetometer log.yaml", "orchestrate calibrate gyro log.yaml"),
)
def calibrate_() -> None:
    """Calibrate sensors by a log in flight."""


@calibrate_.command(
    "magnetometer",
    epilog=examples(
        "orchestrate calibrate magnetometer log.yaml",
        "orchestrate calibrate magnetometer log.yaml --out magnetometer.json",
    ),
)
@click.argument("file", type=FILE)
@click.option(
    "--known",
    type=FILE,
    metavar="FILE",
    help="A result of this command: its matrix and offset stay, the gain is fitted.",
)
@OUT
@click.pass_context
def magnetometer(ctx: click.Context, file: Path, known: Path | None, out: Path | None) -> None:
    """Calibrate a magnetometer without attitude.

    Fits bias, scale, misalignment and a drifting gain to the size of the geomagnetic field along the orbit, and says
    what the record shows of each. Exit status 1 where it does not show all.
    """
    flight = read(file)
    found = _calibrated(flight, None if known is None else _known(known))
    data = found.data(flight.field_unit)
    say(
        f"{flight.name}: {len(flight.t)} rows over {np.ptp(flight.t):.0f} s, |B| rms {1e6 * found.rms:.2f} uT",
        bold=True,
    )
    values = [*found.A[np.triu_indices(3)], *(1e6 * found.bias)]
    scale = np.concatenate((np.ones(6), np.full(3, 1e6)))
    rows = [
        (name, f"{value:.4f}", f"{sigma:.4f}", verdict)
        for (name, verdict), value, sigma in zip(data["verdict"].items(), values, found.sigma[:9] * scale, strict=True)
    ]
    say_table(("b in uT", "value", "sigma", "verdict"), rows)
    if len(found.gain) > 1:
        say(f"gain {found.gain.min():.4f} to {found.gain.max():.4f} over {len(found.gain)} knots")
    _write(out, data)
    ctx.exit(0 if known is not None or set(data["verdict"].values()) == {"shown"} else NOT_SHOWN)


@calibrate_.command("gyro", epilog=examples("orchestrate calibrate gyro log.yaml --out gyro.json"))
@click.argument("file", type=FILE)
@click.option("--known", type=FILE, metavar="FILE", help="A calibration of the magnetometer, of another record.")
@OUT
@click.pass_context
def gyro(ctx: click.Context, file: Path, known: Path | None, out: Path | None) -> None:
    """Estimate bias and scale of a gyro from a spin, by the field.

    A bank of filters starts from all attitudes that the field allows. Exit status 1 where several fit to the end:
    then the attitude, and with it the gyro's error, is ambiguous. It is also 1 where the error is beyond what can be.
    """
    flight, noise = read(file), Noise()
    found = symmetric(_calibrated(flight, None if known is None else _known(known)))
    seen = spin(flight, attitudes(flight, found.field(flight.t, flight.m), flight.orbit.field_N(), noise))
    data = seen.data(noise, flight.rate_unit)
    say(f"{flight.name}: attitude {seen.attitude}", bold=True)
    degrees = math.degrees(1.0)
    along = f"{seen.along * degrees:.3f} deg/s, sigma {seen.along_sigma * degrees:.3f}"
    across = f"{np.linalg.norm(seen.across) * degrees:.3f} deg/s, sigma {seen.across_sigma * degrees:.3f}"
    say_table(("rate as measured less the true one", ""), [("along the spin", along), ("across it", across)])
    say_table(("", "verdict"), list(data["verdict"].items()))
    _write(out, data)
    ctx.exit(0 if seen.attitude.startswith("unique") else NOT_SHOWN)


@click.command("identify", epilog=examples("orchestrate identify log1.yaml log2.yaml --fit '100 s'"))
@click.argument("files", type=FILE, nargs=-1, required=True)
@click.option(
    "--fit", "fit_", default="100 s", show_default=True, metavar="T", help="The part of each record that is fitted."
)
@OUT
@click.pass_context
def identify_(ctx: click.Context, files: tuple[Path, ...], fit_: str, out: Path | None) -> None:
    """Identify ratios of inertia from free motion.

    Forecasts the rest of each record, also with the inertia that the other records show. Exit status 1 where the
    records do not show the ratios.
    """
    try:
        end = value_in(fit_, SECOND)
    except QuantityError as error:
        raise InputError(f"--fit {fit_}: {error}") from None
    flights = [read(file) for file in files]
    motions = [Motion(f.name, f.t, f.omega) for f in flights]
    early = [m.until(end) for m in motions]
    found = identify(early)
    data = found.data()
    say(f"J = turn diag({found.ratios[0]:.4f}, 1, {found.ratios[1]:.4f}) turn^T", bold=True)
    say(
        f"sigma of the ratios {found.ratio_sigma[0]:.4f} and {found.ratio_sigma[1]:.4f}; rms "
        f"{np.degrees(found.rms):.4f} deg/s"
    )
    rows = []
    for i, (motion, part) in enumerate(zip(motions, early, strict=True)):
        late = motion.t - motion.t[0] > end
        if late.any():
            bodies = [found, *([left_out(early, found, i)] if len(early) > 1 else [])]
            ahead = [forecast(motion, body, starting(part, body))[late] - motion.omega[late] for body in bodies]
            rms = [f"{np.degrees(np.sqrt(np.mean(off**2))):.4f}" for off in ahead]
            rows.append((motion.name, rms[0], rms[1] if len(rms) > 1 else "-", str(int(late.sum()))))
    say_table(("forecast", "rms, deg/s", "with the inertia of the other records", "rows"), rows)
    say_table(("", "verdict"), list(data["verdict"].items()))
    _write(out, data)
    ctx.exit(0 if data["verdict"]["ratios"] == "shown" else NOT_SHOWN)


@click.command(
    "ephemeris",
    epilog=examples("orchestrate ephemeris tle.txt --start 2024-03-08T04:40:00Z --duration '2 h' --out orbit.csv"),
)
@click.argument("tle", type=FILE)
@click.option("--start", required=True, metavar="UTC", help="The instant of t = 0.")
@click.option("--duration", required=True, metavar="T", help="How long.")
@click.option("--step", default="10 s", show_default=True, metavar="T", help="From row to row.")
@click.option("--out", type=FILE, required=True, metavar="FILE", help="The CSV file.")
def ephemeris(tle: Path, start: str, duration: str, step: str, out: Path) -> None:
    """Write the orbit of element sets (SGP4) as a log.

    Position and velocity in N, for a `telemetry` block.

    Also prints what puts a plant on this orbit.
    """
    try:
        epoch = parse_epoch(start)
    except ValueError as error:
        raise InputError(f"--start {start}: {error}") from None
    length, interval = _seconds("--duration", duration), _seconds("--step", step)
    if interval > length:
        raise InputError(f"--step {step}: expected at most --duration, {duration}")
    if length > _ROWS_MAX * interval:
        raise InputError(f"--duration {duration}: expected at most {_ROWS_MAX:,} steps of {step}")
    orbit = orbit_at(read_elements(tle), epoch, np.arange(0.0, length + 0.5 * interval, interval))
    with writing(out), out.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("t", *(f"r_N{i} [m]" for i in "123"), *(f"v_N{i} [m/s]" for i in "123")))
        writer.writerows(np.column_stack((orbit.t, orbit.r_N, orbit.v_N)).tolist())
    say(
        f"{out}: {len(orbit.t)} rows, by elements {abs(orbit.age):.2f} days "
        f"{'before' if orbit.age > 0 else 'after'} the middle"
    )
    values, near = followed(orbit)
    say(f"plant: {near}, with the start values")
    for name, value in values.items():
        say(f"  {name}: {json.dumps(value)}")


def _seconds(option: str, text: str) -> float:
    """A time above zero. Raises InputError."""
    try:
        value = value_in(text, SECOND)
    except QuantityError as error:
        raise InputError(f"{option} {text}: {error}") from None
    if not 0.0 < value < math.inf:
        raise InputError(f"{option} {text}: expected a time above 0")
    return value


def _calibrated(flight: Flight, known: Calibration | None) -> Calibration:
    size = np.linalg.norm(flight.orbit.field_N(), axis=1)
    return calibrate(flight.t, flight.m, size, known, breaks=borders(flight.orbit))


def _known(path: Path) -> Calibration:
    try:
        data = parsed(path)
        A, offset, gain = (np.array(data[key], float) for key in ("matrix", "offset", "gain"))
        if A.shape != (3, 3) or offset.shape != (len(gain), 4) or gain.shape[1] != 2:
            raise ValueError("shapes")
        offset[:, 1:] *= parse_unit(data["unit"]).factor
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(f"{path}: expected what 'orchestrate calibrate magnetometer --out' writes") from None
    bias = offset[:, 1:].mean(axis=0)
    covariance = np.zeros((9 + 4 * len(gain),) * 2)
    upper = np.linalg.qr(A)[1]
    A = upper * np.sign(np.diag(upper))[:, None]
    return Calibration(A, bias, gain[:, 0], gain[:, 1], offset[:, 1:] - bias, covariance, math.nan, np.empty(0))


def _write(out: Path | None, data: dict[str, Any]) -> None:
    if out is not None:
        with writing(out):
            out.write_text(json.dumps(data, indent=1) + "\n", "utf-8")
