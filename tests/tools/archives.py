"""What tests of SSP archives share: commands that are expected to end with a status, and the schemas of SSP 1.0."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
from lxml import etree

from tests.commands import orchestrate

SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"


def printed(*arguments: object, status: int = 0) -> str:
    """What a command prints that ends with this status."""
    result = orchestrate(*arguments)
    assert result.exit_code == status, result.output
    return result.output


def validate(path: Path) -> etree._Element:
    """Every file of an archive against the schemas of SSP 1.0; returns the structure."""
    with zipfile.ZipFile(path) as archive:
        found = {}
        for name in archive.namelist():
            kind = {".ssd": "Description", ".ssv": "ParameterValues"}.get(Path(name).suffix)
            if kind:
                found[name] = etree.fromstring(archive.read(name))
                etree.XMLSchema(etree.parse(SCHEMAS / f"SystemStructure{kind}.xsd")).assertValid(found[name])
    return found["SystemStructure.ssd"]
