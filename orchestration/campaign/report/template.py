"""The template of a campaign's page, which stands beside this file.

Tests: tests/orchestration/campaign/report/test_page.py.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path

from markupsafe import Markup

from ...results import html

_TEMPLATE = str(Path(__file__).with_name("campaign.html"))
part = partial(html.part, _TEMPLATE)


def piece(name: str) -> Markup:
    """Returns the piece of this name."""
    return html.pieces(_TEMPLATE)[name]


def rows(name: str, cells: Iterable[Iterable[object]], *more: str) -> Markup:
    """Returns the rows of the table in a piece; see `html.cards`."""
    return html.cards(piece(name), cells, *more)
