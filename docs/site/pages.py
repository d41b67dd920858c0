"""Gathers the pages that the documentation site shows.

Their folder mirrors the repository, so a relative link leads to the same file in the site and on a code host.
Added are pages from the docstrings (api/), and equations are set as MathML, which browsers typeset by themselves.
Tests: tests/docs/test_site.py.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from latex2mathml.converter import convert

ROOT = Path(__file__).parents[2]
PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/*.md", "docs/*/*.md", "examples/*/README.md")
# What pages link to and a browser shows as it is.
SHOWN = (
    "LICENSE",
    "docs/evidence/*.csv",
    "docs/*.json",
    "docs/figures/*",
    "docs/use/notebooks/*.ipynb",
    "docs/site/*.css",
    "docs/site/*.js",
    "docs/site/*.LICENSE",
    "examples/*/*.*",
    "fmus/interfaces/*.toml",
    "fmus/contents/frames.svg",
    "scenarios/*.yaml",
    "scenarios/campaigns/*.yaml",
)
API = ("orchestration", "plant", "estimator", "controller", "allocator", "supervisor", "fmus")
# A fenced block or code, which stays as it is; a displayed equation; an equation in a line.
_EQUATION = re.compile(r"(^```.*?^```|`[^`\n]+`)|\$\$(.+?)\$\$|\$([^$\n]+?)\$", re.DOTALL | re.MULTILINE)


def gather(folder: Path) -> None:
    """Writes the site's sources into `folder`, which is emptied first."""
    shutil.rmtree(folder, ignore_errors=True)
    for pattern in (*PAGES, *SHOWN):
        for path in ROOT.glob(pattern):
            target = folder / path.relative_to(ROOT)
            target.parent.mkdir(parents=True, exist_ok=True)
            if path.suffix == ".md":
                target.write_text(with_mathml(path.read_text("utf-8")), "utf-8")
            else:
                shutil.copy(path, target)
    (folder / "api").mkdir()
    for package in API:
        (folder / "api" / f"{package}.md").write_text(api_page(package), "utf-8")


def with_mathml(text: str) -> str:
    """Markdown with its equations, $...$ and $$...$$, as MathML."""

    def replaced(match: re.Match[str]) -> str:
        code, displayed, inline = match.groups()
        if code:
            return str(code)
        if displayed:
            # A <math> does not scroll by itself where it is wider than the page.
            return f'<div class="equation">{convert(displayed.strip(), display="block")}</div>'
        # Markdown takes <math> at the beginning of a line for a block; <span> is never one.
        return f"<span>{convert(inline.strip(), display='inline')}</span>"

    return _EQUATION.sub(replaced, text)


def api_page(package: str) -> str:
    """Every public module of a package, from its docstrings."""
    lines = [f"# {package}", ""]
    for path in sorted((ROOT / package).rglob("*.py"), key=lambda path: path.with_suffix("").parts):
        parts = path.relative_to(ROOT).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        if '"""' in path.read_text("utf-8") and not parts[-1].startswith("__main"):
            lines += [f"::: {name}", ""]
    return "\n".join(lines)
