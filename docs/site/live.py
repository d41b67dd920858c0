"""The live pages on the site's first page. Tests: tests/docs/test_site.py."""

from __future__ import annotations

from pathlib import Path

from click.testing import CliRunner

from orchestration.cli.main import main

ROOT = Path(__file__).parents[2]
SHOWN = {"paper_no_singularity": "The paper's manoeuvre V.B", "flight_tumble": "A fast tumble under all errors"}
# A page is loaded when its tab is shown.
_TAB = """=== "{about}"

    <iframe src="docs/live/{name}.html" title="Live page: {about}" class="live" loading="lazy"></iframe>

    [In a page of its own](docs/live/{name}.html)
"""


def add(pages: Path) -> None:
    """Writes the live pages beside the others, and puts them below the first page's heading."""
    (pages / "docs" / "live").mkdir(parents=True, exist_ok=True)
    for name in SHOWN:
        target = pages / "docs" / "live" / f"{name}.html"
        given = ["live", str(ROOT / "scenarios" / f"{name}.yaml"), "--out", str(target)]
        CliRunner().invoke(main, given, catch_exceptions=False)
        if not target.exists():
            raise RuntimeError(f"{name}: orchestrate live wrote no page")
    first = pages / "README.md"
    heading, rest = first.read_text("utf-8").split("\n", 1)
    first.write_text(f"{heading}\n\n{_front()}\n{rest}", "utf-8")


def _front() -> str:
    tabs = "\n".join(_TAB.format(name=name, about=about) for name, about in SHOWN.items())
    return f"Fly it here: move a slider, and the blocks run in this browser ([how](docs/use/live.md)).\n\n{tabs}"
