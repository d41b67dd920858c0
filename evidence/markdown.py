"""What the studies' pages share: templates, tables, shares and angles as text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from .paper import Array


def render(folder: Path, **fields: Any) -> str:
    """The page of the template page.md.j2 in `folder`. Raises jinja2.UndefinedError for a field that is not given."""
    environment = Environment(
        loader=FileSystemLoader(folder),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=False,
    )
    environment.filters["table"] = table
    return environment.get_template("page.md.j2").render(fields).strip() + "\n"


def table(rows: Sequence[Sequence[str]], header: str) -> str:
    """A Markdown table; the header's cells are divided by `|`."""
    head = header.split("|")
    body = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, ["---"] * len(head), *body))


def degrees(value: float) -> str:
    """An angle in deg to two digits."""
    return f"{value:.2g}°" if value < 9.95 else f"{value:.0f}°"


def finite(values: Array) -> str:
    """Returns how many of the values are finite: `46 of 50`."""
    return f"{int(np.isfinite(values).sum())} of {len(values)}"


def orbits(value: float) -> str:
    """A settling time in orbits."""
    return f"{value:.3f}" if math.isfinite(value) else "not settled"
