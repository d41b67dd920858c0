"""Each kind of page, read by axe-core: in light and dark, wide and narrow, with all that can be opened open."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from click.testing import CliRunner

from design.review import page as review
from design.review.content import Curves, Review, Section, Table
from fmus.contents.documentation import index_html
from fmus.interface import load as interface
from orchestration.acceptance import accept_page
from orchestration.acceptance import page as comparison
from orchestration.acceptance.accept import Acceptance
from orchestration.acceptance.polarity import card_page, vendor_card
from orchestration.campaign.report import page as campaign
from orchestration.cli.main import main
from orchestration.results.arrays import Arrays
from orchestration.results.view import beside, view

from .acceptance.test_page import compared
from .acceptance.test_vendor_card import theirs, trial
from .campaign import synthetic
from .results.browser import Tab
from .results.flown import flown
from .results.swing import swing

pytestmark = pytest.mark.thorough

ROOT = Path(__file__).parents[2]


def _run(folder: Path) -> Path:
    return swing().save(folder) / "report.html"


def _flight(folder: Path) -> Path:
    return flown().save(folder) / "report.html"


def _live(folder: Path) -> Path:
    given = ["live", str(ROOT / "scenarios" / "minimal.yaml"), "--out", str(folder / "live.html")]
    CliRunner().invoke(main, given, catch_exceptions=False)
    return folder / "live.html"


def _campaign(folder: Path) -> Path:
    return campaign.write(synthetic.write(folder))


def _comparison(folder: Path) -> Path:
    return comparison.write(compared(), folder)


def _acceptance(folder: Path) -> Path:
    facts = dict.fromkeys(("version", "author", "generation_tool", "license", "not_valid"), "")
    about = {**facts, "file": "a.fmu", "sha256": "0" * 64, "kind": "native", "name": "a", "platforms": ["linux64"]}
    about["capabilities"] = []
    made = Acceptance(about, "a", "swing", [], None, comparison=compared(), proposed="map:\n  a: b\n")
    return accept_page.write(made, folder)


def _review(folder: Path) -> Path:
    shown = view(flown(), Arrays(inline=True))
    tables = [
        Table("Time to settle", ["until", "median, s"], [["5 deg", "300 ‖ 400"]], "of all"),
        Table("none", ["a"], []),
    ]
    curves = Curves("Settled", [0.0, 1.0], "time, min", "share", {"5 deg": [0.0, 1.0]})
    section = Section("Tumbles", tables, [curves], ["a note"], motion=beside(shown, shown, ("A: one", "B: other")))
    required = Section("Requirements", [Table("Requirements", ["id", "verdict"], [["R1", "met"], ["R2", "not met"]])])
    return review.write(Review("one", "a satellite", {"seed": "1"}, [section, required], ["met", "not met"]), folder)


def _card(folder: Path) -> Path:
    rate = {"omega_B": [0.0, 0.0, 0.1]}
    card = vendor_card.lines([trial("omega_B", 0, {}, rate)], theirs())
    return card_page.write(card, {"fmu": "a.fmu", "as": "controller"}, folder, [("kp", 2.5, "1/s")])[0]


def _fmu(folder: Path) -> Path:
    (folder / "index.html").write_bytes(index_html(interface("estimator"), "any"))
    return folder / "index.html"


PAGES: dict[str, Callable[[Path], Path]] = {
    "of a run": _run,
    "of a flight": _flight,
    "live": _live,
    "of a campaign": _campaign,
    "of a comparison": _comparison,
    "of an acceptance": _acceptance,
    "of a review": _review,
    "of a card": _card,
    "of an FMU": _fmu,
}


@pytest.mark.parametrize("kind", PAGES)
def test_axe_core_has_nothing_to_say_of_a_page(kind: str, chromium: Tab, tmp_path: Path):
    chromium.open(PAGES[kind](tmp_path), 1400)
    page = chromium.page
    page.evaluate("document.querySelector('[data-part=play][aria-pressed=true]')?.click()")
    for width in (1400, 390):
        for theme in ("light", "dark"):
            page.emulate_media(color_scheme=theme)
            chromium.resize(width)
            page.evaluate("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })")
            chromium.settle()
            found = Axe().run(page, options={}).response["violations"]
            assert [(one["id"], width, theme, [node["html"][:200] for node in one["nodes"]]) for one in found] == []
