"""docs/evidence/sweep.md from docs/evidence/sweep.csv."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import groupby
from pathlib import Path

from .. import markdown
from ..paper import ROOT
from .cases import GROUPS
from .constants import CONSTANTS, NOT_SWEPT, Constant, of_group
from .loop import value_of
from .measures import FILE, MEASURES, Line, load

WORDS = {"settled": "settles", "found": "detected", "hold": "hold"}
"""Measures of which the page has ratios, as it says them."""
OUTCOMES = {"settled": "settled", "found": "detected"}


def publish(folder: Path = ROOT / "docs" / "evidence") -> Path:
    """Writes the page from the file in the folder; returns it."""
    target = folder / "sweep.md"
    target.write_text(text(load(folder / FILE)), "utf-8")
    return target


def text(lines: list[Line]) -> str:
    """The page."""
    groups = []
    for name in (name for name in GROUPS if any(line.group == name for line in lines)):
        of = [line for line in lines if line.group == name]
        chosen = [line for line in of if not line.name]
        groups.append(
            {
                "name": name,
                "runs": max(line.runs for line in chosen),
                "chosen": _as_they_are(chosen),
                "rows": _rows(name, of),
                "bare": all(math.isnan(line.error) for line in of),
            }
        )
    compared = [line for line in lines if line.name and line.measure in WORDS]
    return markdown.render(
        Path(__file__).parent,
        groups=groups,
        count=len({(line.file, line.name) for line in lines if line.name}),
        waiting=_waiting(lines),
        acquisitions=groups[0]["runs"],
        compared=len(compared),
        better=_better(lines),
        nothing=_nothing(lines),
        together=_together(lines),
        left_out=[[reason, ", ".join(f"`{name}`" for name in names.split())] for reason, names in NOT_SWEPT.items()],
    )


def _named(constant: Constant) -> str:
    return f"`{constant.name}` ({constant.file})"


def _size(measure: str, value: float) -> str:
    return f"{value:.0f} s" if MEASURES[measure].unit == "s" else f"{value:.2g}°"


def _as_they_are(chosen: list[Line]) -> str:
    """What is told of the flights with the chosen values."""
    parts = []
    for line in chosen:
        reached = f"{line.reached} of {line.runs}"
        if line.measure in OUTCOMES:
            parts.append(f"{reached} {OUTCOMES[line.measure]}, median {line.median:.0f} s, worst {_worst(line)}")
        elif line.measure == "hold":
            well = f"hold {_size('hold', line.median)} rms at the median, {_worst(line)} at worst"
            parts.append(well if math.isfinite(line.median) else _missed(line))
        elif line.reached < line.runs:
            parts.append(_missed(line))
    return "; ".join(parts)


def _worst(line: Line) -> str:
    if math.isfinite(line.worst):
        return _size(line.measure, line.worst)
    return "lost" if line.measure == "hold" else "never"


def _missed(line: Line) -> str:
    return f"{line.runs - line.reached} of {line.runs} {MEASURES[line.measure].missed}"


def _rows(group: str, lines: list[Line]) -> list[list[str]]:
    values = {key: list(of) for key, of in groupby(lines, lambda line: line.key)}
    rows = []
    for constant in of_group(group):
        cells = [_cell(of) for key, of in values.items() if key[1:3] == (constant.file, constant.name)]
        if cells:
            rows.append([_named(constant), constant.what, value_of(constant.file, constant.name), *cells])
    return rows


def _waiting(lines: list[Line]) -> list[list[str]]:
    """Constants of each group that the file does not have yet."""
    flown = {(line.group, line.file, line.name) for line in lines}
    rows = [[g, ", ".join(_named(c) for c in of_group(g) if (g, c.file, c.name) not in flown)] for g in GROUPS]
    return [row for row in rows if row[1]]


def _cell(lines: list[Line]) -> str:
    parts = []
    for line in lines:
        if line.measure in WORDS:
            error = f" ± {line.ratio * line.error:.2f}" if line.error >= 0.005 else ""
            ratio = f"{line.ratio:.2f}{error} ×"
            parts.append(f"{WORDS[line.measure]} {f'**{ratio}**' if line.change else ratio}, worst {_worst(line)}")
        if line.reached < line.runs:
            parts.append(_missed(line))
    return f"{lines[0].value:g}: " + "; ".join(parts)


def _better(lines: list[Line]) -> list[list[str]]:
    """Values with which something is better than with the chosen one, and nothing worse."""
    chosen = {(line.group, line.measure): line.reached for line in lines if not line.name}
    rows = []
    for key, of in groupby((line for line in lines if line.name), lambda line: line.key):
        values = list(of)
        fewer = [chosen[key[0], v.measure] - v.reached for v in values]
        worse = max(line.change for line in values) > 0.0 or max(fewer) > 0
        if not worse and (min(line.change for line in values) < 0.0 or min(fewer) < -1):
            rows.append([f"`{key[2]}` ({key[1]})", key[0], value_of(key[1], key[2]), _cell(values)])
    return rows


def _nothing(lines: list[Line]) -> list[list[str]]:
    """Constants that change no flight of any group in which they are swept."""
    told = {(line.group, line.measure): _told(line) for line in lines if not line.name}
    changing: dict[tuple[str, str], bool] = {}
    for line in (line for line in lines if line.name):
        key = line.file, line.name
        changing[key] = changing.get(key, False) or not _is_same(line, told)
    same = (c for c in CONSTANTS if not changing.get((c.file, c.name), True))
    flown = {(line.file, line.name, line.group) for line in lines}
    return [
        [_named(c), c.what, value_of(c.file, c.name), ", ".join(g for g in GROUPS if (c.file, c.name, g) in flown)]
        for c in same
    ]


def _together(lines: list[Line]) -> list[list[str]]:
    """Values of several constants with which the flights of a group are the same, and others than with the chosen ones."""
    same: dict[tuple[str, ...], list[str]] = {}
    for key, of in groupby((line for line in lines if line.name), lambda line: line.key):
        values = list(of)
        if any(v.ratio != 1.0 and not math.isnan(v.ratio) for v in values):
            told = (str(replace(v, file="", name="", value=0.0)) for v in values)
            same.setdefault((key[0], *told), []).append(f"`{key[2]}` ({key[1]}) {key[3]:g}")
    return [[told[0], ", ".join(names)] for told, names in same.items() if len(names) > 1]


def _told(line: Line) -> tuple[int, float, float]:
    return line.reached, line.median, line.worst


def _is_same(line: Line, told: dict[tuple[str, str], tuple[int, float, float]]) -> bool:
    return _told(line) == told[line.group, line.measure] and (
        math.isnan(line.ratio) or (line.ratio == 1.0 and not line.error > 0.0)
    )
