"""The command `orchestrate`.

Exit status: 0 all well; 1 an expectation failed or was not reached; 2 the input is wrong, no step was run;
3 an FMU failed; 4 the results could not be written; 70 an error of this program;
128 + n ended by signal n, so 130 by Ctrl-C; 141 the reader of its output closed the pipe before anything was read.
"""

from __future__ import annotations

import gc
import os
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, cast

import click
from click.shell_completion import CompletionItem

from ..errors import InputError, lacking, nearest, suggestion
from .console import tell_builds
from .help import examples
from .status import Commands

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
"""For NumPy: starting its threads takes 20 ms, and no product here is large enough for them."""
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
"""To look for plugins, Pydantic reads the entry points of all packages that are installed: 10 ms."""

COMMANDS = {
    "accept": "orchestration.cli.accept",
    "build": "orchestration.cli.build",
    "campaign": "orchestration.cli.campaign",
    "card": "orchestration.cli.card",
    "check": "orchestration.cli.check",
    "compare": "orchestration.cli.compare",
    "export": "orchestration.cli.export",
    "fmus": "orchestration.cli.fmus",
    "info": "orchestration.cli.info",
    "live": "orchestration.cli.live",
    "margins": "orchestration.cli.margins",
    "new": "orchestration.cli.new",
    "polarity": "orchestration.cli.polarity",
    "reference": "orchestration.cli.reference",
    "replay-calls": "orchestration.cli.replay_calls",
    "run": "orchestration.cli.run",
    "scenarios": "orchestration.cli.scenarios",
    "schema": "orchestration.cli.schema",
    "validate": "orchestration.cli.validate",
    "view": "orchestration.cli.view",
}
"""The commands, and the modules whose `command` they are; each is imported when it is called."""
EXTRAS = {"campaign": "campaign", "margins": "margins"}
"""The extras of those that need packages beyond the ones of a plain installation."""


@cache
def outside() -> dict[str, EntryPoint]:
    """Returns the commands that installed packages add, by their entry points of the group `orchestrate.commands`.

    They are looked at only where a name is no command of `COMMANDS`.
    """
    from importlib.metadata import entry_points  # here, since it takes 40 ms  # noqa: PLC0415

    return {point.name: point for point in entry_points(group="orchestrate.commands") if point.name not in COMMANDS}


class _Lazy(Commands):
    """`orchestrate x.yaml` is `orchestrate run x.yaml`."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted((*COMMANDS, *outside()))

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if not _is_command(name):
            return None
        gc.disable()  # what imports leave is no garbage, and looking for some in it takes 30 ms
        try:
            return _own(name) if name in COMMANDS else _load(outside()[name])
        finally:
            gc.freeze()
            gc.enable()

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if args and args[0] not in ("-h", "--help", "--version") and _may_be_scenario(args[0]):
            args = ["run", *args]
        return super().parse_args(ctx, args)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Returns the commands, and the files that may be scenarios."""
        return [*super().shell_complete(ctx, incomplete), CompletionItem(incomplete, type="file")]

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if not _is_command(args[0]):
            match = suggestion(nearest(args[0], self.list_commands(ctx)))
            raise InputError(f"{args[0]}: there is no such command or scenario{match}")
        return super().resolve_command(ctx, args)


def _own(name: str) -> click.Command:
    """Returns one of `COMMANDS`, or one that says which extra brings the packages that it needs."""
    try:
        return cast(click.Command, import_module(COMMANDS[name]).command)
    except ModuleNotFoundError as error:
        if name not in EXTRAS or (error.name or "").startswith("orchestration"):
            raise
        return _lacking(name, error, f"attitude-cosim[{EXTRAS[name]}]")


def _load(point: EntryPoint) -> click.Command:
    """Returns the command of an installed package, or one that says which extra brings the packages that it needs."""
    try:
        return cast(click.Command, point.load())
    except ModuleNotFoundError as error:
        distribution = point.dist.name if point.dist else "attitude-cosim"
        extra = f"[{','.join(point.extras)}]" if point.extras else ""
        return _lacking(point.name, error, distribution + extra)


def _lacking(name: str, error: ModuleNotFoundError, needed: str) -> click.Command:
    """Returns a command that refuses whatever it is asked."""

    def refuse(words: tuple[str, ...]) -> None:
        raise lacking(name, error.name, needed)

    return click.Command(
        name,
        callback=refuse,
        short_help=f"Not installed: pip install '{needed}'",
        params=[click.Argument(["words"], nargs=-1)],
        context_settings={"ignore_unknown_options": True, "help_option_names": []},
    )


def _is_command(text: str) -> bool:
    return text in COMMANDS or text in outside()


def _may_be_scenario(text: str) -> bool:
    """Returns whether it is an option of `run`, or a path: with a suffix or a folder in it, or of a file and no
    command.
    """
    if text[:1] in ("-", "") or Path(text).suffix != "" or Path(text).name != text:
        return True
    return not _is_command(text) and os.path.exists(text)


_EXAMPLES = examples(
    *("orchestrate scenarios --copy mine", "orchestrate mine/minimal.yaml --open"),
    *("orchestrate info plant", "orchestrate run -h"),
)
_EPILOG = f"""
{_EXAMPLES}

\b
Completion of commands, options and files by bash (also zsh and fish):
eval "$(_ORCHESTRATE_COMPLETE=bash_source orchestrate)"
"""


@click.group(
    cls=_Lazy, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100}, epilog=_EPILOG
)
@click.version_option(package_name="attitude-cosim")
@click.pass_context
def main(ctx: click.Context) -> None:
    """Runs co-simulation FMUs of FMI 2.0 and 3.0 from a scenario file: orchestrate SCENARIO.yaml

    Exit status: 0 success, 1 an expectation failed or was not reached, 2 wrong input, no step was run, 3 an FMU failed
    in its initialization or in the run, or a step was late with --late stop, 4 results not written, 70 an error of this
    program, 128 + n ended by signal n.
    """
    tell_builds(ctx)


if __name__ == "__main__":
    main()
