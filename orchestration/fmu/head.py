"""What is read of a modelDescription.xml before FMPy reads it, by lxml: its version, its size and what FMPy leaves
out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import InputError, Place, naming
from . import zipped
from .description import VARIABLES_MAX
from .zipped import shown

ANNOTATION = "attitude-cosim"
"""Under this name an FMU says which of its inputs are optional and which quantities its parameters state, for which
FMI 2.0 has no words."""
XML_MAX = 64_000_000
"""Bytes of a modelDescription.xml."""


@dataclass(frozen=True)
class Head:
    """Facts of a modelDescription.xml before FMPy reads it."""

    version: str | None
    """The version of FMI that it declares."""
    variables: int
    optional: frozenset[str]
    """The inputs of which an annotation of ours says that they may stay unconnected."""
    quantities: Mapping[str, str]
    """Of parameters, the quantities that an annotation of ours says they state."""
    unsigned: Mapping[str, tuple[str | None, str | None]] = field(default_factory=dict)
    """The limits of unsigned variables (FMI 3.0), which FMPy leaves out."""
    slopes: bool = False
    """Whether it gives directional derivatives in co-simulation."""


def read_head(path: Path) -> Head:
    """Returns what an FMU's modelDescription.xml says of itself. Raises InputError where it holds none, too much, or no
    XML.
    """
    with zipped.reading(path, "FMU") as archive:
        if "modelDescription.xml" not in archive.namelist():
            raise InputError(f"{shown(path)} is no FMU: it holds no modelDescription.xml")
        size = archive.getinfo("modelDescription.xml").file_size
        if size > XML_MAX:
            raise InputError(
                f"{shown(path)}: modelDescription.xml holds {size / 1e6:.3g} MB; expected at most "
                f"{XML_MAX / 1e6:.3g} MB"
            )
        xml = archive.read("modelDescription.xml")
    with naming(Place(str(shown(path)))):
        root = zipped.xml_root(xml, "modelDescription.xml")
    variables = root.findall("ModelVariables/*")
    if len(variables) > VARIABLES_MAX:
        raise InputError(
            f"{shown(path)}: modelDescription.xml declares {len(variables)} variables; expected at most {VARIABLES_MAX}"
        )
    if root.get("fmiVersion") == "2.0":
        _check_indices(path, root, len(variables))
    marked: set[str] = set()
    stated: dict[str, str] = {}
    tools = (f"Tool[@name='{ANNOTATION}']", f"Annotation[@type='{ANNOTATION}']")  # of FMI 2.0, of FMI 3.0
    for entry in (e for tool in tools for e in root.iterfind(f"ModelVariables/*/Annotations/{tool}/*")):
        name = entry.getparent().getparent().getparent().get("name", "")
        if entry.tag == "Optional":
            marked.add(name)
        elif entry.tag == "Quantity":
            stated[name] = entry.get("name", "")
    unsigned = {v.get("name", ""): (v.get("min"), v.get("max")) for v in variables if str(v.tag).startswith("UInt")}
    version = root.get("fmiVersion")
    flag = "providesDirectionalDerivative" + ("" if version == "2.0" else "s")
    slopes = any(entry.get(flag) in ("true", "1") for entry in root.iterfind("CoSimulation"))
    return Head(version, len(variables), frozenset(marked), stated, unsigned, slopes)


def _check_indices(path: Path, root: Any, count: int) -> None:
    """Refuses a ModelStructure that names a variable that there is not; FMPy would fail, or take the last one for 0."""
    for unknown in root.iterfind("ModelStructure/*/Unknown"):
        for name in ("index", "dependencies"):
            for text in unknown.get(name, "").split():
                if text.isdecimal() and not 1 <= int(text[:20]) <= count:
                    place = f"modelDescription.xml:{unknown.sourceline}: {unknown.getparent().tag}/Unknown"
                    wanted = f"expected 1 to {count}, as there are {count} variables" if count else "there are none"
                    raise InputError(f"{shown(path)}: {place}: {name}: there is no variable {text[:20]}; {wanted}")
