"""A block as a folder that a flight project can commit: C, build files, reference vectors with a runner, bill of
materials, reports and hashes.

write(load("controller"), Path("controller"), Path("flight/controller")) Tests: tests/fmus/kit/test_flight.py.
"""

from __future__ import annotations

import hashlib
import json
import tempfile
from pathlib import Path

from .. import places
from ..contents.references import kept_in
from ..fingerprint import data_packages
from ..interface import Interface
from ..native import lay_out
from ..native.carried import collected
from ..native.toolchain import FREESTANDING, run_program
from ..versions import version_of
from . import InUse, put
from .fill import filled
from .vectors import header

SUMS = "SHA256SUMS"
NOT_PROVED = "The reports are not of this C"
REPORTS = ("docs/evidence/proofs.md", "evidence/proofs/arguments.yaml", "evidence/proofs/deviations.yaml")
PROVED = "docs/evidence/proved.json"
"""The digest of the C of each block, when all of it was proved."""
_LICENCE = [{"license": {"id": "BSD-3-Clause"}}]


def write(interface: Interface, block: Path, folder: Path) -> list[Path]:
    """Writes the folder for the block whose package stands in `block`, and returns its files.

    Raises InUse where it would overwrite what is not its own, CompilerError, InterfaceError.
    """
    old = _refuse_edited(folder)
    files = sources(interface, block)
    c_files = [name for name in files if name.startswith("src/") and name.endswith(".c")]
    listed = {
        "version": version_of("attitude-cosim") or "0",
        "code": interface.code,
        "c_files": " ".join(c_files),
    }
    for name, lines in (
        ("CMakeLists.txt", "\n".join(f"  {name}" for name in c_files)),
        ("meson.build", "\n".join(f"  '{name}'," for name in c_files) + "\n"),
    ):
        template = f"{name.partition('.')[0]}.flight.template"
        files[name] = filled(template, interface, **listed, sources=lines).encode()
    files["meson_options.txt"] = b"option('portable_math', type: 'boolean', value: true)\n"
    files |= {f"vectors/{path.name}": path.read_bytes() for path in kept_in(interface, block)}
    files["vectors/runner.c"] = Path(__file__).with_name("flight_runner.c").read_bytes()
    files["vectors/vectors.h"] = header(interface, block, 0).encode()
    files["vectors/vectors.h"] = header(interface, block, _bits(files)).encode()
    files["LICENSE"] = places.shared("LICENSE").read_bytes()
    reports = [report for name in REPORTS if (report := places.shared(name)).exists()]
    files |= {f"reports/{report.name}": report.read_bytes() for report in reports}
    files["reports/proved.txt"] = _proved(interface, digest_of(files)).encode()
    files["bom.cdx.json"] = _bill(interface, block, listed["version"], files)
    sums = "".join(f"{hashlib.sha256(data).hexdigest()}  {name}\n" for name, data in sorted(files.items()))
    digest = hashlib.sha256(sums.encode()).hexdigest()
    files["README.md"] = filled("README.flight.md", interface, **listed, digest=digest).encode()
    files[SUMS] = sums.encode()
    for name in old - files.keys():
        (folder / name).unlink(missing_ok=True)
    return [put(folder / name, data) for name, data in files.items()]


def digest_of(files: dict[str, bytes]) -> str:
    """Returns the digest of the C among these files, by their names."""
    lines = (f"{hashlib.sha256(data).hexdigest()}  {name}\n" for name, data in sorted(files.items()))
    c = (line for line in lines if line.endswith((".c\n", ".h\n")) and "  vectors/" not in line)
    return hashlib.sha256("".join(c).encode()).hexdigest()


def _proved(interface: Interface, digest: str) -> str:
    """Returns whether the reports speak of C with this digest."""
    known: dict[str, str] = json.loads(path.read_text("utf-8")) if (path := places.shared(PROVED)).exists() else {}
    proved = known.get(interface.name)
    own = f"SHA-256 of the list of the C in src/ and portable/: {digest}\n"
    if proved == digest:
        return f"The reports are of this C.\n{own}"
    if proved is None:
        return f"{NOT_PROVED}: the proofs have no block {interface.name}.\n{own}"
    return f"{NOT_PROVED}: the C that was proved is another.\n{own}Of the C that was proved: {proved}\n"


def sources(interface: Interface, block: Path) -> dict[str, bytes]:
    """The block's C in src/, without what is the FMI shell's, and the elementary functions in portable/."""
    with tempfile.TemporaryDirectory() as generated:
        _, (_, *folders) = lay_out(interface, block, "", Path(generated))
        files = {f"src/{name}": data for name, data in collected(folders, ("block.h", "table.c")).items()}
    names = "math.h", "elementary.c"  # memcpy and its like are the platform's
    return files | {f"portable/{name}": (FREESTANDING / name).read_bytes() for name in names}


def _refuse_edited(folder: Path) -> set[str]:
    """Returns the names that an earlier `write` gave; raises InUse where what is there is not as it was written."""
    sums = folder / SUMS
    if not sums.exists():
        if folder.is_file() or (folder.is_dir() and any(folder.iterdir())):
            raise InUse(f"{folder}: expected an empty folder, or one that this command has written; {_REMEDY}")
        return set()
    listed = dict(line.split("  ", 1)[::-1] for line in sums.read_text("utf-8").splitlines())
    for name, digest in listed.items():
        path = folder / name
        if ".." in Path(name).parts or Path(name).is_absolute():
            raise InUse(f"{sums}: {name} leads out of the folder; {_REMEDY}")
        if path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() != digest:
            raise InUse(f"{path} was edited: its SHA-256 is not that of {SUMS}; {_REMEDY}")
    return set(listed)


_REMEDY = "remedy: another folder"


def _bits(files: dict[str, bytes]) -> int:
    """Runs the vectors on this machine; returns the hash of all outputs' bits. Raises CompilerError."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for name, data in files.items():
            put(folder / name, data)
        sources = [folder / name for name in files if name.endswith(".c")]
        printed = run_program(sources, [folder / "portable", folder / "src"])
    return int(printed.partition("; bits ")[2][:16], 16)


def _bill(interface: Interface, block: Path, version: str, files: dict[str, bytes]) -> bytes:
    """CycloneDX 1.6: each file with its hash, and the packages that tables of numbers were made from."""
    components: list[dict[str, object]] = [
        {"type": "file", "name": name, "bom-ref": name, "hashes": [_hash(data)], "licenses": _LICENCE}
        for name, data in sorted(files.items())
    ]
    for package in data_packages(block):
        found = version_of(package) or ""
        purl = f"pkg:pypi/{package}@{found}"
        entry: dict[str, object] = {"type": "library", "name": package, "version": found, "purl": purl, "bom-ref": purl}
        components.append(entry | {"scope": "excluded", "description": "Tables of numbers in the C were made from it"})
    about = {"type": "library", "name": interface.name, "version": version, "bom-ref": interface.name}
    bill = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": about | {"description": interface.description, "licenses": _LICENCE}},
        "components": components,
        "dependencies": [{"ref": interface.name, "dependsOn": [str(c["bom-ref"]) for c in components]}],
    }
    return json.dumps(bill, indent=2).encode() + b"\n"


def _hash(data: bytes) -> dict[str, str]:
    return {"alg": "SHA-256", "content": hashlib.sha256(data).hexdigest()}
