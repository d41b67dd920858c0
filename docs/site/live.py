"""The live pages on the site's first page."""

from __future__ import annotations

from pathlib import Path

from click.testing import CliRunner

from orchestration.cli.main import main

ROOT = Path(__file__).parents[2]
SHOWN = {"paper_no_singularity": "the paper's manoeuvre V.B", "flight_tumble": "a fast tumble under all errors"}
_FRAME = '<iframe src="docs/live/{name}.html" title="Live page: {about}" width="100%" height="720" style="border: 0"></iframe>'


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
    links = ", ".join(f"[{about}](docs/live/{name}.html)" for name, about in SHOWN.items())
    name, about = next(iter(SHOWN.items()))
    frame = _FRAME.format(name=name, about=about)
    return f"Fly it here: move a slider, and the blocks run in this browser ([how](docs/live.md)). In a page of its own: {links}.\n\n{frame}\n"
