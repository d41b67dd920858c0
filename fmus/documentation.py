"""documentation/index.html of an FMU, made from its interface."""

from __future__ import annotations

from html import escape

from .interface import Interface, Variable

_STYLE = (
    "body{font:15px/1.5 sans-serif;max-width:75em;margin:2em auto;padding:0 1em}"
    "table{border-collapse:collapse;width:100%}td,th{border-bottom:1px solid #ccc;padding:.3em .6em;"
    "text-align:left;vertical-align:top}code{white-space:nowrap}"
)
_HEADINGS = {"input": "Inputs", "output": "Outputs", "parameter": "Parameters"}


def index_html(interface: Interface) -> bytes:
    """A page that lists every port and parameter."""
    parts = [
        f'<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8"><title>{escape(interface.name)}</title>',
        f"<style>{_STYLE}</style></head>\n<body>\n<h1>{escape(interface.name)}</h1>",
        f"<p>{escape(interface.description)}. FMI 2.0 for co-simulation.</p>",
        "<p>Vectors and matrices are named element by element, one-based and row by row: "
        "<code>omega_B[1]</code>, <code>R_NB[2,3]</code>. Initial values hold at the start of the experiment, "
        "which is the block's t = 0.</p>",
    ]
    for causality, heading in _HEADINGS.items():
        variables = [v for v in interface.variables.values() if v.causality == causality]
        if variables:
            parts.append(f"<h2>{heading}</h2>\n{_table(variables, causality)}")
    return ("\n".join(parts) + "\n</body>\n</html>\n").encode()


def _table(variables: list[Variable], causality: str) -> str:
    columns = ["Name", "Shape", "Unit", "Frame"]
    columns += ["Depends directly on"] if causality == "output" else ["Start", "Range"]
    columns += ["Variability", "Description"] if causality == "parameter" else ["Description"]
    rows = [_row("th", columns)]
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
        rows.append(_row("td", [*cells, escape(v.description)]))
    return "<table>\n" + "\n".join(rows) + "\n</table>"


def _row(tag: str, cells: list[str]) -> str:
    return "<tr>" + "".join(f"<{tag}>{cell}</{tag}>" for cell in cells) + "</tr>"


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
