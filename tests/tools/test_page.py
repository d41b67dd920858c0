"""Every program of the recipes, which the other tests run, stands in docs/use/tools.md as it is."""

from __future__ import annotations

import pytest

from ..docs.commands import ROOT
from .measure import RECIPES


@pytest.mark.parametrize("recipe", sorted(path.name for path in RECIPES.glob("*.*")))
def test_a_recipe_stands_in_the_page(recipe: str) -> None:
    text, page = (RECIPES / recipe).read_text("utf-8"), (ROOT / "docs" / "use" / "tools.md").read_text("utf-8")
    assert f"\n{text}```\n" in page
