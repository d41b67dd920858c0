"""Opening an FMU: what can be checked of it before any of its code runs, and its unpacking.

FMPy reads and validates modelDescription.xml.
"""

from __future__ import annotations

import hashlib
import re
import stat
import zipfile
import zlib
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.parsers import expat

import fmpy
from fmpy.model_description import ValidationError, read_model_description

from ..errors import InputError, hint
from .description import describe
from .model import Model

ANNOTATION = "attitude-cosim"
"""Under this name an FMU says which of its inputs are optional, for which FMI 2.0 has no word."""
_DAMAGED = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError)
"""What zipfile raises for a damaged archive, or one that it cannot read."""
_FILES_MAX, _BYTES_MAX, _XML_MAX = 50_000, 8 * 10**9, 64 * 10**6
"""Of an FMU that is honest: files, what they hold unpacked, and what its modelDescription.xml holds."""


@dataclass(frozen=True)
class Fmu:
    """An FMU that can run here."""

    path: Path
    sha256: str
    description: Any
    """FMPy's ModelDescription."""
    model: Model

    @property
    def library(self) -> str:
        return _library(self.description.coSimulation.modelIdentifier)

    def extract(self, folder: Path) -> None:
        """Unpacks it into an empty folder."""
        try:
            fmpy.extract(self.path, folder)
        except _DAMAGED as error:
            raise InputError(f"{shown(self.path)} is a damaged zip archive: {error}") from None
        except OSError as error:
            raise InputError(f"{shown(self.path)} cannot be unpacked: {error.strerror}") from None


def _library(identifier: str) -> str:
    return f"binaries/{fmpy.platform}/{identifier}{fmpy.sharedLibraryExtension}"


def open_fmu(path: Path) -> Fmu:
    """Reads and checks an FMU; its code does not run yet. Raises InputError, without the scenario's line."""
    if not path.exists():
        near = hint(path.name, (p.name for p in path.parent.glob("*.fmu"))) if path.parent.is_dir() else ""
        raise InputError(f"there is no FMU {shown(path)}{near}")
    if path.is_dir():
        raise InputError(f"{shown(path)} is a folder; expected an .fmu file")
    names = entries(path)
    description, optional = _description(path)
    identifier = description.coSimulation.modelIdentifier
    if _library(identifier) not in names:
        offered = sorted({name.split("/")[1] for name in names if re.match(r"binaries/[^/]+/[^/]+", name)})
        raise InputError(
            f"{shown(path)} has no binary for this platform: expected {_library(identifier)}, found binaries for {', '.join(offered) or 'none'}"
        )
    return Fmu(path, hashlib.sha256(path.read_bytes()).hexdigest(), description, describe(description, optional))


def shown(path: Path) -> Path:
    """The path as the user knows it: relative to the current folder where it lies in it."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


def entries(path: Path) -> set[str]:
    """The names in the archive. Raises InputError where it is none, or would unpack to a place outside its folder."""
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
    except zipfile.BadZipFile:
        with path.open("rb") as file:
            truncated = file.read(2) == b"PK"
        what = "is a damaged or truncated zip archive" if truncated else "is no FMU: an FMU is a zip archive"
        raise InputError(f"{shown(path)} {what}") from None
    except OSError as error:
        raise InputError(f"{shown(path)} cannot be read: {error.strerror}") from None
    names = [entry.filename for entry in entries]
    if outside := next((n for n in names if n.startswith("/") or "\\" in n or ":" in n or ".." in n.split("/")), None):
        raise InputError(f"{shown(path)} would unpack to a place outside its folder: {outside}")
    if link := next((entry.filename for entry in entries if stat.S_ISLNK(entry.external_attr >> 16)), None):
        raise InputError(f"{shown(path)} holds a symbolic link, {link}; expected files only")
    size = sum(entry.file_size for entry in entries)
    if len(entries) > _FILES_MAX or size > _BYTES_MAX:
        raise InputError(
            f"{shown(path)} would unpack to {len(entries)} files of {size / 1e9:.3g} GB; expected at most {_FILES_MAX} files of {_BYTES_MAX / 1e9:.3g} GB"
        )
    if "modelDescription.xml" not in names:
        raise InputError(f"{shown(path)} is no FMU: it holds no modelDescription.xml")
    return set(names)


def refuse_entities(path: Path, xml: bytes) -> None:
    """Entities can grow without bound and can read files; FMI has no use for the DOCTYPE that defines them."""

    def doctype(*_: Any) -> None:
        message = "modelDescription.xml has a DOCTYPE, which an FMU does not need and which can do harm"
        raise InputError(f"{shown(path)}: {message}")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = doctype
    with suppress(expat.ExpatError):  # what reads it next reports it
        parser.Parse(xml, True)


def optional_inputs(xml: bytes) -> frozenset[str]:
    """The inputs of which a modelDescription.xml says, in an annotation of ours, that they may stay unconnected."""
    if ANNOTATION.encode() not in xml:
        return frozenset()
    variables = ElementTree.fromstring(xml).iterfind("ModelVariables/ScalarVariable")
    optional = f"Annotations/Tool[@name='{ANNOTATION}']/Optional"
    return frozenset(entry.get("name", "") for entry in variables if entry.find(optional) is not None)


def fmi_version(xml: bytes) -> str | None:
    """The version that modelDescription.xml declares, found without parsing it; None where it declares none."""
    match = re.search(rb"<fmiModelDescription\b[^>]*?\bfmiVersion\s*=\s*[\"']([^\"']*)", xml)
    return match[1].decode("ascii", "replace") if match else None


def _description(path: Path) -> tuple[Any, frozenset[str]]:
    """What FMPy reads of it, and its optional inputs."""
    try:
        with zipfile.ZipFile(path) as archive:
            size = archive.getinfo("modelDescription.xml").file_size
            if size > _XML_MAX:
                raise InputError(
                    f"{shown(path)}: modelDescription.xml holds {size / 1e6:.3g} MB; expected at most {_XML_MAX / 1e6:.3g} MB"
                )
            head = archive.read("modelDescription.xml")
    except _DAMAGED as error:
        raise InputError(f"{shown(path)} is a damaged zip archive: {error}") from None
    # The version decides first: the schema's complaints about another version would only confuse.
    if (version := fmi_version(head)) not in ("2.0", None):
        raise InputError(f"{shown(path)} is an FMU of FMI {version}; expected FMI 2.0 for co-simulation")
    refuse_entities(path, head)
    try:
        description = read_model_description(str(path))
    except ValidationError as error:
        some = [f"  {problem}" for problem in error.problems[:5]]
        more = [f"  and {len(error.problems) - 5} more"] if len(error.problems) > 5 else []
        raise InputError("\n".join([f"{shown(path)}: modelDescription.xml is not valid:", *some, *more])) from None
    except Exception as error:  # FMPy and lxml raise what they please
        raise InputError(
            f"{shown(path)}: modelDescription.xml cannot be read: {' '.join(str(error).split())}"
        ) from None
    if description.coSimulation is None:
        raise InputError(f"{shown(path)} is for model exchange only; expected an FMU for co-simulation")
    return description, optional_inputs(head)
