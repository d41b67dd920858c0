"""The FMU of a telemetry entry, made once for a file and its description, and kept."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path

from fmus import places
from fmus.build import BuildError
from fmus.contents.description import guid_from
from fmus.interface import BLOCKS, load
from fmus.kept import code

from ..errors import InputError, Problem, reason
from ..paths import located
from ..quantities import parse_unit
from ..scenario.scenario import Scenario
from ..scenario.telemetry import Telemetry
from .record import Record, Seen

KEPT = 30
"""FMUs of records, at most; the oldest go."""


def packed(scenario: Scenario, name: str, entry: Telemetry) -> Path:
    """Returns the FMU of a block's record. Raises InputError, placed in the file or at the block's entry."""
    key = ("blocks", name, "telemetry")
    with scenario.source.naming((*key, "file")):
        path = located(entry.file, scenario.source.folder)
        if path.is_dir():
            raise InputError(f"{entry.file} is a folder; expected a file")
        if not path.is_file():
            raise InputError(f"{entry.file} is no regular file" if path.exists() else f"there is no file {entry.file}")
    with scenario.source.naming(key):
        return fmu_of(entry, path)


def fmu_of(entry: Telemetry, path: Path) -> Path:
    """Returns the FMU of a record, which is made where there is none. Raises InputError."""
    from fmus import telemetry  # takes 0.1 s and few scenarios need it  # noqa: PLC0415

    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    stated = entry.model_dump_json()
    readers = code(Path(__file__).parent), code(Path(telemetry.__file__).parent)
    digest = hashlib.sha256(f"{digest}{stated}{readers}".encode()).hexdigest()
    target = places.work() / "fmus" / "telemetry" / f"{digest[:32]}.fmu"
    if target.exists() and target.with_suffix(".json").exists():
        return target
    record = Record(entry, path, entry.file)
    ports = [telemetry.Port(n, c.shape, c.unit, _about(c.description, n, c.cells)) for n, c in entry.columns.items()]
    if len(ports) > telemetry.PORTS_MAX or sum(port.size for port in ports) > telemetry.VALUES_MAX:
        text = f"expected at most {telemetry.PORTS_MAX} ports of {telemetry.VALUES_MAX} elements in all"
        raise InputError(Problem(text, found=f"{len(ports)} ports"))
    try:
        telemetry.pack(
            target,
            ports,
            record.stream(),
            stop=600.0,
            step=1.0,
            guid=guid_from(digest),
            description=f"Record {path.name}",
        )
        target.with_suffix(".json").write_text(json.dumps(asdict(record.seen) | {"utc": record.utc}), "utf-8")
        _prune(target.parent)
    except OSError as error:
        raise InputError(f"the FMU of {entry.file} cannot be written: {reason(error)}") from None
    except (BuildError, RuntimeError) as error:
        raise InputError(f"the FMU of {entry.file} cannot be built: {error}") from None
    return target


def notes_of(fmu: Path, file: str, duration: float) -> list[str]:
    """Returns what a user of a run of this duration, s, should know of a record whose FMU this is."""
    data = json.loads(fmu.with_suffix(".json").read_text("utf-8"))
    utc = data.pop("utc")
    seen = Seen(**data)
    begins = f"{file}: {seen.rows} rows to {seen.last:.10g} s" + (f", t = 0 is {utc}" if utc else "")
    late = [f"the first row is at {seen.begin:.10g} s, after the run"] if seen.begin > duration else []
    return ["; ".join([begins, *late, *seen.notes()])]


def unit_notes(scenario: Scenario, name: str, entry: Telemetry) -> list[str]:
    """Returns a note for each port whose unit is not of the kind that ports of its name have in this project's blocks:
    a port that nothing reads is held against nothing else."""
    notes = []
    for port, column in entry.columns.items():
        named = {block: load(block).variables[port] for block in BLOCKS if port in load(block).variables}
        units = {block: v.units[0] or "1" for block, v in named.items() if v.type == "real"}
        if units and not any(parse_unit(column.unit).fits(parse_unit(unit)) for unit in units.values()):
            block, unit = next(iter(units.items()))
            text = f"{column.unit!r} does not fit {unit!r}, the unit that a port of this name has in {block}"
            notes.append(scenario.note(("blocks", name, "telemetry", "columns", port, "unit"), text))
    return notes


def _about(description: str, name: str, columns: list[str]) -> str:
    about = f"{description or name}, of {', '.join(columns)}"
    return "".join(c if c.isprintable() else " " for c in about)  # XML has no control characters


def _prune(folder: Path) -> None:
    by_age = sorted(folder.glob("*.fmu"), key=lambda path: path.stat().st_mtime)
    for old in by_age[:-KEPT]:
        old.unlink(missing_ok=True)
        old.with_suffix(".json").unlink(missing_ok=True)
