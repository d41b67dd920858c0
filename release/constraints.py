"""The versions of dependencies with which the project was tested, as a constraints file of pip, without addresses.
Tests: tests/release/test_release.py."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
FILE = ROOT / "constraints.txt"
BUILDING = ROOT / "release" / "building.txt"
IN_BYTES = ("pygeomag", "ppigrf", "pythonfmu", "ziglang")
"""The packages that determine the bytes of the FMUs: the compiler, PythonFMU's libraries, the tables of the field."""
_HEAD = """\
# Versions of dependencies with which the tests passed; made by `python -m release constraints`. To install these:
# PIP_CONSTRAINT=constraints.txt make test, or pip install -c constraints.txt ...
"""
_BUILDING_HEAD = """\
# What builds the wheel of a release, with hashes; made by `python -m release building`. To install it:
# pip install --require-hashes --only-binary :all: -r release/building.txt
"""


def required() -> list[str]:
    """The lines of all requirements in pyproject.toml, with those of its extras and of the build."""
    data = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    project = data["project"]
    extras = (line for lines in project["optional-dependencies"].values() for line in lines)
    return [*project["dependencies"], *extras, *data["build-system"]["requires"]]


def installed() -> dict[str, str]:
    """Names and versions of all packages that the requirements bring into this environment, with what these require."""
    versions: dict[str, str] = {}
    pending = [(Requirement(line), "") for line in required()]
    seen = set()
    while pending:
        requirement, extra = pending.pop()
        name = canonicalize_name(requirement.name)
        wanted = frozenset(requirement.extras)
        if (name, wanted) in seen or (requirement.marker and not requirement.marker.evaluate({"extra": extra})):
            continue
        seen.add((name, wanted))
        try:
            found = distribution(name)
        except PackageNotFoundError:
            continue  # of another platform
        if name != "attitude-cosim":
            versions[name] = found.version
            for line in found.requires or ():
                pending += [(Requirement(line), one) for one in ("", *wanted)]
    return dict(sorted(versions.items()))


def text() -> str:
    return _HEAD + "".join(f"{name}=={version}\n" for name, version in installed().items())


def pinned() -> dict[str, str]:
    """Names and versions in constraints.txt."""
    lines = (line for line in FILE.read_text("utf-8").splitlines() if line and not line.startswith("#"))
    return {name: version for name, _, version in (line.partition("==") for line in lines)}


def building() -> list[str]:
    """The requirements of a build of the wheel: the front end, the backend, and what compiles the FMUs."""
    sys.path.insert(0, str(ROOT))
    from hatch_build import get_requires_for_build_wheel  # here, since it stands beside the packages  # noqa: PLC0415

    declared = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["build-system"]["requires"]
    return ["build", *declared, *get_requires_for_build_wheel()]


def hashed() -> str:
    """Returns what a build of the wheel installs, in the versions of constraints.txt, with the SHA-256 of all their
    files.

    Asks the package index, by uv. Raises CalledProcessError.
    """
    command = [
        sys.executable,
        "-m",
        "uv",
        "pip",
        "compile",
        "--quiet",
        "--generate-hashes",
        "--universal",
        "--no-annotate",
        "--no-header",
    ]
    command += ["--python-version", "3.11", "--constraint", str(FILE), "-"]
    made = subprocess.run(command, input="\n".join(building()), capture_output=True, text=True, check=True)
    return _BUILDING_HEAD + made.stdout


def differing() -> list[str]:
    """Returns a sentence for each package that determines the FMUs' bytes and is not installed in the pinned
    version."""
    here, wanted = installed(), pinned()
    return [
        f"{name}: expected {wanted.get(name)}, as in constraints.txt, found {here.get(name)}"
        for name in IN_BYTES
        if here.get(name) != wanted.get(name)
    ]
