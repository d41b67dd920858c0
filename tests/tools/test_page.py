"""docs/use/tools.md is what the recipes give, up to versions and rounding."""

from __future__ import annotations

from pathlib import Path

from . import measure, page
from .test_importers import needs


def test_the_page_is_what_the_recipes_give(exported: Path) -> None:
    for recipe in (*measure.ONES, *measure.LOOPS):
        needs(recipe)
    committed = page.TARGET.read_text("utf-8")
    assert page.without_figures(committed) == page.without_figures(page.text(exported)), "python -m tests.tools"
