"""documentation/index.html of an FMU, made from its interface. Tests: tests/fmus/contents/test_contents.py."""

from __future__ import annotations

from html import escape
from pathlib import Path

from ..interface import Interface, Variable, citations, optional_text

STYLE = Path(__file__).with_name("page.css")
"""The style that the pages of FMUs, runs, comparisons and campaigns share."""
_OWN = (
    "svg{display:block;max-width:860px;width:100%;background:#fff;color:#1b1f24;border-radius:.4rem}"
    ".icon{width:6rem;background:#fff;border-radius:.4rem}"
)
_SYMBOLS = "e1, e2, e3 are the unit vectors of the body axes; x^ is the matrix with x^ y = x × y."
_DRAWING = Path(__file__).with_name("frames.svg")
_FRAMES = (
    "N is the inertial frame: mean equator and equinox of date, with the Earth turned by GMST (not GCRS). "
    "L (LVLH) has Z to nadir and Y against the orbital angular momentum. B is the body frame; the wheel spins "
    "about wheel_axis, by default e1, its X axis. "
    "'rods' means components along the rod axes u1, u2, u3. 'N from B' maps components in B to components in N: "
    "x_N = R_NB x_B."
)
_HEADINGS = {"input": "Inputs", "output": "Outputs", "parameter": "Parameters"}


def index_html(interface: Interface, host: str, version: int = 2) -> bytes:
    """A page that lists equations, limits, terminals, and every port and parameter. `host`: what a host must have."""
    parts = [
        '<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8">'
        '<meta name="color-scheme" content="light dark">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(interface.name)}</title>\n<style>{STYLE.read_text('utf-8')}{_OWN}</style></head>",
        "<body>\n<main>\n<img class='icon' src='icon.svg' alt=''>",
        f"<h1>{escape(interface.name)}</h1>",
        content(interface, host, "licenses/license.txt", version),
    ]
    return ("\n".join(parts) + "\n</main>\n</body>\n</html>\n").encode()


def content(interface: Interface, host: str, licence: str, version: int = 2) -> str:
    """Returns the page below its heading, for the documentation site too. `licence`: the link to it."""
    by_element = "named element by element, one-based and row by row: <code>omega_B[1]</code>, <code>R_NB[2,3]</code>"
    written = by_element if version == 2 else "arrays, row by row; one whose units differ is named element by element"
    parts = [
        f"<p>{escape(interface.description)}. FMI {version}.0 for co-simulation.</p>",
        f"<p>Vectors and matrices are {written}. Initial values hold at the start of the experiment, "
        "which is the block's t = 0. Where the host gives a stop time, a step that ends more than a hundredth of "
        "itself "
        f"beyond it is refused. Licence: <a href='{licence}'>BSD-3-Clause</a>.</p>",
    ]
    if cited := citations(interface):
        parts.append(f"<p>{escape(cited)}</p>")
    parts.append(f"<h2>What a host needs</h2>\n<p>{escape(host)}</p>")
    parts.append(f"<h2>Frames</h2>\n{_DRAWING.read_text('utf-8')}<p>{escape(_FRAMES)}</p>")
    if interface.equations:
        rows = [[f"<code>{escape(formula)}</code>", escape(meaning)] for formula, meaning in interface.equations]
        parts.append(f"<h2>Equations</h2>\n{_cards(['Equation', 'Meaning'], rows)}")
        parts.append(f"<p>{escape(_SYMBOLS)}</p>")
    if interface.limits:
        items = "\n".join(f"<li>{escape(limit)}</li>" for limit in interface.limits)
        parts.append(f"<h2>Limits</h2>\n<ul>\n{items}\n</ul>")
    if interface.terminals:
        rows = []
        for name, members in interface.terminals.items():
            names = ", ".join(f"<code>{escape(member)}</code>" for member in members)
            rows.append([f"<code>{escape(name)}</code>", interface.variables[members[0]].causality, names])
        about = "Ports that are wired together. Terminals of one name on two blocks fit each other."
        parts.append(f"<h2>Terminals</h2>\n<p>{about}</p>\n{_cards(['Terminal', 'Causality', 'Variables'], rows)}")
    for causality, heading in _HEADINGS.items():
        variables = [v for v in interface.variables.values() if v.causality == causality]
        if variables:
            parts.append(f"<h2>{heading}</h2>\n{_table(variables, causality)}")
    return "\n".join(parts)


def _table(variables: list[Variable], causality: str) -> str:
    columns = ["Name", "Shape", "Unit", "Frame"]
    columns += ["Depends directly on"] if causality == "output" else ["Start", "Range"]
    columns += ["Variability", "Description"] if causality == "parameter" else ["Description"]
    rows = []
    for v in variables:
        cells = [
            f"<code>{escape(v.name)}</code>",
            " × ".join(map(str, v.shape)),
            escape(_unit(v)),
            escape(v.frame or ""),
        ]
        if causality == "output":
            cells.append(escape(", ".join(v.depends_on)))
        else:
            cells += [f"{escape(str(v.start))}", escape(_range(v))]
        if causality == "parameter":
            cells.append(v.variability)
        about = v.description + (f"; {optional_text(v)}" if v.optional else "")
        rows.append([*cells, escape(about)])
    return _cards(columns, rows)


def _cards(columns: list[str], rows: list[list[str]]) -> str:
    """A table whose rows become cards on a narrow screen."""
    head = "".join(f'<th scope="col">{column}</th>' for column in columns)
    body = "\n".join(
        "<tr>" + "".join(f'<td data-label="{c}">{cell}</td>' for c, cell in zip(columns, row, strict=True)) + "</tr>"
        for row in rows
    )
    table = f"<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>"
    return f'<div class="scroll"><table class="named">\n{table}</table></div>'


def _unit(v: Variable) -> str:
    if v.type != "real":
        return v.type
    name = v.unit or "1"
    return f"{name} (shown in {v.display_unit})" if v.display_unit else name


def _range(v: Variable) -> str:
    if v.type == "enumeration":
        return ", ".join(v.items)
    if v.min is None and v.max is None:
        return ""
    return f"{'' if v.min is None else v.min} … {'' if v.max is None else v.max}"
