"""`orchestrate view`: opens the page of results that are there. Tests: tests/orchestration/cli/test_options.py."""

from __future__ import annotations

from pathlib import Path

import click

from ..campaign.sums import MANIFEST, check
from ..errors import InputError
from ..results import place
from .console import open_page, say
from .help import examples
from .paths import PATH

_PAGES = ("report.html", "campaign.html", "comparison.html", "review.html")
"""The pages that commands write, one a folder."""


@click.command(
    "view", epilog=examples("orchestrate view results/paper_no_singularity", "orchestrate view campaigns/settling")
)
@click.argument("result_dir", type=PATH)
def command(result_dir: Path) -> None:
    """Open the page of a run, campaign or comparison.

    RESULT_DIR is the folder of the results. The page needs no network; a run's shows the motion in three dimensions.
    """
    page = next((result_dir / name for name in _PAGES if (result_dir / name).is_file()), None)
    if page is None:
        what = "there is no such folder" if not result_dir.is_dir() else "no page in it"
        raise InputError(
            f"{result_dir}: {what}; expected the folder of a run, with report.html, or of a campaign or comparison; "
            "remedy: orchestrate run SCENARIO writes one"
        )
    if (result_dir / MANIFEST).exists():
        check(result_dir)
    place.check(result_dir)
    say(str(page))
    open_page(page)
