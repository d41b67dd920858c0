"""Writes the acceptance report: one page that prints, and the same as JSON.

Tests: tests/orchestration/acceptance/test_accept.py.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from markupsafe import Markup

from ..errors import writing
from ..results.html import Page, facts, header, joined, listed, section, table, verdict
from ..results.whole import put
from ..swap.findings import Fit, Link, named
from .accept import Acceptance, summary, untested
from .page import sections

FILES = "acceptance.html", "acceptance.json"
_ROW = 26
_STYLE = """
.mapping { max-width: 46rem; width: 100%; height: auto; } .mapping text { font: 12px sans-serif; fill: currentColor; }
.mapping .how { font-size: 10.5px; fill: var(--quiet); }
pre.yaml { padding: .6rem .9rem; background: var(--soft); overflow-x: auto; }
"""


def write(made: Acceptance, folder: Path) -> Path:
    """Writes both files and returns the page's path. Raises ResultsError."""
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        put(folder / "acceptance.json", json.dumps(summary(made), indent=2, ensure_ascii=False) + "\n")
        put(folder / "acceptance.html", page(made))
    return folder / "acceptance.html"


def page(made: Acceptance) -> str:
    """Returns the page."""
    about = made.facts
    drawing = Page(made.comparison.ours if made.comparison is not None else None)
    title = f"Acceptance of {Path(about['file']).name} as {made.block}"
    badge = ("good", "accepted") if made.passed else ("bad", "not accepted")
    wanted = [(verdict(one.status or "not tested"), one.name, one.text) for one in made.requirements]
    levels = {"ok": "ok", "note": "", "warning": "undecided", "error": "error"}
    interface = [(verdict(levels[f.level]), f.topic, f.text, f.remedy) for f in made.findings if f.topic != "port"]
    parts = [
        header(title, f"In {made.scenario}.", [badge], facts(_what(made))),
        section("Requirements", table(("verdict", "requirement", "found"), wanted)),
        section("Not tested", listed(untested(made), "notes")),
        section("Mapping", _mapping(made)),
        section("Interface", table(("", "topic", "finding", "remedy"), interface)),
        *(sections(made.comparison, drawing) if made.comparison is not None else ()),
    ]
    return drawing.html(title, parts, style=_STYLE)


def _what(made: Acceptance) -> dict[str, object]:
    about = made.facts
    return {
        "SHA-256": Markup("<code>{}</code>").format(about["sha256"]),
        "kind": about["kind"],
        "model": f"{about['name']} {about['version']}".strip(),
        "author": about["author"],
        "made by": about["generation_tool"],
        "platforms": ", ".join(about["platforms"]),
        "capabilities": ", ".join(about["capabilities"]) or "none declared",
        "licence": ", ".join(filter(None, [about["license"], *made.license])) or "none stated",
        "mapping": made.mapping or "none: names are ours",
    }


def _mapping(made: Acceptance) -> Markup:
    if made.fit is None:
        return Markup("")
    ports = [(f.text,) for f in made.findings if f.topic == "port"]
    texts = {"Proposed": made.proposed, "Which corrects it": made.corrected}
    yaml = [Markup('<h3>{}</h3><pre class="yaml">{}</pre>').format(*entry) for entry in texts.items() if entry[1]]
    return joined([picture(made.fit), table(("in words",), ports), *yaml])


def picture(fit: Fit) -> Markup:
    """Returns ours on the left, theirs on the right, and between them what is done to ours."""
    links = [link for link in fit.links.values() if link.ours.causality in ("input", "output")]
    rows = []
    for i, link in enumerate(links):
        y = 16 + _ROW * i
        arrow = (
            "M250 {0} H436 m-7 -4 l7 4 l-7 4" if link.ours.causality == "input" else "M436 {0} H250 m7 -4 l-7 4 l7 4"
        )
        theirs = named(fit.theirs, link.theirs)
        rows.append(
            Markup(
                '<text x="240" y="{1}" text-anchor="end">{2}</text><path d="{0}" fill="none" stroke="currentColor"/>'
                '<text class="how" x="343" y="{3}" text-anchor="middle">{4}</text><text x="446" y="{1}">{5}</text>'
            ).format(
                arrow.format(y),
                y + 4,
                link.ours.name,
                y - 4,
                how(link),
                theirs if len(theirs) < 46 else theirs[:44] + "...",
            )
        )
    return Markup('<svg class="mapping" viewBox="0 0 760 {}" role="img" aria-label="ours and theirs">{}</svg>').format(
        _ROW * len(links) + 10, joined(rows)
    )


def how(link: Link) -> str:
    """Returns in some words what is done to ours."""
    if link.A is None or link.c is None:
        form = link.rotation or f"quaternion, scalar {'last' if link.scalar_last else 'first'}"
        return form + (", inverse" if link.inverse else "")
    scale = float(np.abs(link.A).max())
    turned = f"turned by {link.turned}, " if link.turned else ""
    offset = " + offset" if link.c.any() else ""
    if link.A.shape[0] == link.A.shape[1] and np.array_equal(link.A, link.A[0, 0] * np.eye(len(link.A))):
        factor = float(link.A[0, 0])
        return turned + ("as it is" if factor == 1.0 and not offset and not turned else f"times {factor:.6g}{offset}")
    axes = [_axis(row) for row in link.A]
    if all(axes) and scale > 0:
        return f"{turned}{' '.join(axes)}" + (f", times {scale:.6g}" if scale != 1.0 else "") + offset
    return f"{turned}matrix{offset}"


def _axis(row: np.ndarray) -> str:
    """The axis of ours that a row of theirs takes, with its sign; empty where it takes several."""
    (taken,) = np.nonzero(row)
    if len(taken) != 1 or taken[0] > 2:
        return ""
    return f"{'+' if row[taken[0]] > 0 else '-'}{'xyz'[taken[0]]}"
