"""An FMU inside a container: what its modelDescription.xml says, and where it stands."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from functools import cached_property
from xml.etree import ElementTree as ET

from ..system import Component

KINDS = {"Real": 0, "Integer": 1, "Enumeration": 1, "Boolean": 2, "String": 3}
"""FMI's types by the functions that exchange them, numbered as in container.h."""


@dataclass(frozen=True)
class Inside:
    """A component with its place in the order of the steps, from 0."""

    place: int
    component: Component
    root: ET.Element
    """Of its modelDescription.xml."""
    names: frozenset[str]
    """Of the entries of its archive."""

    @classmethod
    def of(cls, place: int, component: Component) -> Inside:
        with zipfile.ZipFile(component.fmu.path) as archive:
            root = ET.fromstring(archive.read("modelDescription.xml"))
            return cls(place, component, root, frozenset(archive.namelist()))

    @property
    def name(self) -> str:
        return self.component.name

    @property
    def folder(self) -> str:
        """In the container's resources: names of blocks may be those of others but for capitals."""
        return f"{self.place}_{self.name}" if self.name.isascii() else str(self.place)

    @cached_property
    def co_simulation(self) -> ET.Element:
        found = self.root.find("CoSimulation")
        assert found is not None, "it has been opened as such"
        return found

    @property
    def identifier(self) -> str:
        """The name of its library."""
        return self.co_simulation.get("modelIdentifier", "")

    def says(self, flag: str) -> bool:
        """Returns whether it declares a capability."""
        return self.co_simulation.get(flag, "false").strip() in ("true", "1")

    @cached_property
    def scalars(self) -> dict[str, ET.Element]:
        """Its variables by FMI's names, in the order of their indices."""
        return {entry.get("name", ""): entry for entry in self.root.iterfind("ModelVariables/ScalarVariable")}

    def type(self, name: str) -> ET.Element:
        """The element of a variable that is named after its type."""
        return next(entry for entry in self.scalars[name] if entry.tag in KINDS)

    def end(self, name: str) -> tuple[int, int, int]:
        """The kind of a variable, the place of this FMU and the value reference there."""
        return KINDS[self.type(name).tag], self.place, int(self.scalars[name].get("valueReference", ""))

    def feeding(self, output: str) -> set[str]:
        """The variables on which an output depends directly; all where the FMU does not say."""
        names = list(self.scalars)
        for unknown in self.root.iterfind("ModelStructure/Outputs/Unknown"):
            if names[int(unknown.get("index", "1")) - 1] == output and unknown.get("dependencies") is not None:
                return {names[int(index) - 1] for index in unknown.get("dependencies", "").split()}
        return set(names)
