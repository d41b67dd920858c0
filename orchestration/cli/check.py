"""`orchestrate check`: finds out whether an FMU can take a block's place.

Tests: tests/orchestration/acceptance/test_check.py.
"""

from __future__ import annotations

import math
from pathlib import Path

import click

from ..acceptance.check import check
from ..acceptance.log import against_log
from ..acceptance.suggest import suggest as proposed
from ..acceptance.vector import play
from ..errors import InputError
from ..fmu.archive import shown
from ..session.read import load, read
from ..swap.findings import Finding
from .console import folded, say, say_json, say_table
from .help import examples
from .options import as_json
from .paths import PATH
from .status import DOES_NOT_FIT


@click.command(
    "check",
    epilog=examples(
        "orchestrate check vendor.fmu --as allocator",
        "orchestrate check vendor.fmu --as allocator --map mapping.yaml --scenario loop.yaml",
        "orchestrate check allocator.fmu --as allocator --vector vector --json",
        "orchestrate check controller.fmu --as controller --telemetry log.yaml --tolerance 0.01",
    ),
)
@click.argument("fmu", type=PATH)
@click.option("--as", "as_", required=True, metavar="BLOCK", help="The block that it replaces, or a reference .fmu.")
@click.option("--map", "map_", type=PATH, metavar="FILE", help="Mapping of its ports to ours.")
@click.option(
    "--scenario",
    type=PATH,
    metavar="FILE",
    help="Also name the expectations of this scenario that read an output of this FMU itself.",
)
@click.option("--vector", type=PATH, metavar="DIR", help="Also run it on a test vector of the kit.")
@click.option(
    "--telemetry",
    type=PATH,
    metavar="FILE",
    help="Also run it, open loop, on the inputs of a recorded log, and compare its outputs with those of the log.",
)
@click.option(
    "--tolerance",
    default=1e-6,
    show_default=True,
    help="Tolerance of the vector, and of reference data without one, relative to each output's largest value.",
)
@click.option(
    "--play/--no-play",
    "play_",
    default=True,
    help="Play the reference data that it carries (FMI-LS-REF), in a process of its own.",
    show_default=True,
)
@click.option(
    "--lenient", is_flag=True, help="Report errors of its description as warnings, as 'validation: lenient' does."
)
@click.option(
    "--suggest", is_flag=True, help="Print a mapping to edit, proposed from names, units, shapes and descriptions."
)
@as_json("the findings")
@click.pass_context
def command(
    ctx: click.Context,
    fmu: Path,
    as_: str,
    map_: Path | None,
    scenario: Path | None,
    vector: Path | None,
    telemetry: Path | None,
    tolerance: float,
    play_: bool,
    lenient: bool,
    suggest: bool,
    json_: bool,
) -> None:
    """Check whether an FMU can replace a block.

    Lists what fits and what to change.
    The FMU is run only with --vector, and where it carries reference data.
    With --suggest a mapping is printed instead of the findings.
    Exit status: 0 it fits, 1 it does not, 2 wrong input.
    """
    if not 0.0 <= tolerance < math.inf:
        raise InputError(f"--tolerance {tolerance:g}: expected a number from 0, such as 1e-6")
    judged = load(read(scenario)) if scenario is not None else None
    findings, fitted = check(fmu, as_, map_, lenient, judged, tolerance if play_ else None)
    if vector is not None and fitted is not None and not _errors(findings):
        findings += play(fmu, fitted, as_, vector, tolerance)
    if telemetry is not None and fitted is not None and not _errors(findings):
        findings += against_log(fmu, fitted, as_, telemetry, tolerance)
    fits = not _errors(findings)
    if suggest and fitted is not None:
        say(proposed(fitted).rstrip())
        ctx.exit(0)
    if json_:
        about = {"fmu": str(fmu), "as": as_, "map": None if map_ is None else str(map_), "fits": fits}
        say_json({**about, "findings": [finding.data for finding in findings]})
    else:
        _print(fmu, as_, map_, findings)
    ctx.exit(0 if fits else DOES_NOT_FIT)


def _errors(findings: list[Finding]) -> list[Finding]:
    return [finding for finding in findings if finding.level == "error"]


def _print(fmu: Path, as_: str, map_: Path | None, findings: list[Finding]) -> None:
    say(f"{shown(fmu)} as {as_}" + (f", with {shown(map_)}" if map_ else ""), bold=True)
    say()
    styles = {"ok": "green", "note": "", "warning": "yellow", "error": "bold red"}
    rows = [
        (f.level.replace("error", "ERROR"), f.topic, f.text + (f"\n-> {f.remedy}" if f.remedy else ""))
        for f in findings
    ]
    say_table(("", "", ""), rows, [styles[f.level] for f in findings])
    counts = {level: sum(f.level == level for f in findings) for level in ("error", "warning")}
    counted = ", ".join(f"{n} {level}{'s' if n > 1 else ''}" for level, n in counts.items() if n)
    say()
    if counts["error"] and all(finding.topic in ("vector", "log") for finding in _errors(findings)):
        say(
            f"the ports fit, the outputs are not those of the {_errors(findings)[0].topic}: {counted}",
            fg="red",
            bold=True,
        )
        swap = f"orchestrate SCENARIO --swap BLOCK={shown(fmu)}" + (f" --map {shown(map_)}" if map_ else "")
        say(folded(f"A block with equations of its own gives other outputs; a run judges it: {swap}"))
    elif counts["error"]:
        say(f"does not fit: {counted}", fg="red", bold=True)
        if map_ is None and any(finding.topic == "missing" for finding in _errors(findings)):
            say(folded(f"A mapping is proposed by: orchestrate check {shown(fmu)} --as {as_} --suggest"))
    else:
        say("fits" + (f": {counted}" if counted else ""), fg="green", bold=True)
