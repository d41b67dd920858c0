"""Files of scenarios with values left open: a folder of templates, and the files that follow from the values.

A folder has values.yaml, which says what is left open, and beside it files in which @NAME@ stands for a value.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fmus import places

from ..errors import InputError, Place, Problem, hint
from .text import parse

VALUES = "values.yaml"


@dataclass(frozen=True)
class Template:
    folder: Path
    about: str
    flown: str
    """The file that is a whole scenario."""
    values: dict[str, dict[str, Any]]
    """By name: what it is, and a default, an example, or an expression of others with its unit."""

    def filled(self, given: Mapping[str, Any], computed: Mapping[str, Any]) -> dict[str, str]:
        """The texts of the files by their names, each @NAME@ as YAML.

        Raises InputError for a value that is unknown or missing.
        """
        for name in given:
            if name not in self.values:
                known = hint(name, self.values) or f"; expected one of {', '.join(self.values)}"
                raise InputError(f"--set {name}: {self.folder.name} has no such value{known}")
        instead = {name: self._instead_of(name, given) for name in self.values if "example" in self.values[name]}
        for name, other in instead.items():
            if other and name in given:
                raise InputError(
                    f"--set {name}, --set {other}: expected one of them, since {other} follows from {name}"
                )
        if missing := [name for name, other in instead.items() if name not in given and not other]:
            lines = [
                f'  --set "{name}={self.values[name]["example"]}"   {self.values[name]["what"]}' for name in missing
            ]
            raise InputError("\n".join([f"{self.folder.name}: expected these values, for instance", *lines]))
        chosen = {name: entry.get("default") for name, entry in self.values.items()} | {**computed, **given}
        return {
            path.name: re.sub(r"@(\w+)@", lambda match: _flow(chosen[match[1]]), path.read_text("utf-8"))
            for path in sorted(self.folder.glob("*.yaml"))
            if path.name != VALUES
        }

    def _instead_of(self, name: str, given: Mapping[str, Any]) -> str | None:
        """The value that is given and would follow from this one."""
        follows = (other for other in given if re.search(rf"\b{name}\b", self.values[other].get("expression", "")))
        return next(follows, None)

    def told(self, problem: Problem, folder: Path) -> Problem:
        """Returns an error of a file that was made in a folder, of which nothing stays, at a place that stays.

        That is `--set NAME` for a line that was left open, else the line of the template.
        """
        place = problem.place
        path = next((p for p in self.folder.glob("*.yaml") if place and place.source == str(folder / p.name)), None)
        if place is None or path is None or place.line is None:
            return problem
        left_open = re.search(r"@(\w+)@", path.read_text("utf-8").splitlines()[place.line - 1])
        option = Place(f"--set {left_open[1]}", name=place.name) if left_open else replace(place, source=str(path))
        return replace(problem, place=option)


def _flow(value: Any) -> str:
    """On one line; text as it stands where YAML reads it back as the same."""
    if isinstance(value, str):
        plain = re.fullmatch(r"[\w.+-]+( [\w./^*-]+)?", value) and parse(value).data == value
        return value if plain else json.dumps(value)
    return json.dumps(value)


def names() -> list[str]:
    """Of the project's templates."""
    return sorted(path.parent.name for path in _root().glob(f"*/{VALUES}"))


def read(name: str) -> Template:
    """One of `names`."""
    folder = _root() / name
    data = parse((folder / VALUES).read_text("utf-8"), str(folder / VALUES)).data
    return Template(folder, data["about"], data["flown"], data["values"])


def _root() -> Path:
    return places.shared("scenarios") / "templates"
