"""Wrong scenarios, options and FMUs, each with the message that it must give: those of wrong_inputs.yaml.

`python -m tests.orchestration.wrong_inputs > tests/orchestration/wrong_inputs.md` writes them.
"""

from __future__ import annotations

import re
import tempfile
import traceback
import zipfile
from collections.abc import Callable, Mapping
from contextlib import chdir
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import Path
from typing import Any

import fmpy
import yaml
from click.testing import CliRunner

from orchestration.cli.main import main

from . import fmus, vendor

SCENARIO = """\
name: loop
step: 0.1 s
duration: 2 s
blocks:
  motor:
    fmu: motor.fmu
    start:
      speed0: 2 rad/s
      inertia: 0.5
  regulator:
    fmu: regulator.fmu
    start: {gain: -1, enabled: true}
connections:
  - motor.speed -> regulator.speed
  - regulator.voltage -> motor.voltage
record: {interval: 0.1 s}
expect:
  - name: the motor stops
    signal: motor.speed
    always: {below: 30 rpm}
"""


@dataclass(frozen=True)
class Case:
    name: str
    message: str
    """What the error output must hold; PLATFORM stands for that of this machine."""
    old: str = ""
    new: str = ""
    """Text of SCENARIO and what stands there instead; without `old`, `new` is the whole file."""
    options: tuple[str, ...] = ("loop.yaml",)
    spoil: Mapping[str, Any] = field(default_factory=dict)
    """How the folder that holds the scenario and its FMUs is spoilt, by the names of `SPOIL`."""
    status: int = 2
    runs: bool = False
    """Whether an FMU has to be loaded to find it."""


def _write(folder: Path, files: Mapping[str, str | bytes]) -> None:
    for name, data in files.items():
        (folder / name).write_bytes(data if isinstance(data, bytes) else data.encode())


def _replace_by_folder(folder: Path, name: str) -> None:
    (folder / name).unlink(missing_ok=True)
    (folder / name).mkdir()


def _truncate(folder: Path, name: str) -> None:
    (folder / name).write_bytes((folder / name).read_bytes()[:-200])


def _repack(folder: Path, change: list[str]) -> None:
    """Replaces an entry of the motor's FMU, or leaves it out where it has no content."""
    name, *content = change
    path = folder / "motor.fmu"
    with zipfile.ZipFile(path) as archive:
        kept = {n: archive.read(n) for n in archive.namelist() if n != name}
    kept |= dict.fromkeys([name], content[0].encode()) if content else {}
    with zipfile.ZipFile(path, "w") as archive:
        for entry, data in kept.items():
            archive.writestr(entry, data)


def _rewrite(folder: Path, change: list[str]) -> None:
    """Replaces text of a modelDescription.xml, of the motor's where no other is named."""
    old, new, name = [*change, "motor"][:3]
    xml = fmus.description(name)
    assert old in xml, old
    fmus.write(folder / f"{name}.fmu", xml.replace(old, new))


SPOIL: dict[str, Callable[[Path, Any], object]] = {
    "file": _write,
    "folder": _replace_by_folder,
    "truncated": _truncate,
    "entry": _repack,
    "xml": _rewrite,
    "other_platform": lambda folder, name: fmus.write(
        folder / f"{name}.fmu", fmus.description(name), folder="win64" if fmpy.platform != "win64" else "linux64"
    ),
    "no_library": lambda folder, name: fmus.write(folder / f"{name}.fmu", fmus.description(name)),
    "guid": lambda folder, guid: fmus.write(folder / "motor.fmu", fmus.description("motor", guid=guid), fmus.library()),
    "vendor": lambda folder, _: vendor.write(folder),
}


def _cases() -> list[Case]:
    sections = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text("utf-8"))
    entries = {name: entry for section in sections.values() for name, entry in section.items()}
    return [
        Case(name, **{**entry, "message": entry["message"].replace("PLATFORM", fmpy.platform)})
        for name, entry in entries.items()
    ]


CASES = _cases()


def outcome(case: Case, folder: Path) -> tuple[int, str]:
    """Exit status and error output of a case, run in the given folder."""
    assert case.old in SCENARIO, case.old
    text = SCENARIO.replace(case.old, case.new, 1) if case.old else case.new or SCENARIO
    (folder / "loop.yaml").write_text(text.replace("ZEROS", "0" * 399), "utf-8")
    fmus.write_pair(folder, case.runs)
    for kind, change in case.spoil.items():
        SPOIL[kind](folder, change)
    with chdir(folder):
        result = CliRunner().invoke(main, list(case.options))
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        return 70, "".join(traceback.format_exception(result.exception))
    return result.exit_code, result.stderr


def outcomes() -> dict[str, tuple[int, str, bool]]:
    """Of every case: the exit status, what is told, and whether anything was run."""
    found = {}
    for case in CASES:
        with tempfile.TemporaryDirectory() as folder:
            found[case.name] = (*outcome(case, Path(folder)), Path(folder, "results", "loop").exists())
    return found


def page(outcomes: Mapping[str, tuple[int, str, bool]]) -> str:
    """tests/orchestration/wrong_inputs.md."""
    lines = [_HEAD]
    for case in CASES:
        status, output, _ = outcomes[case.name]
        told, *more = [line for line in output.splitlines() if line]
        first = [told, *takewhile(lambda line: line.startswith("  "), more)]
        shown = "<br>".join(f"`{re.sub('[|]', '¦', line.strip())}`" for line in first)
        lines.append(f"| {case.name} | {shown} | {status} |")
    return "\n".join(lines) + "\n"


_HEAD = """\
# Errors

What `orchestrate` says of wrong scenarios, options and FMUs, and its exit status: 2 where the input is wrong and
nothing was run, 3 where an FMU failed. Each row is a test; this file is made from their output by
`python -m tests.orchestration.wrong_inputs > tests/orchestration/wrong_inputs.md`.
The scenario is a loop of a motor and its regulator.

| what is wrong | message | status |
|---|---|---|"""


if __name__ == "__main__":
    print(page(outcomes()), end="")
