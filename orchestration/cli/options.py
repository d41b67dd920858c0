"""Options that several commands have."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from ..errors import InputError
from ..scenario.realtime import OFF
from .paths import PATH

SET = click.option(
    "--set",
    "sets",
    multiple=True,
    metavar="[BLOCK.]PARAMETER=VALUE",
    help="A start value, such as plant.inclination='51.6 deg' or plant.omega_B0='[0.01, 0, 0]'; without a block that of a shared value; may be repeated.",
)
SWAP = click.option(
    "--swap", "swaps", multiple=True, metavar="BLOCK=FILE.fmu", help="Another FMU in a block's place; may be repeated."
)
MAP = click.option(
    "--map",
    "maps",
    multiple=True,
    metavar="[BLOCK=]FILE",
    help="Mapping of the swapped FMU's ports to ours; with several swaps BLOCK=FILE.",
)
STEP = click.option("--step", metavar="T", help="Base step instead of the scenario's, in s or with a unit.")
DURATION = click.option("--duration", metavar="T", help="Duration instead of the scenario's, in s or with a unit.")
FLAVOUR = click.option(
    "--flavour", metavar="native|python", help="Build of the project's own blocks instead of the scenario's."
)
FORMAT = click.option(
    "--format", "format_", default="csv", show_default=True, metavar="csv|parquet|mat", help="Format of the signals."
)
FIGURES = click.option("--figures", is_flag=True, help="Draw the scenario's figures into DIR/figures.")
OPEN = click.option("--open", "open_", is_flag=True, help="Open the page in the browser.")


def pacing(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options `--realtime`, `--late` and `--late-tolerance`; `overrides.paced` takes them."""
    for option in (
        click.option(
            "--late-tolerance", metavar="T", help="How late a step of a run in real time may end, in s or with a unit."
        ),
        click.option(
            "--late",
            metavar="continue|stop",
            help="What a run in real time does after a late step: go on, or end with status 3.",
        ),
        click.option(
            "--realtime",
            is_flag=False,
            flag_value="1",
            metavar="[FACTOR]",
            type=_Factor(),
            help="Pace the run by wall time: FACTOR simulated seconds in a second, 1 by default; off: not, whatever the scenario says.",
        ),
    ):
        command = option(command)
    return command


class _Factor(click.ParamType):
    """A number or `off`; what else follows --realtime was most likely meant as the scenario."""

    name = "factor"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            return value if value == OFF else float(value)
        except ValueError:
            message = f"expected a number or {OFF}; remedy: --realtime after the scenario, or --realtime=1"
            raise InputError(f"--realtime {value}: {message}") from None


def out_folder(help: str) -> Callable[[Any], Any]:
    """The option `--out DIR`."""
    return click.option("-o", "--out", type=PATH, metavar="DIR", help=help)
