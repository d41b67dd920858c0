"""The pages of the blocks: equations, limits, ports and parameters, as the page inside each FMU has them.
Tests: tests/docs/test_site.py."""

from __future__ import annotations

import re
from pathlib import Path

from fmus.contents.documentation import content
from fmus.interface import BLOCKS, load
from fmus.native import HOST


def add(pages: Path) -> None:
    """Writes docs/blocks/<block>.md for each block."""
    folder = pages / "docs" / "blocks"
    folder.mkdir(parents=True, exist_ok=True)
    for block in BLOCKS:
        (folder / f"{block}.md").write_text(page(block), "utf-8")


def page(block: str) -> str:
    """A block's page as Markdown, whose headings the site's contents and search know."""
    text = content(load(block), HOST, "../../LICENSE").replace(' class="named"', "")
    return f"# {block}\n\n" + re.sub(r"<h2>(.*?)</h2>\n?", r"\n## \1\n\n", text) + "\n"
