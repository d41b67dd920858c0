"""Broken FMUs, and what `orchestrate` makes of each.

`python -m tests.orchestration.broken > tests/orchestration/broken.md` writes them. It ends with an error where one does
not end as broken.yaml says; the tests run all cases of FMI 2.0, and of those of FMI 3.0, which end alike, some.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import re
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

import fmpy
import yaml

from . import as_fmi3, fmus

_SCENARIO = """\
name: run
step: 0.1 s
duration: 2 s
blocks:
  vendor: {fmu: vendor.fmu, timeout: TIMEOUT, memory: 300 MB}
connections: [vendor.y -> vendor.x]
"""
XML = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="vendor" guid="{guid}">
  <CoSimulation modelIdentifier="broken"/>
  <ModelVariables>
    <ScalarVariable name="x" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies=""/></Outputs>
    <InitialUnknowns><Unknown index="2" dependencies=""/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


@dataclass(frozen=True)
class Case:
    name: str
    message: str
    """What the error output must hold."""
    guid: str = "none-none"
    """By it the binary breaks."""
    option: str = "-O1"
    """Of the compiler."""
    xml: tuple[str, str] = ("", "")
    """Text of the description, and what stands there instead."""
    binary: str = ""
    """In place of the library."""
    entry: Mapping[str, Any] | None = None
    """One more entry of the archive."""
    archive: str = ""
    """What becomes of the archive, by the names of `ARCHIVES`."""
    status: int = 3
    samples: int = 0
    """Rows in the results."""
    timeout: str = "1 s"
    fmi: int = 2


@dataclass(frozen=True)
class Outcome:
    status: int | None
    output: str
    """What it printed as errors."""
    table: str
    """What it printed else."""
    samples: int
    seconds: float
    files: set[str]
    """What lies in the scenario's folder afterwards, without the results."""
    temporary: set[str]
    """What is left in the folder of temporary files."""
    processes: set[str]
    """Processes that are left."""


XML_3 = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="vendor" instantiationToken="{{guid}}">
  <CoSimulation modelIdentifier="broken"/>
  <ModelVariables>
    {as_fmi3.TIME}
    <Float64 name="x" valueReference="{1 << 16}" causality="input" start="0"/>
    <Float64 name="y" valueReference="{(1 << 16) + 1}" causality="output"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="{(1 << 16) + 1}" dependencies=""/>
    <InitialUnknown valueReference="{(1 << 16) + 1}" dependencies=""/>
  </ModelStructure>
</fmiModelDescription>
"""
_LAUGHS = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 12))
_ENTITIES = f'<!DOCTYPE f [<!ENTITY l0 "ha">{_LAUGHS}]>\n<fmiModelDescription description="&l11;" '


def _write(case: Case, path: Path) -> None:
    """Writes the FMU of a case."""
    old, new = case.xml
    xml = (XML if case.fmi == 2 else XML_3).format(guid=case.guid)
    assert old in xml, old
    xml = xml.replace(old, _ENTITIES if new == "ENTITIES" else new) if old else xml
    if case.fmi == 3:
        library = fmus.library("broken", case.option, str(as_fmi3.SOURCE))
        as_fmi3.pack(path, xml, library, None, "broken")
        return
    fmus.write(path, xml, case.binary.encode() or fmus.library("broken", case.option), stem="broken")
    if case.entry is not None:
        _add(path, **case.entry)
    if case.archive:
        ARCHIVES[case.archive](path)


def _add(path: Path, name: str, mode: int = 0o100644, data: bytes = b"../outside", declared: int = 0) -> None:
    """Adds an entry of this name and mode; `declared` is the size that it says it has."""
    with zipfile.ZipFile(path, "a") as archive:
        entry = zipfile.ZipInfo(name)
        entry.external_attr = mode << 16
        archive.writestr(entry, data)
        entry.file_size = declared or len(data)


def _change_bytes(path: Path) -> None:
    data = b"what a model reads"
    _add(path, "resources/data", data=data)
    path.write_bytes(path.read_bytes().replace(data, data[::-1]))


ARCHIVES: dict[str, Callable[[Path], object]] = {
    "bytes_changed": _change_bytes,
    "truncated": lambda path: path.write_bytes(path.read_bytes()[:-300]),
    "other_platform": lambda path: fmus.write(
        path, XML.format(guid=""), folder="win64" if fmpy.platform != "win64" else "linux64", stem="broken"
    ),
}
_NAMES_3 = {
    "fmi2SetReal": "fmi3SetFloat64",
    "fmi2GetReal": "fmi3GetFloat64",
    "fmi2SetupExperiment": "fmi3EnterInitializationMode",
    "fmi2Instantiate": "fmi3InstantiateCoSimulation",
    "fmi2": "fmi3",
    "status pending": "status 5",
}
"""What is named otherwise than in FMI 2.0."""


def _renamed(case: Case) -> Case:
    """The same with the names of FMI 3.0, and without one where that version has no such case."""
    names = {
        "an error on SetupExperiment": "",
        "the end of the simulation": "",
        "status pending": "a status that there is not",
    }
    message = case.message
    for old, new in _NAMES_3.items():
        message = message.replace(old, new)
    return replace(case, name=names.get(case.name, case.name), message=message, fmi=3)


_ENTRIES: dict[str, dict[str, Any]] = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text("utf-8"))
_OWN_3 = _ENTRIES.pop("of FMI 3.0 only")
CASES = [Case(name, **entry) for section in _ENTRIES.values() for name, entry in section.items()]
CASES_3 = [case for case in map(_renamed, (case for case in CASES if case.guid != "none-none")) if case.name]
CASES_3 += [Case(name, **entry, fmi=3) for name, entry in _OWN_3.items()]
TESTED_3 = ("a segmentation fault", "NaN", "status fatal", "a return before its time", "an error on Set", "clocks")
"""Of FMI 3.0, the cases that the tests run."""


def outcome(case: Case, folder: Path) -> Outcome:
    """Runs a case by the command itself, in the given folder."""
    home, temporary = folder / "home", folder / "temporary"
    home.mkdir()
    temporary.mkdir()
    _write(case, home / "vendor.fmu")
    (home / "run.yaml").write_text(_SCENARIO.replace("TIMEOUT", case.timeout))
    begun = perf_counter()
    process = _servant().Process(target=_command, args=(home, temporary))
    process.start()
    process.join(60.0)
    seconds = perf_counter() - begun
    process.kill()
    status = folder / "status"
    signals = home / "results" / "run" / "signals.csv"
    return Outcome(
        int(status.read_text()) if status.exists() else None,
        (folder / "errors").read_text("utf-8"),
        (folder / "table").read_text("utf-8"),
        len(signals.read_text().splitlines()) - 1 if signals.exists() else 0,
        seconds,
        {str(p.relative_to(home)) for p in home.rglob("*") if "results" not in p.parts and p.is_file()},
        {p.name for p in temporary.iterdir()},
        _processes(folder),
    )


@cache
def _servant() -> Any:
    """Makes processes that have imported already what the command needs."""
    servant = multiprocessing.get_context("forkserver")
    servant.set_forkserver_preload(
        ["orchestration.cli.main", "orchestration.session.run", "orchestration.instances.isolation"]
    )
    return servant


def _command(home: Path, temporary: Path) -> None:
    """`orchestrate run.yaml` in the folder `home`.

    It writes its exit status into a file: `Process.exitcode` is 255 where a thread that starts another process reads it
    first.
    """
    from orchestration.cli.main import main

    os.chdir(home)
    os.environ.update(TMPDIR=str(temporary), NO_COLOR="1")
    sys.stdout = open(home.parent / "table", "w", encoding="utf-8")  # noqa: SIM115
    sys.stderr = open(home.parent / "errors", "w", encoding="utf-8")  # noqa: SIM115
    try:
        main(["run.yaml"], prog_name="orchestrate")
    except SystemExit as ended:
        (home.parent / "status").write_text(str(ended.code or 0))
        raise
    finally:
        sys.stdout.close()
        sys.stderr.close()


def _processes(folder: Path) -> set[str]:
    """Processes that work in this folder or were started for it."""
    found = set()
    for process in Path("/proc").glob("[0-9]*") if Path("/proc").exists() else ():
        try:
            place, environment = os.readlink(process / "cwd"), (process / "environ").read_bytes()
            if place.startswith(str(folder)) or str(folder).encode() in environment:
                found.add(f"{process.name} {(process / 'cmdline').read_bytes()!r}")
        except OSError:
            continue
    return found


@cache
def outcomes() -> dict[str, Outcome]:
    """What becomes of every case."""
    return _outcomes(CASES)


def _outcomes(cases: Sequence[Case]) -> dict[str, Outcome]:
    fmus.library("broken")

    def one(case: Case) -> Outcome:
        with tempfile.TemporaryDirectory() as folder:
            return outcome(case, Path(folder).resolve())

    with ThreadPoolExecutor(3) as several:
        return dict(zip([case.name for case in cases], several.map(one, cases), strict=True))


@cache
def outcomes_3() -> dict[str, Outcome]:
    """What becomes of the cases of FMI 3.0 that the tests run."""
    return _outcomes([case for case in CASES_3 if case.name in TESTED_3])


def page() -> str:
    """Returns tests/orchestration/broken.md, with all cases of FMI 3.0.

    Raises AssertionError where one of these does not end as it should.
    """
    found = _outcomes(CASES_3)
    differing = [
        (case.name, problems, found[case.name]) for case in CASES_3 if (problems := wrong(case, found[case.name]))
    ]
    assert not differing, differing
    return "\n".join([HEAD, *rows(CASES, outcomes()), HEAD_3, *rows(CASES_3, found)]) + "\n"


def wrong(case: Case, found: Outcome) -> list[str]:
    """What is not as a case says, or is left behind."""
    checks = {
        "message": case.message in found.output,
        "status": found.status == case.status,
        "samples": found.samples == case.samples,
        "seconds": found.seconds < 30.0,
        "files": found.files == {"run.yaml", "vendor.fmu"},
        "temporary files": found.temporary == set(),
        "processes": found.processes == set(),
        "messages": "Traceback" not in found.output and "internal error" not in found.output,
    }
    return [what for what, well in checks.items() if not well]


def rows(cases: Iterable[Case], outcomes: Mapping[str, Outcome]) -> list[str]:
    """The rows of the page."""
    lines = []
    for case in cases:
        found = outcomes[case.name]
        first, *rest = [line for line in found.output.splitlines() if line]
        lines_said = list(dict.fromkeys(line.strip() for line in rest))
        # Where it was ended in the middle of a line, that one is left out.
        said = [a for a in lines_said if not any(b != a and b.startswith(a) for b in lines_said)][-2:]
        shown = "<br>".join(f"`{re.sub('[|`]', '¦', line)}`" for line in [first, *said])
        lines.append(f"| {case.name} | {shown} | {found.status} | {found.samples if found.status == 3 else ''} |")
    return lines


HEAD_3 = """
## FMI 3.0

The same block behind the functions of FMI 3.0, with arrays and types of its own (docs/use/swap.md).

| what is broken | message | status | samples |
|---|---|---|---|"""
HEAD = """\
# Broken FMUs

What becomes of a run with an FMU that breaks, as its exit status (3: an FMU failed; 2: found before anything ran), its
message and the samples on disk. Each row is a test, which also sees to it that the run ends by itself, that no process
is left over and that no file lies where it should not. This file is made from their output by
`python -m tests.orchestration.broken > tests/orchestration/broken.md`, which tests all rows; of those of FMI 3.0,
`make test` tests some.

The FMU is given by its path, so it runs in a process of its own, here with `timeout: 1 s` (`20 s` where it takes
memory) and `memory: 300 MB`; it breaks in the step that begins at 1 s, or where the row says. A sample is taken every
0.1 s from 0 on: 11 up to 1 s, 21 in a whole run.

| what is broken | message | status | samples |
|---|---|---|---|"""


if __name__ == "__main__":
    if "--json" in sys.argv:
        print(json.dumps({name: [o.status, o.seconds, o.output] for name, o in outcomes().items()}, indent=1))
    else:
        print(page(), end="")
