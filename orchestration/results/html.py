"""HTML pages that hold all that they show and ask no network for anything: one style, and plots drawn from data.

Markup and prose stand in templates, see `pieces`. What is put into one is escaped unless it is Markup already; data go
in as JSON in a script element that no browser executes. The page's security policy lets no script run but its own, by
its hash. Jinja2 would do for the templates, but takes 80 ms to import, and every run writes a page.

Tests: tests/orchestration/results/test_report.py, test_browser.py.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from markupsafe import Markup

from fmus.contents.documentation import STYLE

from .arrays import Arrays
from .curves import COLOURS
from .data import RunData
from .phases import bands
from .plots import faulty

_ASSETS = Path(__file__).with_name("assets")
_PLOTS = ("plots.js",)
_VIEW = ("ogl.iife.min.js", "motion.js", "earth.js", "scene.js", "view.js")
_KINDS = {
    "met": "good",
    "ok": "good",
    "undecided": "warn",
    "": "plain",
    "not evaluated": "plain",
    "not tested": "plain",
    "allowed": "plain",
}
"""The colours of verdicts; any other one is bad."""


@cache
def pieces(name: str | Path) -> dict[str, Markup]:
    """Returns the pieces of a template by name.

    Each stands below a line `<!-- name -->`, and has `{value}` where values go.
    """
    _, *parts = re.split(r"^<!-- (\w+) -->\n", asset(name), flags=re.MULTILINE)
    return {part: Markup(text) for part, text in zip(parts[::2], parts[1::2], strict=True)}


def asset(name: str | Path) -> str:
    """Returns the text of a file that all pages share, by its name, or of one beside its owner, by its path."""
    return (_ASSETS / name).read_text("utf-8").replace("\r\n", "\n")


def piece(name: str, /, **values: object) -> Markup:
    """Returns a piece that all pages share, with its values."""
    return pieces("pieces.html")[name].format(**values)


def part(template: str | Path, name: str, content: str, **more: object) -> Markup:
    """Returns a piece of a template with its content; nothing where there is none."""
    return pieces(template)[name].format(content=content, **more) if content else Markup("")


def joined(parts: Iterable[object]) -> Markup:
    """Returns parts in a row, escaped where they are not Markup."""
    return Markup("").join(parts)  # type: ignore[arg-type]


def each(text: str, values: Iterable[object]) -> Markup:
    """Returns a piece of markup filled with each of the values."""
    return joined(Markup(text).format(value) for value in values)


def header(title: str, lead: str, badges: Iterable[tuple[str, str]], *content: object) -> Markup:
    """Returns the head of a page; each badge is a class for its colour, and words."""
    shown = joined(Markup('<span class="badge {}">{}</span>\n').format(*badge) for badge in badges)
    return piece("header", title=title, lead=lead, badges=shown, content=joined(content))


def facts(entries: Mapping[str, object]) -> Markup:
    """Returns names and values, without those that are empty."""
    fact = Markup("<div><dt>{}</dt><dd>{}</dd></div>\n")
    return piece("facts", content=joined(fact.format(*entry) for entry in entries.items() if entry[1]))


def section(heading: str, content: str, before: str = "") -> Markup:
    """Returns a section of a page, with its content and what stands before it; nothing where there is no content."""
    return piece("section", heading=heading, content=before + content) if content else Markup("")


def listed(values: Iterable[object], kind: str = "") -> Markup:
    """Returns a list; nothing where there are no values."""
    found = each("<li>{}</li>\n", values)
    return Markup('<ul class="{}">\n{}</ul>\n').format(kind, found) if found else found


def table(columns: Sequence[str], cells: Iterable[Iterable[object]], kind: str = "") -> Markup:
    """Returns a table, whose rows become cards on a narrow screen; nothing where there are no rows."""
    head = joined(each('<th scope="col">{}</th>', [name]) if name else Markup("<td></td>") for name in columns)
    body = rows(cells, columns)
    return piece("table", kind=kind, head=head, body=body) if body else body


def rows(cells: Iterable[Iterable[object]], labels: Sequence[str] = ()) -> Markup:
    """Returns rows of a table. With labels, the names of its columns, a row becomes a card on a narrow screen."""
    cell = Markup('<td data-label="{}">{}</td>')
    named = (joined(cell.format(label, value) for label, value in zip(labels, row, strict=True)) for row in cells)
    return each("<tr>{}</tr>\n", named if labels else (each("<td>{}</td>", row) for row in cells))


def cards(template: Markup, cells: Iterable[Iterable[object]], *more: str) -> Markup:
    """Returns rows of the table in a piece, each cell with the name of its column there, or of `more` after these."""
    return rows(cells, [*re.findall(r"<th[^>]*>([^<]*)</th>", template), *more])


def fold(
    heading: str, about: str, plots: Iterable[Markup], *content: object, kind: str = "", opened: str = ""
) -> Markup:
    """Returns plots, and what stands below them, that a click shows."""
    return piece(
        "fold", heading=heading, about=about, plots=joined(plots), content=joined(content), kind=kind, open=opened
    )


def verdict(word: str) -> Markup:
    """Returns a verdict of one word or two, in its colour; a dash where there is none."""
    return Markup('<span class="{}">{}</span>').format(_KINDS.get(word, "bad"), word or "\N{EN DASH}")


def key(kind: str, text: str) -> Markup:
    """Returns an entry of a plot's legend: a sample of what is drawn (shade, fault, limit, mark), and what it is."""
    return Markup('<span class="key {}"></span>{}').format(kind, text)


class Page:
    """A page in the making: its plots, and the arrays that they draw."""

    def __init__(self, result: RunData | None = None, live: bool = False, faults: bool = False) -> None:
        """The page of a run has its cycle and faults; a live one shows other runs, with `faults` too."""
        self.arrays = Arrays()
        self.live = live
        self._faulty = faults
        self._plots: list[dict[str, Any]] = []
        self._seen: dict[str, Any] = {}
        cycle = result.scenario.cycle if result is not None else None
        self._data = {
            "colours": COLOURS,
            "cycle": cycle and {"name": cycle.name, "period": cycle.period},
            "faults": faulty(result) if result is not None and len(result.time) else [],
            "phases": bands(result) if result is not None else [],
        }

    def figure(
        self, title: str, plots: Iterable[dict[str, Any]], about: str = "", notes: Iterable[str] = (), kind: str = ""
    ) -> Markup:
        """Returns plots side by side, with a title above and a caption below; `kind` is the class of their frame."""
        plots, notes = list(plots), list(notes)
        if lines := list(dict.fromkeys(plot.get("lines_are", "limits") for plot in plots if plot["lines"])):
            notes.append(key("limit", f"dashed: {', '.join(lines)}"))
        if self._data["faults"] or self._faulty:
            notes.append(key("fault", "red: a fault acts"))
        if self._data["phases"]:
            notes.append("coloured and named: phases")
        if any(plot["thinned"] for plot in plots):
            notes.append("drawn with fewer samples than recorded, the lowest and highest among them")
        places = joined(self._place(plot, title) for plot in plots)
        caption = Markup("; ").join(notes)
        return piece("figure", title=title, about=about, plots=places, kind=kind, caption=caption)

    def _place(self, plot: dict[str, Any], title: str) -> Markup:
        self._plots.append(plot)
        return piece("plot", number=len(self._plots) - 1, name=f"{title}: {plot['label']}")

    def view(self, data: dict[str, Any] | None) -> Markup:
        """Returns the place of a three-dimensional view with its controls; nothing where there are no data of one."""
        if data is None:
            return Markup("")
        self._seen = {"view": data, "coastlines": json.loads(asset("coastlines.json"))}
        return piece("view", name=data["name"])

    def html(
        self,
        title: str,
        parts: Iterable[Markup],
        script: str = "",
        policy: str = "",
        style: str = "",
        more: Mapping[str, object] = {},
    ) -> str:
        """Returns the whole page, with script and style of its own, what the security policy allows that, and more
        data.
        """
        # The library takes the pixels to the point from the screen; on paper they are more. So the page gives them.
        library = asset("resolution.js").replace("/* library */", asset("uPlot.iife.min.js"))
        drawing = "\n".join([library, *map(asset, _PLOTS + (_VIEW if self._seen else ())), script])
        return piece(
            "page",
            script_hash=base64.b64encode(hashlib.sha256(drawing.encode()).digest()).decode(),
            policy=policy,
            title=title,
            style=Markup("\n".join([asset("uPlot.min.css"), STYLE.read_text("utf-8"), asset("page.css"), style])),
            body=joined(parts),
            data=embedded({**self._data, **self._seen, "arrays": self.arrays.items, "plots": self._plots, **more}),
            script=Markup(drawing),
        )


def embedded(data: object) -> Markup:
    """Returns JSON that can end no script element. Raises ValueError for a number that JSON does not know."""
    text = json.dumps(data, allow_nan=False, ensure_ascii=True, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))
