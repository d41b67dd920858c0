"""The live pages of the site: a mission day on its first page, and eight flights in the gallery.
Tests: tests/docs/test_site.py."""

from __future__ import annotations

from pathlib import Path

from click.testing import CliRunner

from orchestration.cli.main import main

ROOT = Path(__file__).parents[2]
SHOWN = {
    "mission_day": "A mission day",
    "paper_no_singularity": "The paper's manoeuvre V.B",
    "flight_tumble": "A fast tumble under all errors",
}
"""The pages that stand on the first page."""
FLIGHTS = {
    "The paper's manoeuvre": (
        "live/paper_no_singularity.html",
        "A turn of 90 deg and a tumble end in LVLH hold within a thirtieth of an orbit, by three rods and one wheel.",
    ),
    "A tumble": (
        "live/flight_tumble.html",
        "The planned controller takes 5.9 deg/s off a 50 kg satellite under errors of all sensors and actuators.",
    ),
    "A dead rod": (
        "live/flight_tumble.html#fault1=300",
        "The same flight, with a rod that dies after five minutes and of which nobody tells the controller.",
    ),
    "Three wheels": (
        "live/flight_three_wheels.html",
        "The usual controller of a satellite with wheels turns it, and the rods unload them.",
    ),
    "A ground pass": (
        "live/track_ground_station.html",
        "A slew to a station on Svalbard, which the satellite looks at while it passes.",
    ),
    "An estimator in eclipse": (
        "live/flight_estimated.html",
        "Attitude from field, Sun and gyro alone, on a tumble, and without the Sun in the Earth's shadow.",
    ),
    "A real satellite's record": (
        "evidence/flight_data.md",
        "Field and attitude of the models beside the public records of SUCHAI-3.",
    ),
    "A swap gone wrong": (
        "live/paper_no_singularity.html#fault4=0",
        "The paper's manoeuvre with rods that are wired the other way round: it does not settle.",
    ),
}
"""The eight flights of the gallery: where each is, from the folder docs, and what one sees."""
# A page is loaded when its tab is shown.
_TAB = """=== "{about}"

    <iframe src="docs/live/{name}.html" title="Live page: {about}" class="live" loading="lazy"></iframe>

    [In a page of its own](docs/live/{name}.html)
"""


def add(pages: Path) -> None:
    """Writes the live pages beside the others, and puts them below the first page's heading."""
    (pages / "docs" / "live").mkdir(parents=True, exist_ok=True)
    for name in {*SHOWN, *scenarios()}:
        target = pages / "docs" / "live" / f"{name}.html"
        given = ["live", str(ROOT / "scenarios" / f"{name}.yaml"), "--out", str(target)]
        CliRunner().invoke(main, given, catch_exceptions=False)
        if not target.exists():
            raise RuntimeError(f"{name}: orchestrate live wrote no page")
    first = pages / "README.md"
    heading, rest = first.read_text("utf-8").split("\n", 1)
    first.write_text(f"{heading}\n\n{_front()}\n{rest}", "utf-8")


def scenarios() -> list[str]:
    """Returns the scenarios whose pages the eight flights need."""
    found = (page.partition("#")[0] for page, _ in FLIGHTS.values() if page.startswith("live/"))
    return list(dict.fromkeys(Path(page).stem for page in found))


def flights() -> str:
    """Returns the eight flights as Markdown, for the gallery."""
    listed = (f"- [{name}]({page}): {what}" for name, (page, what) in FLIGHTS.items())
    return "\n".join(["## Eight flights", "", *listed, ""])


def _front() -> str:
    tabs = "\n".join(_TAB.format(name=name, about=about) for name, about in SHOWN.items())
    return f"Fly it here: move a slider, and the blocks run in this browser ([how](docs/use/live.md)).\n\n{tabs}"
