"""`orchestrate schema`: what a scenario file may hold, as a JSON Schema."""

from __future__ import annotations

import click

from ..scenario.schema import text
from .console import lost, say
from .status import UNWRITTEN


@click.command("schema")
@click.pass_context
def command(ctx: click.Context) -> None:
    """Print the JSON Schema of scenario files."""
    say(text().removesuffix("\n"))
    ctx.exit(UNWRITTEN if lost() else 0)
