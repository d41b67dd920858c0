"""A command of `orchestrate`, run in this process."""

from __future__ import annotations

from click.testing import CliRunner, Result

from orchestration.cli.main import main


def orchestrate(*arguments: object, color: bool = False, input: str | None = None) -> Result:
    """Its exit status and what it prints; an error of the program itself is raised."""
    result = CliRunner().invoke(main, [str(argument) for argument in arguments], input=input, color=color)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result
