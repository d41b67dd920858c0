"""Options that several commands have. Tests: tests/orchestration/cli/test_options.py."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from functools import wraps
from typing import Any

import click

from ..errors import InputError
from ..quantities import QuantityError, Unit, value_in
from ..scenario.realtime import OFF
from .overrides import Changes
from .paths import PATH

SET = click.option(
    "--set",
    "sets",
    multiple=True,
    metavar="[BLOCK.]PARAMETER=VALUE",
    help="A start value, such as plant.inclination='51.6 deg' or plant.omega_B0='[0.01, 0, 0]'; "
    "without a block that of a shared value; may be repeated.",
)
FORMAT = click.option(
    "--format", "format_", default="csv", show_default=True, metavar="csv|parquet|mat", help="Format of the signals."
)
FIGURES = click.option("--figures", is_flag=True, help="Draw the scenario's figures into DIR/figures.")
OPEN = click.option("--open", "open_", is_flag=True, help="Open the page in the browser.")
QUIET = click.option("-q", "--quiet", is_flag=True, help="Print errors only.")
FLAVOUR = click.option(
    "--flavour",
    type=click.Choice(["native", "python"]),
    default="native",
    show_default=True,
    help="Compiled C, which runs in any tool, or the Python reference, which needs a host that holds Python.",
)


class Between(click.FloatRange):
    """A finite number in a range; `click.FloatRange` takes NaN, with which no comparison fails or holds."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value} is no finite number.", param, ctx)
        return number


class _Factor(click.ParamType):
    """The factor of --realtime is a number or `off`; what else follows was most likely meant as the scenario."""

    name = "factor"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            return value if value == OFF else float(value)
        except ValueError:
            message = f"expected a number or {OFF}; remedy: --realtime after the scenario, or --realtime=1"
            raise InputError(f"--realtime {value}: {message}") from None


_CHANGES = {
    "sets": SET,
    "swaps": click.option(
        "--swap",
        "swaps",
        multiple=True,
        metavar="BLOCK=FILE.fmu",
        help="Another FMU in a block's place; may be repeated.",
    ),
    "maps": click.option(
        "--map",
        "maps",
        multiple=True,
        metavar="[BLOCK=]FILE",
        help="Mapping of the swapped FMU's ports to ours; with several swaps BLOCK=FILE.",
    ),
    "step": click.option("--step", metavar="T", help="Base step instead of the scenario's, in s or with a unit."),
    "duration": click.option(
        "--duration", metavar="T", help="Duration instead of the scenario's, in s or with a unit."
    ),
    "flavour": click.option(
        "--flavour", metavar="native|python", help="Build of the project's own blocks instead of the scenario's."
    ),
    "realtime": click.option(
        "--realtime",
        is_flag=False,
        flag_value="1",
        metavar="[FACTOR]",
        type=_Factor(),
        help="Pace the run by wall time: FACTOR simulated seconds in a second, 1 by default; "
        "off: not, whatever the scenario says.",
    ),
    "late": click.option(
        "--late",
        metavar="continue|stop",
        help="What a run in real time does after a late step: go on, or end with status 3.",
    ),
    "late_tolerance": click.option(
        "--late-tolerance", metavar="T", help="How late a step of a run in real time may end, in s or with a unit."
    ),
}
"""The options that change a scenario, by the fields of `Changes`."""


def changes(*names: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Gives a command these options, which it takes together as `change`; all of them where none is named."""
    chosen = names or tuple(_CHANGES)

    def with_options(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def called(*args: Any, **kwargs: Any) -> Any:
            change = Changes(**{name: kwargs.pop(name) for name in chosen})
            return command(*args, change=change, **kwargs)

        for name in reversed(chosen):
            called = _CHANGES[name](called)
        return called

    return with_options


def as_json(what: str) -> Callable[[Any], Any]:
    """Returns the option `--json`."""
    return click.option("--json", "json_", is_flag=True, help=f"Print {what} as JSON.")


def out_folder(help: str) -> Callable[[Any], Any]:
    """Returns the option `--out DIR`."""
    return click.option("-o", "--out", type=PATH, metavar="DIR", help=help)


def quantity(option: str, text: str | None, unit: Unit) -> float | None:
    """Returns a positive number of an option, None where it is not given. Raises InputError."""
    if text is None:
        return None
    try:
        number: Any = text
        with contextlib.suppress(ValueError):
            number = float(text)
        value = value_in(number, unit)
    except QuantityError as error:
        raise InputError(f"{option} {text}: {error}") from None
    if not 0.0 < value < math.inf:
        raise InputError(f"{option} {text}: expected above zero, found {value:g} {unit.name}")
    return value
