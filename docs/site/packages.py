"""Draws docs/figures/packages.svg, the packages of orchestration and their imports: `python -m docs.site.packages`.

The layers are those of pyproject.toml, the imports those of the code. An import that a chain of others implies is not
drawn. Tests: tests/docs/test_site.py.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import grimp
import numpy as np

ROOT = Path(__file__).parents[2]
TARGET = ROOT / "docs" / "figures" / "packages.svg"
WIDTH, ROW, BOX = 800.0, 58.0, (132.0, 30.0)
APART = 14.0  # between two lines, and from a line to a box that it passes


def layers() -> list[list[str]]:
    """The layers of orchestration, top first; each with its packages."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    (ours,) = [c for c in contracts if c.get("containers") == ["orchestration"]]
    return [[name.strip() for name in layer.split("|")] for layer in ours["layers"]]


def imports() -> set[tuple[str, str]]:
    """Which package of orchestration imports which."""
    graph = grimp.build_graph("orchestration")
    found = set()
    for module in graph.modules:
        for other in graph.find_modules_directly_imported_by(module):
            pair = (module.split(".")[1:2], other.split(".")[1:2])
            if pair[0] and pair[1] and pair[0] != pair[1]:
                found.add((pair[0][0], pair[1][0]))
    return found


def reduced(pairs: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """The pairs without those that a chain of others implies; there is no ring."""
    below: dict[str, set[str]] = {}
    for upper, lower in pairs:
        below.setdefault(upper, set()).add(lower)

    def reach(name: str) -> set[str]:
        return set().union(*({other} | reach(other) for other in below.get(name, ())))

    return {(a, b) for a, b in pairs if not any(b in reach(c) for c in below[a] if c != b)}


def lane(x: float, u: float, boxes: list[float], taken: list[float]) -> float:
    """The abscissa at which a line from `x` to `u` passes between the boxes at `boxes` and beside the lines at
    `taken`."""
    free = [
        at
        for at in np.arange(APART, WIDTH, APART / 2)
        if all(abs(at - box) >= BOX[0] / 2 + APART for box in boxes) and all(abs(at - line) >= APART for line in taken)
    ]
    return float(min(free, key=lambda at: abs(at - x) + abs(at - u) + abs(at - WIDTH / 2) / 100))


def drawing() -> str:
    """The SVG: a row for each layer, a line for each import, from the upper package to the lower one, behind no box."""
    rows = layers()
    place = {
        name: (WIDTH / 2 + (i - (len(row) - 1) / 2) * 210.0, 30.0 + ROW * k)
        for k, row in enumerate(rows)
        for i, name in enumerate(row)
    }
    height = ROW * len(rows) + 10
    lines = []
    passing: list[list[float]] = [[] for _ in rows]
    for upper, lower in sorted(reduced(imports())):
        if upper not in place or lower not in place:
            continue
        (x, y), (u, v) = place[upper], place[lower]
        passed = range(round((y - 30.0) / ROW) + 1, round((v - 30.0) / ROW))
        start, end, gap = y + BOX[1] / 2, v - BOX[1] / 2, ROW - BOX[1]
        if passed:
            boxes = [place[name][0] for k in passed for name in rows[k]]
            near = range(passed[0] - 1, passed[-1] + 2)  # with the gaps above and below
            at = lane(x, u, boxes, [line for k in near for line in passing[k]])
            for k in passed:
                passing[k].append(at)
            way = (
                f"C{x:.0f},{start + gap:.0f} {at:.0f},{start:.0f} {at:.0f},{start + gap:.0f} L{at:.0f},{end - gap:.0f} "
                f"C{at:.0f},{end:.0f} {u:.0f},{end - gap:.0f} {u:.0f},{end:.0f}"
            )
        else:
            way = f"C{x:.0f},{start + gap / 2:.0f} {u:.0f},{end - gap / 2:.0f} {u:.0f},{end:.0f}"
        lines.append(
            f'<path d="M{x:.0f},{start:.0f} {way}" fill="none" stroke="#0072b2" stroke-opacity=".8" '
            'marker-end="url(#tip)"/>'
        )
    for name, (x, y) in place.items():
        lines.append(
            f'<rect x="{x - BOX[0] / 2:.0f}" y="{y - BOX[1] / 2:.0f}" width="{BOX[0]:.0f}" height="{BOX[1]:.0f}" '
            'rx="6" '
            f'fill="#f4f7fa" stroke="#444"/><text x="{x:.0f}" y="{y + 5:.0f}" text-anchor="middle">{name}</text>'
        )
    body = "\n".join(lines)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:.0f} {height:.0f}" font-family="sans-serif" '
        'font-size="14" role="img" aria-label="Packages of orchestration and their imports">\n'
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0,0 L8,4 L0,8z" fill="#0072b2"/></marker></defs>\n'
        f'<rect width="{WIDTH:.0f}" height="{height:.0f}" fill="#ffffff"/>\n{body}\n</svg>\n'
    )


if __name__ == "__main__":
    TARGET.write_text(drawing(), "utf-8")
