"""Software bills of materials, CycloneDX 1.6: of a wheel and of each FMU in it.
Tests: tests/release/test_release.py."""

from __future__ import annotations

import hashlib
import io
import json
import re
import zipfile
from email.parser import BytesParser
from uuid import NAMESPACE_URL, uuid5

from cyclonedx.model import HashAlgorithm, HashType, Property
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentScope, ComponentType
from cyclonedx.model.license import LicenseExpression
from cyclonedx.output.json import JsonV1Dot6
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from packageurl import PackageURL
from packaging.requirements import Requirement

from fmus.block import Block
from fmus.build import BLOCKS
from fmus.fingerprint import data_packages

from .constraints import pinned

LICENCE = "BSD-3-Clause"


def of_fmu(name: str, data: bytes, version: str) -> str:
    """The bill of an FMU: its libraries by their hashes, what they were made with, and what it needs of its host.

    `name` is `native/plant.fmu`. Versions of packages are those of constraints.txt.
    """
    flavour, _, file = name.partition("/")
    block = file.removesuffix(".fmu")
    components = []
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for entry in sorted(archive.namelist()):
            if entry.startswith("binaries/"):
                components.append(_file(entry, archive.read(entry)))
            if entry == "resources/requirements.txt":
                components += [_package(Requirement(line).name) for line in archive.read(entry).decode().split()]
    made = ["ziglang", *(["pythonfmu"] if flavour == "python" else [])]
    if block in BLOCKS:
        made += data_packages(Block.named(block).folder)
    components += [_package(package, ComponentScope.EXCLUDED) for package in dict.fromkeys(made)]
    return _bill(f"{block} ({flavour} FMU)", version, data, components)


def of_wheel(data: bytes) -> str:
    """The bill of a wheel: what it requires, in the versions of constraints.txt, and what it brings ready-made."""
    components = []
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = sorted(archive.namelist())
        (metadata,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        about = BytesParser().parsebytes(archive.read(metadata))
        for line in about.get_all("Requires-Dist", []):
            requirement = Requirement(line)
            if "extra" not in str(requirement.marker or ""):
                components.append(_package(requirement.name))
        for name in names:
            if "/fmus/ready/" in name and name.endswith((".fmu", ".so", ".dll", ".dylib")):
                components.append(_file(name, archive.read(name)))
            if name.endswith("uPlot.iife.min.js"):
                script = archive.read(name)
                found = re.search(rb"uPlot \(v([\d.]+)\)", script)
                version = found[1].decode() if found else "unknown"
                url = PackageURL("npm", None, "uplot", version)
                components.append(_component("uplot", version, "MIT", url, _hashes(script)))
    return _bill(str(about["Name"]), str(about["Version"]), data, components)


def fmus_in(wheel: bytes) -> dict[str, bytes]:
    """The FMUs of a wheel, by `native/plant.fmu`."""
    with zipfile.ZipFile(io.BytesIO(wheel)) as archive:
        names = [name for name in archive.namelist() if "/fmus/ready/" in name and name.endswith(".fmu")]
        return {name.partition("/fmus/ready/")[2]: archive.read(name) for name in sorted(names)}


def _bill(name: str, version: str, data: bytes, components: list[Component]) -> str:
    """The bill as JSON. Its serial number comes from the content, so that the same files give the same number."""
    bom = Bom(serial_number=uuid5(NAMESPACE_URL, hashlib.sha256(data).hexdigest()))
    bom.metadata.component = _component(name, version, LICENCE, None, _hashes(data), ComponentType.LIBRARY)
    bom.components.update(components)
    for component in components:
        bom.register_dependency(component)
    bom.register_dependency(bom.metadata.component, components)
    text = JsonV1Dot6(bom).output_as_string(indent=2)
    error = JsonStrictValidator(SchemaVersion.V1_6).validate_str(text)
    if error is not None:
        raise RuntimeError(f"the bill of {name} is not valid: {error}")
    return json.dumps(json.loads(text), indent=2, sort_keys=True) + "\n"


def _component(
    name: str,
    version: str | None,
    licence: str | None,
    url: PackageURL | None,
    hashes: list[HashType],
    kind: ComponentType = ComponentType.LIBRARY,
    scope: ComponentScope | None = None,
) -> Component:
    return Component(
        name=name,
        version=version,
        type=kind,
        purl=url,
        scope=scope,
        bom_ref=str(url or name),
        hashes=hashes,
        licenses=[LicenseExpression(licence)] if licence else None,
        properties=[Property(name="made with", value="yes")] if scope == ComponentScope.EXCLUDED else None,
    )


def _file(name: str, data: bytes) -> Component:
    return _component(name, None, None, None, _hashes(data), ComponentType.FILE)


def _package(name: str, scope: ComponentScope | None = None) -> Component:
    version = pinned().get(name.lower().replace("_", "-"))
    return _component(name.lower(), version, None, PackageURL("pypi", None, name.lower(), version), [], scope=scope)


def _hashes(data: bytes) -> list[HashType]:
    return [HashType(alg=HashAlgorithm.SHA_256, content=hashlib.sha256(data).hexdigest())]
