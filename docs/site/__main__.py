"""Builds the documentation site in out/site/html: `python -m docs.site`, or `make site`.

Neither the build nor the pages need a network. Tests: tests/docs/test_site.py.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from docs.site import blocks, gallery, links, live, pages

ROOT = Path(__file__).parents[2]
OUT = ROOT / "out" / "site"
SHIM = "https://unpkg.com/iframe-worker/shim"
"""What the site's search asks for where a page is opened as a file; its copy lies in docs/site/."""


def build(with_gallery: bool = True) -> list[str]:
    """Builds the site and returns what is wrong with its links. Without the gallery and the live pages nothing is
    flown."""
    pages.gather(OUT / "pages")
    blocks.add(OUT / "pages")
    (OUT / "pages" / "docs" / "gallery.md").write_text(gallery.page(OUT) if with_gallery else gallery.HEAD, "utf-8")
    if with_gallery:
        live.add(OUT / "pages")
    shutil.rmtree(OUT / "html", ignore_errors=True)
    zensical = Path(sys.executable).with_name("zensical")
    subprocess.run([zensical, "build", "--clean", "--strict", "-f", ROOT / "mkdocs.yml"], check=True)
    for path in (OUT / "html").rglob("*.html"):
        text = path.read_text("utf-8")
        up = "../" * (len(path.relative_to(OUT / "html").parts) - 1)
        path.write_text(text.replace(SHIM, f"{up}docs/site/iframe-worker.js"), "utf-8")
    return links.check(OUT / "html")


if __name__ == "__main__":
    findings = build()
    if findings:
        sys.exit("\n".join(findings))
    print(f"the documentation is in {OUT / 'html' / 'index.html'}")
