"""The command `orchestrate`.

Exit status: 0 all well; 1 an expectation failed; 2 the input is wrong, nothing was run; 3 an FMU failed;
4 the results could not be written; 70 an error of this program; 128 + n ended by signal n, so 130 by Ctrl-C;
141 nobody read what it printed, where that was all it had to do.
"""

from __future__ import annotations

import errno
import os
import signal
import sys
from pathlib import Path
from typing import Any, cast

import click

from ..errors import BlockError, InputError, ResultsError, nearest
from ..interrupt import stoppable
from .console import Progress, complain, lost, open_streams, say, silence, summary

EXPECTATION_FAILED, WRONG_INPUT, BLOCK_FAILED, UNWRITTEN, INTERNAL, SIGNALLED = 1, 2, 3, 4, 70, 128


_PIPE = 13
"""The number of SIGPIPE."""
_LATER = {
    "check": "orchestration.cli.check",
    "compare": "orchestration.cli.compare",
    "new": "orchestration.cli.new",
    "export": "orchestration.cli.export",
    "fmus": "orchestration.cli.fmus",
    "scenarios": "orchestration.cli.scenarios",
}
"""Commands that are imported when they are called, and the modules whose `command` they are."""


class _Commands(click.Group):
    """`orchestrate x.yaml` is `orchestrate run x.yaml`; errors are told in a line, without a traceback."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted({*self.commands, *_LATER})

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name in _LATER:
            from importlib import import_module

            return cast(click.Command, import_module(_LATER[name]).command)
        return super().get_command(ctx, name)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if args and args[0] not in self.list_commands(ctx) and args[0] not in ("--help", "--version"):
            args = ["run", *args]
        return super().parse_args(ctx, args)

    def main(self, *args: Any, **kwargs: Any) -> Any:
        open_streams()
        try:
            with stoppable():
                return super().main(*args, **kwargs)
        except SystemExit:
            if type(sys.stdout).__name__.endswith("PacifyFlushWrapper"):  # click's way with a pipe that is closed
                raise SystemExit(SIGNALLED + _PIPE) from None
            raise
        except OSError as error:
            if error.errno != errno.ENOSPC:
                raise
            silence()
            complain(f"{error.filename or 'standard output'} cannot be written: {error.strerror}")
            raise SystemExit(UNWRITTEN) from None

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except InputError as error:
            for message in error.messages:
                complain(message)
            ctx.exit(WRONG_INPUT)
        except BlockError as error:
            complain(str(error))
            ctx.exit(BLOCK_FAILED)
        except ResultsError as error:
            complain(str(error))
            ctx.exit(UNWRITTEN)
        except (KeyboardInterrupt, click.Abort) as error:
            complain("interrupted")
            ctx.exit(SIGNALLED + getattr(error, "number", signal.SIGINT))
        except (click.exceptions.Exit, click.ClickException, BrokenPipeError):
            raise
        except Exception as error:
            if os.environ.get("ORCHESTRATE_TRACEBACK") or getattr(error, "errno", None) == errno.ENOSPC:
                raise
            complain(f"internal error: {type(error).__name__}: {error} (ORCHESTRATE_TRACEBACK=1 shows where)")
            ctx.exit(INTERNAL)


@click.group(cls=_Commands, context_settings={"help_option_names": ["--help"], "max_content_width": 100})
@click.version_option(package_name="attitude-cosim")
def main() -> None:
    """Runs FMI 2.0 co-simulation FMUs from a scenario file: orchestrate SCENARIO.yaml

    Exit status: 0 all well, 1 an expectation failed, 2 wrong input and nothing run, 3 an FMU failed,
    4 results not written, 128 + n ended by signal n.
    """


@main.command()
@click.argument("scenario", type=click.Path(path_type=Path))
@click.option(
    "--set",
    "sets",
    multiple=True,
    metavar="BLOCK.PARAMETER=VALUE",
    help="A start value, such as plant.angle='51.6 deg' or plant.x=[1,2,3]; may be repeated.",
)
@click.option(
    "--swap", "swaps", multiple=True, metavar="BLOCK=FILE.fmu", help="Another FMU in a block's place; may be repeated."
)
@click.option(
    "--map",
    "maps",
    multiple=True,
    metavar="[BLOCK=]FILE",
    help="How the ports of the swapped FMU stand to ours; with several swaps BLOCK=FILE.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder for the results; default: results/NAME, NAME being the scenario's.",
)
@click.option("--step", metavar="T", help="Base step instead of the scenario's, in s or with a unit.")
@click.option("--duration", metavar="T", help="Duration instead of the scenario's, in s or with a unit.")
@click.option("--flavour", metavar="native|python", help="Build of the project's own blocks instead of the scenario's.")
@click.option(
    "--format", "format_", default="csv", show_default=True, metavar="csv|parquet|mat", help="Format of the signals."
)
@click.option("--figures", is_flag=True, help="Draw the scenario's figures into DIR/figures.")
@click.option(
    "--loop",
    type=click.Choice(["compiled", "python"]),
    default="compiled",
    help="The step loop: in C where it can be used (the default), or the readable one; the results are the same.",
)
@click.option("--log", is_flag=True, help="Print what the FMUs log as it comes.")
@click.option("--quiet", is_flag=True, help="Print errors only.")
@click.pass_context
def run(
    ctx: click.Context,
    scenario: Path,
    sets: tuple[str, ...],
    swaps: tuple[str, ...],
    maps: tuple[str, ...],
    out: Path | None,
    step: str | None,
    duration: str | None,
    flavour: str | None,
    format_: str,
    figures: bool,
    loop: str,
    log: bool,
    quiet: bool,
) -> None:
    """Run a scenario (the default command)."""
    from ..results import folder
    from ..results.figures import require
    from ..runner import run as runner
    from ..scenario.scenario import load
    from ..scenario.source import read

    folder.check(format_)
    if figures:
        require()
    if (
        not scenario.suffix
        and not scenario.exists()
        and "did you mean" in nearest(str(scenario), [*main.commands, *_LATER])
    ):
        raise InputError(
            f"{scenario}: there is no such file or command{nearest(str(scenario), [*main.commands, *_LATER])}"
        )
    source = read(scenario)
    if swaps or maps:
        from ..swap.prepare import swapped

        source = swapped(source, swaps, maps)
    for text in sets:
        source = source.with_start(*assignment(text), option="--set ")
    for key, value in (("step", step), ("duration", duration), ("flavour", flavour)):
        if value is not None:
            source = source.with_value(key, value, f"--{key}")
    loaded = load(source)
    target = out or Path("results") / loaded.name
    folder.check_writable(target)
    progress = Progress(loaded.duration, not quiet)
    try:
        result = runner.execute(loaded, progress, log, loop == "compiled")
    finally:
        progress.close()
    for warning in result.warnings:
        if not quiet:
            say(f"note: {warning}", error=True, fg="yellow")
    if not quiet and len(result.time):
        summary(result)
    status = 0 if result.passed else EXPECTATION_FAILED
    if result.failure is not None:
        complain(str(result.failure))
        status = BLOCK_FAILED
    elif result.interrupted:
        status = SIGNALLED + result.interrupted
    else:
        for outcome in result.outcomes:
            if quiet and not outcome.passed:
                complain(f"expectation failed: {outcome.name}")
    told = len(result.warnings)
    result.save(target, format_)
    for warning in result.warnings[told:]:
        if not quiet:
            say(f"note: {warning}", error=True, fg="yellow")
    if figures and len(result.time):
        result.draw(target / "figures")
    if not quiet:
        say(f"\nresults in {target}")
    ctx.exit(UNWRITTEN if lost() else status)


def assignment(text: str) -> tuple[str, Any]:
    """Name and value of `block.parameter=value`. Raises InputError."""
    from ..scenario.source import parse

    name, equals, value = text.partition("=")
    if not equals or not name.strip() or not value.strip():
        raise InputError(f"--set {text}: expected block.parameter=value")
    return name.strip(), parse(value, f"--set {text}").data


@main.command()
@click.argument("blocks", nargs=-1, metavar="[BLOCK]...")
@click.option(
    "--flavour",
    type=click.Choice(["native", "python"]),
    default="native",
    show_default=True,
    help="Compiled C, which runs in any tool, or the Python reference.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder for the FMUs; default: out/fmus/FLAVOUR.",
)
def build(blocks: tuple[str, ...], flavour: str, out: Path | None) -> None:
    """Build the project's own blocks as FMUs."""
    from fmus.build import BLOCKS, BuildError, blocks_of
    from fmus.build import build as build_fmus

    from ..fmu.archive import shown

    for block in blocks:
        if block not in BLOCKS:
            raise InputError(f"there is no block {block!r}{nearest(block, BLOCKS)}")
    try:
        paths = build_fmus(blocks or None, flavour, out)
    except BuildError as error:
        raise InputError(str(error)) from None
    except OSError as error:
        raise InputError(f"{error.filename or 'the disk'}: {error.strerror}") from None
    for path in paths.values():
        say(f"{shown(path)}  {path.stat().st_size / 1000:.0f} kB")
    for block in () if blocks else BLOCKS:
        if block not in blocks_of(flavour):
            say(f"{block} has no flavour {flavour!r}")


@main.command()
def schema() -> None:
    """Print the JSON Schema of scenario files."""
    from ..scenario.schema import text

    say(text().removesuffix("\n"))
    click.get_current_context().exit(UNWRITTEN if lost() else 0)


if __name__ == "__main__":
    main()
