"""What a release carries: tested versions, software bills of materials, hashes."""

from __future__ import annotations

import hashlib
import io
import json
import re
import zipfile
from importlib.metadata import distribution
from pathlib import Path

import pytest
from click.testing import CliRunner
from cyclonedx.schema import SchemaVersion
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from fmus.build import ensure
from release import constraints, sbom
from release.__main__ import main

VERSION = "1.2.3"
METADATA = (
    f"Name: attitude-cosim\nVersion: {VERSION}\nRequires-Dist: numpy>=1.26\nRequires-Dist: ziglang; extra == 'build'\n"
)


@pytest.fixture(scope="module")
def fmu() -> bytes:
    return ensure("allocator").read_bytes()


@pytest.fixture
def wheel(tmp_path: Path, fmu: bytes) -> Path:
    """A wheel as far as a bill looks at it."""
    path = tmp_path / f"attitude_cosim-{VERSION}-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(f"attitude_cosim-{VERSION}.dist-info/METADATA", METADATA)
        archive.writestr("attitude_cosim/fmus/ready/native/allocator.fmu", fmu)
        archive.writestr("attitude_cosim/fmus/ready/loop/linux64.so", b"a library")
    return path


def sha256(bill: dict, name: str) -> str:
    (found,) = (c for c in (bill["metadata"]["component"], *bill["components"]) if c["name"] == name)
    (digest,) = found["hashes"]
    assert digest["alg"] == "SHA-256"
    return digest["content"]


def test_every_requirement_of_this_platform_is_pinned_within_its_bounds_and_without_an_address() -> None:
    pinned = constraints.pinned()
    for line in constraints.required():
        requirement = Requirement(line)
        if requirement.name != "attitude-cosim" and (requirement.marker is None or requirement.marker.evaluate()):
            assert requirement.specifier.contains(pinned.get(canonicalize_name(requirement.name), "0")), (
                f"{line}: python -m release constraints"
            )
    assert not any(mark in constraints.FILE.read_text() for mark in ("//", "@", "--"))
    assert set(constraints.IN_BYTES) <= set(pinned)


def test_what_builds_a_release_is_pinned_as_elsewhere_and_each_file_of_it_has_a_hash() -> None:
    entries = constraints.BUILDING.read_text("utf-8").replace("\\\n", " ").splitlines()
    hashed = {}
    for entry in filter(lambda line: not line.startswith("#"), entries):
        requirement, *hashes = entry.split(" --hash=")
        assert hashes, entry
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64}", text.strip()) for text in hashes), entry
        name, _, version = requirement.partition(";")[0].strip().partition("==")
        hashed[canonicalize_name(name)] = version
    assert hashed == {name: constraints.pinned()[name] for name in hashed}, "python -m release building"
    needed = {canonicalize_name(Requirement(line).name) for line in constraints.building()}
    assert set(constraints.IN_BYTES) <= needed <= set(hashed), "python -m release building"
    for name in needed:  # with what these require in turn
        for line in distribution(name).requires or ():
            own = Requirement(line)
            if own.marker is None or own.marker.evaluate({"extra": ""}):
                assert canonicalize_name(own.name) in hashed, f"{name} requires {line}"


def test_another_version_of_what_has_a_say_in_the_bytes_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wanted = constraints.text()
    monkeypatch.setattr(constraints, "FILE", tmp_path / "constraints.txt")
    constraints.FILE.write_text(wanted)
    assert CliRunner().invoke(main, ["check"]).exit_code == 0
    here = constraints.installed()["ziglang"]
    constraints.FILE.write_text(wanted.replace(f"ziglang=={here}", "ziglang==0.1.0"))
    refused = CliRunner().invoke(main, ["check"])
    assert refused.exit_code == 1
    assert f"ziglang: expected 0.1.0, as in constraints.txt, found {here}" in refused.output
    assert CliRunner().invoke(main, ["constraints"]).exit_code == 0
    assert constraints.pinned()["ziglang"] == here


def test_the_bill_of_an_fmu_has_the_hash_of_each_library_and_the_compiler(fmu: bytes) -> None:
    from cyclonedx.validation.json import JsonStrictValidator  # takes seconds, in each process that collects the tests

    text = sbom.of_fmu("native/allocator.fmu", fmu, VERSION)
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(text) is None
    bill = json.loads(text)
    assert sha256(bill, "allocator (native FMU)") == hashlib.sha256(fmu).hexdigest()
    with zipfile.ZipFile(io.BytesIO(fmu)) as archive:
        libraries = [name for name in archive.namelist() if name.startswith("binaries/")]
        assert len(libraries) == 4
        for name in libraries:
            assert sha256(bill, name) == hashlib.sha256(archive.read(name)).hexdigest()
    (compiler,) = (c for c in bill["components"] if c["name"] == "ziglang")
    assert compiler["purl"] == f"pkg:pypi/ziglang@{constraints.pinned()['ziglang']}"
    assert compiler["scope"] == "excluded"


def test_the_bill_of_a_block_names_the_packages_of_its_tables_and_what_its_host_needs() -> None:
    data = ensure("plant", "python").read_bytes()
    names = {c["name"] for c in json.loads(sbom.of_fmu("python/plant.fmu", data, VERSION))["components"]}
    assert {"numpy", "pythonfmu", "ppigrf", "pygeomag"} <= names


def test_the_files_of_a_release_are_the_bills_and_the_hashes(wheel: Path, fmu: bytes) -> None:
    result = CliRunner().invoke(main, ["files", str(wheel.parent)])
    assert result.exit_code == 0, result.output
    bill = json.loads(wheel.with_suffix(".cdx.json").read_text())
    assert sha256(bill, "attitude-cosim") == hashlib.sha256(wheel.read_bytes()).hexdigest()
    assert sha256(bill, "attitude_cosim/fmus/ready/loop/linux64.so") == hashlib.sha256(b"a library").hexdigest()
    packages = {c["name"]: c["version"] for c in bill["components"] if c["type"] == "library"}
    assert packages == {"numpy": constraints.pinned()["numpy"]}, "an extra is not required"
    assert f"| `native/allocator.fmu` | `{hashlib.sha256(fmu).hexdigest()}` |" in result.output
    assert (wheel.parent / "hashes.md").read_text() == result.output
    assert (wheel.parent / "native-allocator.fmu.cdx.json").exists()


def test_the_same_content_gets_the_same_serial_number_and_other_content_another(fmu: bytes) -> None:
    numbers = [
        json.loads(sbom.of_fmu("native/allocator.fmu", data, VERSION))["serialNumber"]
        for data in (fmu, fmu, _longer(fmu))
    ]
    assert numbers[0] == numbers[1] != numbers[2]


def _longer(fmu: bytes) -> bytes:
    data = io.BytesIO(fmu)
    with zipfile.ZipFile(data, "a") as archive:
        archive.writestr("resources/more", b"")
    return data.getvalue()


def test_the_bill_of_a_wheel_has_its_libraries_and_the_version_of_its_script_and_no_other_file(wheel: Path) -> None:
    script = b"/*! https://github.com/leeoniya/uPlot (v1.6.32) */"
    with zipfile.ZipFile(wheel, "a") as archive:
        for name in ("fmus/ready/loop/step.so", "fmus/ready/notes.txt", "other/extra.so"):
            archive.writestr(f"attitude_cosim/{name}", name)
        archive.writestr("attitude_cosim/pages/uPlot.iife.min.js", script)
    components = {c["name"]: c for c in json.loads(sbom.of_wheel(wheel.read_bytes()))["components"]}
    assert "attitude_cosim/fmus/ready/loop/step.so" in components
    assert not {name for name in components if "notes" in name or "extra" in name}
    assert components["uplot"]["version"] == "1.6.32"
    assert components["uplot"]["hashes"][0]["content"] == hashlib.sha256(script).hexdigest()
