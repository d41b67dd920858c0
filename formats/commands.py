"""The command `orchestrate convert`, registered in pyproject.toml.

Exit status: 0 all well; 1 the attitudes differ by more than the tolerance; 2 wrong input; 4 not written.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from orchestration.cli.console import say
from orchestration.cli.help import examples
from orchestration.cli.paths import PATH
from orchestration.errors import InputError, Problem
from orchestration.quantities import QuantityError, parse_unit, value_in

from .aem import is_aem
from .convert import FORMATS, convert, difference, reference, timeline
from .frames import FRAMES
from .motion import Ports
from .recorded import recorded

DIFFERS = 1
FROM_AEM = ("timeline", "reference")
"""What an AEM becomes."""
_PORTS = asdict(Ports())


def _port(name: str, what: str) -> Callable[[Any], Any]:
    return click.option(f"--{name}", default=_PORTS[name], show_default=True, metavar="NAME", help=what)


@click.command(
    "convert",
    epilog=examples(
        "orchestrate convert results/paper_singularity --to aem",
        "orchestrate convert results/paper_singularity --to oem --frame GCRF --out orbit.xml",
        "orchestrate convert results/paper_singularity --to ck --out kernels",
        "orchestrate convert results/flight --to mcap --attitude estimator.R_NB",
        "orchestrate convert results/flight --compare truth.aem --tolerance '0.1 deg'",
        "orchestrate convert plan.aem --to timeline --scenario mission.yaml --out planned.yaml",
        "orchestrate convert scan.aem --to reference --scenario mission.yaml --out scanned.yaml",
    ),
)
@click.argument("source", metavar="RESULT|FILE.aem", type=PATH)
@click.option("--to", type=click.Choice([*FORMATS, *FROM_AEM]), help="The format.")
@click.option("-o", "--out", type=PATH, metavar="FILE", help="File, .xml for XML; for ck a folder. Default: in RESULT.")
@click.option("--frame", type=click.Choice(FRAMES), default="EME2000", show_default=True, help="Of aem, oem and ck.")
@_port("attitude", "Signal of the attitude: matrix N from body, or quaternion, scalar first.")
@_port("rate", "Signal of the body rate.")
@_port("position", "Signal of the position.")
@_port("velocity", "Signal of the velocity.")
@_port("epoch", "Parameter with the UTC at t = 0, or that UTC.")
@click.option("--object-name", metavar="NAME", help="OBJECT_NAME; default: the scenario's name.")
@click.option("--object-id", metavar="ID", default="UNKNOWN", show_default=True, help="OBJECT_ID, such as 2009-041A.")
@click.option("--naif-id", type=int, default=-9999, show_default=True, help="The spacecraft's number in SPICE.")
@click.option("--compare", type=PATH, metavar="FILE.aem", help="Print how far the attitude is from that of an AEM.")
@click.option("--tolerance", metavar="A", help="With --compare: the largest angle, in rad or with a unit.")
@click.option("--scenario", type=PATH, metavar="FILE", help="From an AEM: the scenario that is extended.")
@click.option(
    "--goal", default="supervisor.R_goal", show_default=True, metavar="BLOCK.INPUT", help="With --to timeline."
)
@click.pass_context
def command(
    ctx: click.Context,
    source: Path,
    to: str | None,
    out: Path | None,
    frame: str,
    attitude: str,
    rate: str,
    position: str,
    velocity: str,
    epoch: str,
    object_name: str | None,
    object_id: str,
    naif_id: int,
    compare: Path | None,
    tolerance: str | None,
    scenario: Path | None,
    goal: str,
) -> None:
    """Write a run in a format of the field.

    Or compare it with an attitude ephemeris (--compare).

    RESULT is the folder of a run. From an AEM, --to timeline makes a scenario whose supervisor points as it says, and
    --to reference one whose controllers follow it as it moves.
    Exit status: 0 all well, 1 the attitudes differ by more than --tolerance, 2 wrong input, 4 not written.
    """
    if to is None and compare is None:
        raise InputError(Problem(expected="--to FORMAT or --compare FILE.aem", found="neither"))
    ports = Ports(attitude, rate, position, velocity, epoch)
    if to in FROM_AEM or is_aem(source):
        if to not in FROM_AEM or scenario is None or out is None or not is_aem(source):
            expected = f"FILE.aem --to {' or '.join(FROM_AEM)} --scenario SCENARIO --out FILE.yaml"
            raise InputError(Problem(expected=expected, found="other options for an AEM, or another file"))
        if to == "reference":
            say(f"{reference(source, scenario, out, epoch)} rows in {out.with_suffix('.csv')}, for {out}")
        else:
            say(f"{timeline(source, scenario, out, goal, epoch)} entries in {out}")
        return
    data = recorded(source)
    if to is not None:
        target = out or source / (f"{data.name}{FORMATS[to]}" if to != "ck" else "ck")
        for path in convert(data, to, target, ports, frame, object_name, object_id, naif_id):
            say(f"{path}  {path.stat().st_size / 1000:.0f} kB")
    if compare is None:
        return
    limit = _angle(tolerance)
    found = difference(data, compare, ports)
    say(str(found))
    if limit is not None and found.largest > limit:
        ctx.exit(DIFFERS)


def _angle(text: str | None) -> float | None:
    if text is None:
        return None
    try:
        return value_in(float(text) if text.replace(".", "", 1).isdigit() else text, parse_unit("rad"))
    except QuantityError as error:
        raise InputError(f"--tolerance {text}: {error}") from None
