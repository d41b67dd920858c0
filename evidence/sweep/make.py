"""Flies the flights of each group with its constants at half and at twice their values, and writes docs/evidence/sweep.csv and docs/evidence/sweep.md."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from ctypes import CDLL
from itertools import groupby
from pathlib import Path

import numpy as np

from .. import files
from ..paper import Array
from .cases import GROUPS
from .constants import of_group
from .loop import Flight, built, flown, put, value_of
from .measures import FILE, MEASURES, Key, Line, line, load
from .page import publish

__all__ = ["FILE", "load", "make", "publish"]


def make(acquisitions: int, file: Path) -> Iterator[str]:
    """Tells of each value, saved as it is flown. A group of other flights, or of flights that have changed, begins anew."""
    known = {key: list(lines) for key, lines in groupby(load(file), lambda k: k.key)} if file.is_file() else {}
    lines: list[Line] = []
    with tempfile.TemporaryDirectory() as folder:
        library = built(Path(folder, "loop"))
        for group, cases in GROUPS.items():
            flights = cases.flights(acquisitions if group == "acquisition" else cases.runs)
            others = [each for key in known if key[0] not in {k.group for k in lines} | {group} for each in known[key]]
            chosen = _fly(library, flights, cases.measures)
            now = list(_lines((group, "", "", 0.0), flights, chosen, chosen))
            kept = known if _same(known.get(now[0].key, []), now) else {}
            lines += now
            for file_name, name, usual, value in _values(group):
                key = (group, file_name, name, float(value))
                if key not in kept:
                    put(library, file_name, name, value)
                    kept = {**kept, key: list(_lines(key, flights, _fly(library, flights, cases.measures), chosen))}
                    put(library, file_name, name, usual)
                lines += kept[key]
                files.save(Line, file, [*lines, *others])
                told = ", ".join(
                    f"{each.measure} {each.reached} of {each.runs}, {each.ratio:.3f}" for each in kept[key]
                )
                yield f"{group}: {name} {value}: {told}"


def _values(group: str) -> Iterator[tuple[str, str, str, str]]:
    """File, name, chosen and other value of the group's constants."""
    for constant in of_group(group):
        usual = value_of(constant.file, constant.name)
        for factor in constant.factors:
            yield constant.file, constant.name, usual, _scaled(usual, factor)


def _fly(library: CDLL, flights: list[Flight], measures: Iterable[str]) -> dict[str, Array]:
    """Each measure of the flights (n,)."""
    told = [flown(library, flight) for flight in flights]
    return {name: np.array([*map(MEASURES[name].of, flights, told)]) for name in measures}


def _lines(key: Key, flights: list[Flight], values: dict[str, Array], chosen: dict[str, Array]) -> Iterator[Line]:
    for name in values:
        most = np.array([MEASURES[name].many(flight) for flight in flights])
        yield line(key, name, values[name], chosen[name], most)


def _same(known: list[Line], now: list[Line]) -> bool:
    def rounded(each: Line) -> tuple[object, ...]:
        return each.measure, each.runs, each.reached, f"{each.median:.4g}", f"{each.worst:.4g}"

    return [*map(rounded, known)] == [*map(rounded, now)]


def _scaled(value: str, factor: float) -> str:
    """A whole number stays one."""
    return f"{max(1, round(int(value) * factor))}" if value.isdigit() else f"{float(value) * factor:g}"
