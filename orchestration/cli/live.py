"""`orchestrate live`: writes a page that flies a scenario in the browser.

Tests: tests/orchestration/live/test_live.py.
"""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import InputError, writing
from ..fmu.archive import shown
from ..live.page import page
from ..live.system import prepare
from ..results.whole import put
from ..session.run import whole
from .console import notes, open_page, say
from .help import examples
from .options import OPEN, changes
from .overrides import Changes
from .paths import PATH


@click.command(
    "live",
    epilog=examples(
        "orchestrate live scenarios/paper_no_singularity.yaml --out page.html",
        "orchestrate live scenarios/flight_tumble.yaml --out tumble.html --duration 1500 --open",
    ),
)
@click.argument("scenario", type=PATH)
@click.option("-o", "--out", type=PATH, required=True, metavar="PAGE.html", help="The page's file.")
@changes("step", "duration")
@OPEN
def command(scenario: Path, out: Path, change: Changes, open_: bool) -> None:
    """Write a page that flies a scenario in the browser.

    The page needs no network. It has the sliders and faults of `live` in SCENARIO.
    It says the hash of each run, which is that of the native run.
    """
    if out.suffix != ".html":
        raise InputError(f"--out {out}: expected a name that ends in .html")
    if not out.absolute().parent.is_dir():
        raise InputError(f"--out {out}: there is no folder {out.parent}")
    chosen = change.scenario(scenario)
    live = prepare(chosen)
    notes(live.opened.plan.notes)
    native = whole(chosen)
    if native.failure is not None:
        raise native.failure
    with writing(out):
        put(out, page(live, native))
    say(f"{shown(out)}  {out.stat().st_size / 1000:.0f} kB, of which {len(live.wasm) / 1000:.0f} kB are WebAssembly")
    if open_:
        open_page(out)
