"""Checks the links of a built site: every file and every anchor is there, and nothing is loaded from a network.
Tests: tests/docs/test_site.py."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {("script", "src"), ("link", "href"), ("img", "src"), ("iframe", "src"), ("object", "data")}


class _Page(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.references: list[tuple[str, bool]] = []
        """each with whether a browser loads it by itself"""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.anchors |= {value for key, value in attrs if value and key in ("id", "name")}
        for key in ("href", "src", "data"):
            value = given.get(key)
            if value and given.get("rel") != "canonical" and (key != "data" or tag == "object"):
                self.references.append((value, (tag, key) in LOADED))


def check(folder: Path) -> list[str]:
    """What is wrong, one sentence for each link."""
    pages = {path: _Page(path.read_text("utf-8")) for path in sorted(folder.rglob("*.html"))}
    findings = []
    for path, page in pages.items():
        where = path.relative_to(folder).as_posix()
        for reference, loaded in page.references:
            parts = urlsplit(reference)
            if parts.scheme in ("http", "https") or parts.netloc:
                if loaded:
                    findings.append(f"{where}: loads {reference} from the network")
                continue
            if parts.scheme or path.name == "404.html":
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target /= "index.html"
            if not target.exists():
                findings.append(f"{where}: links {reference}, which is not there")
            elif "=" in parts.fragment:  # what was changed on a live page
                continue
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
                findings.append(f"{where}: links {reference}, and that page has no such heading")
    return findings
