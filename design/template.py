"""Files with values left open: what has to be given, and the files that follow.

A folder of templates has values.yaml, which says what is left open. In its other files @NAME@ stands for a value as
YAML, and @#NAME@ for text as it is. Tests: tests/design/test_new_satellite.py.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from orchestration import InputError
from orchestration.errors import Place, Problem, hint
from orchestration.quantities import QuantityError, parse_unit, value_in
from orchestration.scenario.text import parse

VALUES = "values.yaml"


@dataclass(frozen=True)
class Template:
    folder: Path
    about: str
    flown: str
    """The file that is a whole scenario."""
    values: dict[str, dict[str, Any]]
    """By name: what it is, and a default, an example or neither, `instead` of which others do, a unit and a range, or
    the unit `si` of a bare number; the keys of the scenario that it `decides`: what is wrong with them is wrong with
    it."""

    def check(self, given: Mapping[str, Any]) -> None:
        """Raises InputError for a value that is unknown, missing, given twice or out of its range."""
        for name in given:
            if name not in self.values:
                known = hint(name, self.values) or f"; expected one of {', '.join(self.values)}"
                raise InputError(f"--set {name}: {self.folder.name} has no such value{known}")
        lines = []
        for name, entry in self.values.items():
            if "example" in entry and name not in given and not any(_has(given, other) for other in _instead(entry)):
                lines.append(f'  --set "{name}={entry["example"]}"   {entry["what"]}')
        if lines:
            raise InputError("\n".join([f"{self.folder.name}: expected these values, for instance", *lines]))
        for name, entry in self.values.items():
            if name in given and "unit" in entry:
                self.number(name, given[name])
            if name in given and (choices := entry.get("choices")) and given[name] not in choices:
                raise InputError(f"--set {name}: expected one of {', '.join(choices)}, found {flow(given[name])}")

    def number(self, name: str, value: Any) -> float:
        """Returns a value in the unit and the range that are stated for its name. Raises InputError."""
        entry = self.values[name]
        try:
            unit = parse_unit(entry["unit"])
            number = value_in(value, unit)
        except QuantityError as error:
            each = f"; remedy: {entry['each']}" if isinstance(value, list) and "each" in entry else ""
            raise InputError(f"--set {name}: {error}{each}") from None
        least, most = entry["range"]
        if not value_in(least, unit) <= number <= value_in(most, unit):
            found = f"{value} ({number:.10g} {entry['unit']})"
            unit_too = f"; remedy: a unit, as in {most}" if _is_bare(value) else ""
            raise InputError(f"--set {name}: expected {least} to {most}, found {found}{unit_too}")
        return number

    def bare(self, given: Mapping[str, Any]) -> list[str]:
        """Returns the given values that have numbers without a unit, each with the unit that they are taken in."""
        found = []
        for name, value in given.items():
            unit = self.values[name].get("unit", self.values[name].get("si"))
            each = value if isinstance(value, list) else [value]
            if unit and any(_is_bare(one) for one in each):
                found.append(f"{name} {flow(value)} {unit}")
        return found

    def filled(self, name: str, values: Mapping[str, Any], texts: Mapping[str, str]) -> str:
        """Returns the text of a file with its values and texts."""
        text = (self.folder / name).read_text("utf-8")
        text = re.sub(r"@#(\w+)@", lambda match: texts[match[1]], text)
        return re.sub(r"@(\w+)@", lambda match: flow(values[match[1]]), text)

    def told(self, problem: Problem, folder: Path, made_of: Mapping[str, str]) -> Problem:
        """Returns an error of a file that was made in a folder, of which nothing stays, at a place that stays.

        That is `--set NAME` for a line that was left open, and for what a value `decides`; else the line of the
        template. `made_of` has the template of each file.
        """
        place = problem.place
        name = next((file for file in made_of if place and place.source == str(folder / file)), None)
        if place is None or name is None or place.line is None:
            return problem
        path = self.folder / made_of[name]
        left_open = re.search(r"@(\w+)@", path.read_text("utf-8").splitlines()[place.line - 1])
        part = (place.name or "").partition(".")[0].partition("[")[0]
        decides = (name for name, entry in self.values.items() if part in entry.get("decides", ()))
        value = left_open[1] if left_open else next(decides, None)
        option = Place(f"--set {value}", name=place.name) if value else replace(place, source=str(path))
        return replace(problem, place=option)

    def listed(self) -> list[tuple[str, str]]:
        """Returns each value's name with its default and what it is."""
        return [(name, _described(entry)) for name, entry in self.values.items()]


def _is_bare(value: Any) -> bool:
    """Returns whether a value is a number other than zero without a unit."""
    try:
        return bool(float(value))
    except (TypeError, ValueError):
        return False


def _described(entry: Mapping[str, Any]) -> str:
    default = f" [{flow(entry['default'])}]" if "default" in entry else ""
    return f"{entry['what']}{default}"


def _instead(entry: Mapping[str, Any]) -> list[str]:
    return list(entry.get("instead", ()))


def _has(given: Mapping[str, Any], other: str) -> bool:
    """Returns whether `name` or `name=value` is given."""
    name, _, value = other.partition("=")
    return name in given and (not value or given[name] == value)


def flow(value: Any) -> str:
    """Returns a value as YAML on one line; text as it stands where YAML reads it back as the same."""
    if isinstance(value, str):
        plain = re.fullmatch(r"[\w.+-]+( [\w./^*-]+)*", value) and parse(value).data == value
        return value if plain else json.dumps(value, ensure_ascii=False)
    if isinstance(value, list):
        return f"[{', '.join(map(flow, value))}]"
    return json.dumps(value, ensure_ascii=False)


def read(folder: Path) -> Template:
    """Returns the template of a folder."""
    data = parse((folder / VALUES).read_text("utf-8"), str(folder / VALUES)).data
    return Template(folder, data["about"], data["flown"], data["values"])
