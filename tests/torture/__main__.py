"""`python -m tests.torture TRIAL`; each trial is the `command` of a file of its name beside this one."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import cast

import click


class _Trials(click.Group):
    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted(path.stem for path in Path(__file__).parent.glob("[a-z]*.py"))

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in self.list_commands(ctx):
            return None
        return cast(click.Command, import_module(f"{__package__}.{name}").command)


@click.group(cls=_Trials)
def main() -> None:
    """Long trials with random numbers. Exit status: 0 where none of them found an error."""


if __name__ == "__main__":
    main(prog_name="python -m tests.torture")
