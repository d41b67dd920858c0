"""`orchestrate margins`: measures the stability margins of a loop. Tests: tests/orchestration/cli/test_margins.py."""

from __future__ import annotations

import json
from pathlib import Path

import click

from ..errors import InputError, Place, Problem, writing
from ..quantities import SECOND, QuantityError, value_in
from ..results.place import check_writable
from ..scenario.text import parse
from ..session.open import open_scenario
from ..session.session import Session
from .console import complain, notes, say, say_json, say_table
from .help import examples
from .options import changes, out_folder
from .overrides import Changes
from .paths import PATH
from .status import EXPECTATION_FAILED

try:
    from ..margins.inject import Rig
    from ..margins.measure import LONGEST, measure
    from ..margins.report import HEADER, Found
    from ..margins.search import Change, expectations_are_met, lost, pulse_dies_out
    from ..margins.site import site
except ModuleNotFoundError as missing:
    _MISSING = missing.name
else:
    _MISSING = None


@click.command(
    "margins",
    epilog=examples(
        "orchestrate margins loop.yaml --at allocator.tau_cmd_B",
        "orchestrate margins loop.yaml --at plant.wheel_torque_cmd --when '3000 s' --out results/margins",
        "orchestrate margins loop.yaml --at plant.wheel_torque_cmd --change delay=0..20 --change plant.J_B=1..5",
    ),
)
@click.argument("scenario", type=PATH)
@changes("swaps", "maps", "sets", "step", "flavour")
@click.option("--at", "ports", multiple=True, required=True, metavar="BLOCK.PORT", help="Where the loop is opened.")
@click.option("--when", metavar="T", help="When the injection begins; default: the scenario's duration.")
@click.option("--window", metavar="T", help="Longest time that is looked at after a pulse.")
@click.option(
    "--change",
    "changed",
    multiple=True,
    metavar="NAME=FROM..TO",
    help="Seek the least change that loses the loop: gain, delay (s), or a factor on block.parameter; may be repeated.",
)
@click.option(
    "--lost",
    "criterion",
    type=click.Choice(["pulse", "expectations"]),
    default="pulse",
    show_default=True,
    help="Lost is a loop in which a pulse grows, or whose expectations fail.",
)
@out_folder("Folder for table, plot and data; default: results/NAME-margins.")
@click.option("--json", "json_", is_flag=True, help="Print the result as JSON.")
@click.pass_context
def command(
    ctx: click.Context,
    scenario: Path,
    change: Changes,
    ports: tuple[str, ...],
    when: str | None,
    window: str | None,
    changed: tuple[str, ...],
    criterion: str,
    out: Path | None,
    json_: bool,
) -> None:
    """Measure the stability margins of a loop.

    Small sines are added to the signal at BLOCK.PORT, an input (for it alone) or an output (for all that it feeds), and
    what comes back is compared with a flight without them. Gives gain, phase, delay and disk margins of each element
    with the others closed, and the disk margin of all at once. --at may be repeated.

    Exit status: 0 measured, 1 the loop has no margins there (with the reason), 2 wrong input, 3 an FMU failed.
    """
    if _MISSING:
        raise InputError(f"margins needs the package {_MISSING!r}; remedy: pip install 'attitude-cosim[margins]'")
    loaded = change.scenario(scenario)
    target = out or Path("results") / f"{loaded.name}-margins"
    check_writable(target)
    with Session(open_scenario(loaded)) as session:
        plan = session.opened.plan
        begin = seconds("--when", when, loaded.duration)
        rig = Rig(session, site(plan, ports), round(begin / plan.clock.step))
        longest = seconds("--window", window, LONGEST * rig.period)
        changes_ = [Change.of(text) for text in changed]
        found = Found.of(loaded.name, rig.first * plan.clock.step, measure(rig, max(int(longest / rig.period), 4)))
        if not found.response.refused:
            window_ = 3 * found.response.settling + 256
            holds = pulse_dies_out(rig, window_) if criterion == "pulse" else expectations_are_met(rig)
            found.searched.extend(lost(rig, one, holds) for one in changes_)
    if not found.response.refused:
        _write(found, target)
    if json_:
        say_json(found.data())
    else:
        _print(found, target)
    ctx.exit(EXPECTATION_FAILED if found.response.refused else 0)


def seconds(option: str, text: str | None, default: float) -> float:
    """Returns the time of an option, which is not negative. Raises InputError."""
    if text is None:
        return default
    place = Place(f"{option} {text}")
    try:
        value = value_in(parse(text, f"{option} {text}").data, SECOND)
    except QuantityError as error:
        raise InputError(Problem(str(error), place=place)) from None
    if not 0.0 <= value < 1e9:
        raise InputError(Problem(expected="a time of 0 s to 1e9 s", found=text, place=place))
    return value


def _write(found: Found, folder: Path) -> None:
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "margins.json").write_text(json.dumps(found.data(), indent=2) + "\n", "utf-8")
        found.figure().savefig(folder / "margins.png", dpi=120)
    found.save_table(folder / "response.csv")


def _print(found: Found, folder: Path) -> None:
    response = found.response
    notes(response.warnings)
    if response.refused:
        complain(f"no margins: {response.refused}")
        return
    say(f"{found.name}: loop opened at {', '.join(response.labels)} from {found.when:g} s", bold=True)
    say_table(HEADER, found.rows())
    for line in found.lines():
        say(line)
    low, high, error = response.omega[0], response.omega[-1], 100 * response.error.max()
    say(
        f"{response.flights} flights, {low:.3g} to {high:.3g} rad/s, response within {error:.2g} %; written to {folder}"
    )
