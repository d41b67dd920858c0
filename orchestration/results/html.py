"""HTML pages that hold all that they show and ask no network for anything: one style, and plots drawn from data.

Markup and prose stand in templates, see `pieces`. What is put into one is escaped unless it is Markup already; data go
in as JSON in a script element that no browser executes. The page's security policy lets no script run but its own, by
its hash. Jinja2 would do for the templates, but takes 80 ms to import, and every run writes a page.
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
from .data import RunData
from .figures import COLOURS
from .phases import bands
from .plots import faulty

_ASSETS = Path(__file__).parent / "assets"
_VIEW = ("ogl.iife.min.js", "motion.js", "scene.js", "view.js")


@cache
def pieces(name: str) -> dict[str, Markup]:
    """The pieces of a template by name. Each stands below a line `<!-- name -->`, and has `{value}` where values go."""
    _, *parts = re.split(r"^<!-- (\w+) -->\n", asset(name), flags=re.MULTILINE)
    return {part: Markup(text) for part, text in zip(parts[::2], parts[1::2], strict=True)}


def asset(name: str) -> str:
    """Returns the text of a file beside the templates, or of one that stands elsewhere, by its whole path."""
    return (_ASSETS / name).read_text("utf-8").replace("\r\n", "\n")


def part(template: str, name: str, content: str, **more: object) -> Markup:
    """A piece of a template with its content; nothing where there is none."""
    return pieces(template)[name].format(content=content, **more) if content else Markup("")


def joined(parts: Iterable[object]) -> Markup:
    """Parts in a row, escaped where they are not Markup."""
    return Markup("").join(parts)  # type: ignore[arg-type]


def each(piece: Markup, values: Iterable[object]) -> Markup:
    """A piece filled with each of the values."""
    return joined(piece.format(value) for value in values)


def items(values: Iterable[object]) -> Markup:
    """Items of a list."""
    return each(Markup("<li>{}</li>\n"), values)


def rows(cells: Iterable[Iterable[object]], labels: Sequence[str] = ()) -> Markup:
    """Rows of a table. With labels, the names of its columns, a row becomes a card on a narrow screen."""
    cell = Markup('<td data-label="{}">{}</td>')
    named = (joined(cell.format(label, value) for label, value in zip(labels, row, strict=True)) for row in cells)
    return each(Markup("<tr>{}</tr>\n"), named if labels else (each(Markup("<td>{}</td>"), row) for row in cells))


def cards(piece: Markup, cells: Iterable[Iterable[object]], *more: str) -> Markup:
    """Rows of the table in a piece of a template, each cell with the name of its column there, or of `more` after these."""
    return rows(cells, [*re.findall(r"<th[^>]*>([^<]*)</th>", piece), *more])


def verdict(word: str) -> Markup:
    """A verdict of one word or two, in its colour; a dash where there is none."""
    kinds = {
        "": "plain",
        "not evaluated": "plain",
        "allowed": "plain",
        "met": "good",
        "ok": "good",
        "undecided": "warn",
    }
    kind = kinds.get(word, "bad")
    return Markup('<span class="{}">{}</span>').format(kind, word or "\N{EN DASH}")


def key(kind: str, text: str) -> Markup:
    """An entry of a plot's legend: a sample of what is drawn (shade, fault, limit, mark), and what it is."""
    return Markup('<span class="key {}"></span>{}').format(kind, text)


class Page:
    """A page in the making: its plots, and the arrays that they draw."""

    def __init__(self, result: RunData | None = None, live: bool = False, faults: bool = False) -> None:
        """The page of a run with its cycle and faults, or of something else; a live one shows other runs, with `faults` too."""
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
        """Plots side by side, with a title above and a caption below. `kind` is the class of their frame."""
        plots, notes = list(plots), list(notes)
        if lines := list(dict.fromkeys(plot.get("lines_are", "limits") for plot in plots if plot["lines"])):
            notes.append(key("limit", f"dashed: {', '.join(lines)}"))
        if self._data["faults"] or self._faulty:
            notes.append(key("fault", "red: a fault acts"))
        if self._data["phases"]:
            notes.append("coloured and named: phases")
        if any(plot["thinned"] for plot in plots):
            notes.append("drawn with fewer samples than recorded, the lowest and highest among them")
        places = [self._place(plot, title) for plot in plots]
        return pieces("pieces.html")["figure"].format(
            title=title, about=about, plots=joined(places), kind=kind, caption=Markup("; ").join(notes)
        )

    def _place(self, plot: dict[str, Any], title: str) -> Markup:
        self._plots.append(plot)
        return pieces("pieces.html")["plot"].format(number=len(self._plots) - 1, name=f"{title}: {plot['label']}")

    def view(self, data: dict[str, Any] | None) -> Markup:
        """The place of a three-dimensional view with its controls; nothing where there are no data of one."""
        if data is None:
            return Markup("")
        self._seen = {"view": data, "coastlines": json.loads(asset("coastlines.json"))}
        return pieces("pieces.html")["view"].format(name=data["name"])

    def html(
        self, title: str, parts: Iterable[Markup], script: str = "", policy: str = "", more: Mapping[str, object] = {}
    ) -> str:
        """The whole page; with a script of its own, what the security policy allows that, and more data for it."""
        library = asset("uPlot.iife.min.js")
        # The library takes the pixels to the point from the screen; on paper they are more. So it gets them from the page.
        wrapped = asset("resolution.js").replace("/* library */", library)
        view = "\n".join(map(asset, _VIEW)) if self._seen else ""
        drawing = f"{wrapped}\n{asset('plots.js')}\n{view}\n{script}"
        digest = base64.b64encode(hashlib.sha256(drawing.encode()).digest()).decode()
        return pieces("pieces.html")["page"].format(
            script_hash=digest,
            policy=policy,
            title=title,
            style=Markup(f"{asset('uPlot.min.css')}\n{STYLE.read_text('utf-8')}\n{asset('page.css')}"),
            body=joined(parts),
            data=embedded({**self._data, **self._seen, "arrays": self.arrays.items, "plots": self._plots, **more}),
            script=Markup(drawing),
        )


def embedded(data: object) -> Markup:
    """JSON that can end no script element. Raises ValueError for a number that JSON does not know."""
    text = json.dumps(data, allow_nan=False, ensure_ascii=True, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))
