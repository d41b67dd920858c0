"""The documentation site builds, its links lead somewhere, and it needs no network."""

from __future__ import annotations

import re
from html import escape
from pathlib import Path

import markdown  # type: ignore[import-untyped]
import pytest

from docs.site import __main__ as site
from docs.site import frames, live, packages
from docs.site.links import check
from docs.site.pages import with_mathml
from fmus.interface import BLOCKS, load
from orchestration.session.read import load as scenario_of

from .commands import PAGES, ROOT


@pytest.mark.compile
def test_the_site_builds_with_equations_and_without_a_dead_link():
    assert site.build(with_gallery=False) == []
    html = site.OUT / "html"
    assert "<math" in (html / "docs" / "how" / "frames.html").read_text("utf-8")
    for block in BLOCKS:
        page = (html / "docs" / "blocks" / f"{block}.html").read_text("utf-8")
        assert all(escape(equation) in page for equation, _ in load(block).equations)
        assert 'id="inputs"' in page
    assert "iframe-worker.js" in (html / "index.html").read_text("utf-8")


def test_a_dead_link_a_missing_heading_and_a_script_from_the_network_are_found(tmp_path):
    links = '<a href="b.html"></a><a href="#c"></a><a href="a.html#d" id="d"></a><script src="https://x.org/y.js">'
    (tmp_path / "a.html").write_text(links)
    assert [finding.split()[1:3] for finding in check(tmp_path)] == [
        ["links", "b.html,"],
        ["links", "#c,"],
        ["loads", "https://x.org/y.js"],
    ]


def test_the_eight_flights_of_the_gallery_have_scenarios_faults_and_a_sentence_each():
    assert len(live.FLIGHTS) == 8
    for page, sentence in live.FLIGHTS.values():
        assert sentence.endswith(".")
        assert len(sentence) > 40
        address, _, changed = page.partition("#")
        if not address.startswith("live/"):
            assert (ROOT / "docs" / address).exists()
            continue
        scenario = scenario_of(ROOT / "scenarios" / f"{Path(address).stem}.yaml")
        for text in filter(None, changed.split("&")):
            number = int(text.partition("=")[0].removeprefix("fault"))
            assert number <= len(scenario.faults) + len(scenario.live.faults if scenario.live else ())


def test_equations_become_mathml_and_code_stays():
    text = with_mathml("`a $b$`, $x_1$\n```\n$y$\n```\n$$\\hat x$$")
    assert text.startswith("`a $b$`, <span><math")
    assert '```\n$y$\n```\n<div class="equation"><math' in text


def test_an_equation_at_the_beginning_of_a_line_stays_in_its_paragraph():
    html = markdown.markdown(with_mathml("The gains\n$K$ and $L$ are constant."))
    assert html.count("<p>") == 1
    assert html.startswith("<p>The gains")
    assert html.endswith("are constant.</p>")


@pytest.mark.parametrize("page", PAGES)
def test_a_path_in_a_page_exists(page):
    """Links on a code host, and paths in code quotes that begin with a folder of the repository."""
    text = re.sub(r"^```.*?^```$", "", (ROOT / page).read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
    for target in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", text):
        if "gallery" not in target:
            assert ((ROOT / page).parent / target).exists(), target
    folders = "allocator|controller|docs|evidence|examples|fmus|orchestration|plant|scenarios|supervisor|tests"
    for path in re.findall(rf"`((?:{folders})/[\w./*-]*)`", text):
        assert "a_b" in path or list(ROOT.glob(path.rstrip("/"))), path


def test_every_page_can_be_reached_from_the_index():
    def linked(page):
        links = re.findall(r"\]\(([^)#:\s]+\.md)", page.read_text("utf-8"))
        return {(page.parent / link).resolve() for link in links}

    docs = ROOT / "docs"
    listed = linked(docs / "README.md")
    assert set(docs.glob("*/*.md")) - set(docs.glob("decisions/0*.md")) <= listed
    assert set((docs / "decisions").glob("0*.md")) <= linked(docs / "decisions" / "README.md")
    assert docs / "decisions" / "README.md" in listed
    assert docs / "README.md" in linked(ROOT / "README.md")


@pytest.mark.parametrize("script", [frames, packages])
def test_a_drawing_is_what_its_script_makes(script):
    assert script.TARGET.read_text("utf-8") == script.drawing(), f"python -m {script.__name__}"


def test_each_function_that_the_architecture_names_is_in_its_file():
    """`path`: `name`, `name` in a cell of a table."""
    text = (ROOT / "docs" / "how" / "architecture.md").read_text("utf-8")
    named = re.findall(r"`([\w/]+\.(?:py|c))`: ((?:`\w+`(?:, )?)+)", text)
    assert len(named) > 40
    for path, names in named:
        source = (ROOT / path).read_text("utf-8")
        for name in re.findall(r"`(\w+)`", names):
            assert re.search(rf"\b(def|class) {name}\b|^\w[\w ]*\W{name}\(", source, re.MULTILINE), (path, name)
