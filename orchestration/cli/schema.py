"""`orchestrate schema`: prints the JSON Schema of scenarios or campaigns.

Tests: tests/orchestration/cli/test_cli.py.
"""

from __future__ import annotations

import click

from ..campaign.file.campaign import schema as campaign_text
from ..scenario.schema import text
from .console import say
from .help import examples


@click.command("schema", epilog=examples("orchestrate schema > scenario.schema.json"))
@click.option("--campaign", is_flag=True, help="That of campaign files.")
def command(campaign: bool) -> None:
    """Print the JSON Schema of scenario files."""
    say((campaign_text() if campaign else text()).removesuffix("\n"))
