"""Broken FMUs, and what `orchestrate` makes of each.

`python -m tests.orchestration.broken > tests/orchestration/broken.md` writes them. It ends with an error where one does not end as
its case says; the tests run all cases of FMI 2.0, and of those of FMI 3.0, which end alike, some.
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
_LIBRARY = f"binaries/{fmpy.platform}/broken{fmpy.sharedLibraryExtension}"
_WHOLE = {"xml": XML.format(guid="none-none")}


@dataclass(frozen=True)
class Case:
    """A way of being broken. By `guid` the binary breaks, else `make` writes the file."""

    name: str
    message: str
    """What the error output must hold."""
    guid: str = ""
    make: Callable[[Path], object] | None = None
    status: int = 3
    samples: int = 0
    """Rows in the results."""
    timeout: str = "1 s"


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


def _write(path: Path, binary: bytes | None = None, xml: str | bytes = _WHOLE["xml"], **more: bytes) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", xml)
        archive.writestr(_LIBRARY, fmus.library("broken") if binary is None else binary)
        for name, data in more.items():
            archive.writestr(name, data)


def _entry(name: str, mode: int = 0o100644, data: bytes = b"../outside", declared: int = 0) -> Callable[[Path], None]:
    """With one more entry, of this name and mode; `declared` is the size that it says it has."""

    def make(path: Path) -> None:
        _write(path)
        with zipfile.ZipFile(path, "a") as archive:
            entry = zipfile.ZipInfo(name)
            entry.external_attr = mode << 16
            archive.writestr(entry, data)
            entry.file_size = declared or len(data)

    return make


def _xml(old: str, new: str) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        xml = XML.format(guid="none-none")
        assert old in xml, old
        _write(path, xml=xml.replace(old, new))

    return make


def _laughs() -> str:
    entities = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 12))
    return f'<!DOCTYPE f [<!ENTITY l0 "ha">{entities}]>\n<fmiModelDescription description="&l11;" '


def _bytes_changed(path: Path) -> None:
    data = b"what a model reads"
    _entry("resources/data", data=data)(path)
    path.write_bytes(path.read_bytes().replace(data, data[::-1]))


def _truncated(path: Path) -> None:
    _write(path)
    path.write_bytes(path.read_bytes()[:-300])


def _other_platform(path: Path) -> None:
    other = "win64" if fmpy.platform != "win64" else "linux64"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", _WHOLE["xml"])
        archive.writestr(f"binaries/{other}/broken", b"")


def _compiled(option: str) -> Callable[[Path], None]:
    return lambda path: _write(path, fmus.library("broken", option))


_IN = "in initialization"
_ERROR = "gave status error\n  vendor logged: [error] cannot go on from 0"
CASES = [
    # ---------------------------------------------------------------- in a step
    Case(
        "a segmentation fault",
        "vendor: fmi2DoStep at 1 s: crashed with SIGSEGV (segmentation fault)\n  vendor logged: stepping from 1",
        "step-segfault",
        samples=11,
    ),
    Case("abort", "vendor: fmi2DoStep at 1 s: crashed with SIGABRT (aborted)", "step-abort", samples=11),
    Case("a failed assertion", "vendor logged: driver.c:17: assertion failed: ready", "step-assert", samples=11),
    Case("a stack without end", "fmi2DoStep at 1 s: crashed with SIGSEGV", "step-overflow", samples=11),
    Case("exit", "vendor: fmi2DoStep at 1 s: ended its process, with exit status 0", "step-exit", samples=11),
    Case(
        "a hang",
        "vendor: fmi2DoStep at 1 s: did not return within 1 s (the block's 'timeout'), so its process was ended",
        "step-hang",
        samples=11,
    ),
    Case(
        "memory without end",
        "crashed with SIGSEGV (segmentation fault); it had used up the 300 MB that the block's 'memory' allows",
        "step-memory",
        samples=11,
        timeout="20 s",
    ),
    Case("log messages without end", "did not return within 1 s", "step-log", samples=11),
    Case("printing without end", "did not return within 1 s", "step-chatter", samples=11),
    Case("all its files closed, ours with them", "fmi2DoStep at 1 s: broke off its connection, so its process was ended", "step-deaf", samples=11),
    Case("a child process left behind", "crashed with SIGSEGV", "step-child", samples=11),
    Case("a file written where it stands", "vendor logged: [error] left a file at 1", "step-litter", samples=11),
    Case("a line that is printed and not ended", "vendor logged: no end of line after this", "step-print", samples=11),
    Case("NaN", "vendor: output y at 1.1 s: is nan, expected a finite number\n  vendor logged: stepping from 1", "step-nan", samples=11),
    Case("infinity", "vendor: output y at 1.1 s: is inf, expected a finite number", "step-infinity", samples=11),
    Case(
        "status error",
        "vendor: fmi2DoStep at 1 s: gave status error\n  vendor logged: stepping from 1\n"
        "  vendor logged: [error] cannot go on from 1",
        "step-error",
        samples=11,
    ),
    Case("status discard", "fmi2DoStep at 1 s: gave status discard", "step-discard", samples=11),
    Case("status fatal", "fmi2DoStep at 1 s: gave status fatal", "step-fatal", samples=11),
    Case("status pending", "fmi2DoStep at 1 s: gave status pending", "step-pending", samples=11),
    Case("an error on Set in a step", "vendor: fmi2SetReal at 1 s: gave status error", "input-error", samples=11),
    Case("a crash on Set in a step", "vendor: fmi2Set at 1 s: crashed with SIGSEGV", "input-segfault", samples=11),
    Case("an error on Get in a step", "vendor: fmi2GetReal at 1 s: gave status error", "output-error", samples=11),
    Case("a crash on Get in a step", "vendor: fmi2Get at 1 s: crashed with SIGSEGV", "output-segfault", samples=11),
    # ---------------------------------------------------------------- in initialization
    Case("an error on Set", f"vendor: fmi2SetReal of x {_IN}: {_ERROR}", "set-error"),
    Case("an error on SetupExperiment", f"vendor: fmi2SetupExperiment {_IN}: {_ERROR}", "setup-error"),
    Case("an error on entering initialization", f"vendor: fmi2EnterInitializationMode {_IN}: {_ERROR}", "enter-error"),
    Case("an error on Get", f"vendor: fmi2GetReal of y {_IN}: {_ERROR}", "get-error"),
    Case("NaN at the start", f"vendor: output y {_IN}: is nan, expected a finite number", "get-nan"),
    Case("an error on leaving initialization", f"vendor: fmi2ExitInitializationMode {_IN}: {_ERROR}", "leave-error"),
    Case("a crash in initialization", f"vendor: fmi2EnterInitializationMode {_IN}: crashed with", "enter-segfault"),
    Case("a hang in initialization", f"vendor: fmi2ExitInitializationMode {_IN}: did not return", "leave-hang"),
    # ---------------------------------------------------------------- at the end
    Case("a crash on Terminate", "vendor: fmi2Terminate at 2 s: crashed with", "terminate-segfault", samples=21),
    Case("a hang on Terminate", "vendor: fmi2Terminate at 2 s: did not return", "terminate-hang", samples=21),
    Case("a crash on FreeInstance", "vendor: fmi2FreeInstance at 2 s: crashed with", "free-abort", samples=21),
    # ---------------------------------------------------------------- before anything runs
    Case("a crash on loading", f"loading its library {_IN}: crashed with", make=_compiled("-DLOADING"), status=2),
    Case(
        "a missing symbol", "needs the symbol vendor_runtime_start", make=_compiled("-DMISSING"), status=2
    ),
    Case(
        "a function of FMI's missing",
        "lacks the function fmi2DoStep",
        make=_compiled("-DWITHOUT_STEP"),
        status=2,
    ),
    Case("a library that is none", "is damaged, or no library of this platform", make=lambda p: _write(p, b"text"), status=2),
    Case("an error on Instantiate", f"fmi2Instantiate {_IN}: gave no instance", "instantiate-error", status=2),
    Case("a crash on Instantiate", f"fmi2Instantiate {_IN}: crashed with SIGSEGV", "instantiate-segfault", status=2),
    Case("a hang on Instantiate", f"fmi2Instantiate {_IN}: did not return", "instantiate-hang", status=2),
    Case("a wrong GUID", "vendor logged: [error] the GUID says nothing to", "{8c4e810f}", status=2),
    Case("no binary for this platform", "has no binary for this platform", make=_other_platform, status=2),
    Case("a truncated archive", "is a damaged or truncated zip archive", make=_truncated, status=2),
    Case("bytes changed in the archive", "is a damaged zip archive", make=_bytes_changed, status=2),
    Case(
        "a path out of its folder", "would unpack to a place outside its folder: ../evil", make=_entry("../evil"), status=2
    ),
    Case("an absolute path", "outside its folder: /evil", make=_entry("/evil"), status=2),
    Case("a path with a drive", "outside its folder: C:/evil", make=_entry("C:/evil"), status=2),
    Case(
        "a symbolic link",
        "holds a symbolic link, resources/link; expected files only",
        make=_entry("resources/link", 0o120777),
        status=2,
    ),
    Case(
        "a zip bomb",
        "would unpack to 20 GB; expected at most 2 GB",
        make=_entry("resources/bomb", declared=20 * 10**9),
        status=2,
    ),
    Case(
        "an entry that is larger than it says", "is a damaged zip archive", make=_entry("resources/x", declared=5), status=2
    ),
    Case("malformed XML", "modelDescription.xml cannot be read", make=_xml("</ModelVariables>", ""), status=2),
    Case("XML that breaks its schema", "is not valid", make=_xml('causality="input"', 'causality="inptu"'), status=2),
    Case(
        "XML whose entities explode", "has a DOCTYPE, which an FMU does not need",
        make=_xml("<fmiModelDescription ", _laughs()), status=2,
    ),
    Case(
        "XML that reads a file", "has a DOCTYPE, which an FMU does not need",
        make=_xml("<fmiModelDescription ", '<!DOCTYPE f [<!ENTITY x SYSTEM "file:///etc/passwd">]>\n<fmiModelDescription '),
        status=2,
    ),
    Case("FMI 3.1", "is an FMU of FMI 3.1; expected FMI 2.0 or 3.0", make=_xml('fmiVersion="2.0"', 'fmiVersion="3.1"'), status=2),
    Case("model exchange only", "is for model exchange only", make=_xml("<CoSimulation", "<ModelExchange"), status=2),
]  # fmt: skip

# ---------------------------------------------------------------- FMI 3.0: the same block behind as_fmi3.c

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
_NAMES_3 = {
    "fmi2SetReal": "fmi3SetFloat64",
    "fmi2GetReal": "fmi3GetFloat64",
    "fmi2SetupExperiment": "fmi3EnterInitializationMode",
    "fmi2Instantiate": "fmi3InstantiateCoSimulation",
    "fmi2": "fmi3",
    "status pending": "status 5",
}
"""What is named otherwise than in FMI 2.0."""


def _three(guid: str = "none-none", old: str = "", new: str = "", option: str = "-O1") -> Callable[[Path], object]:
    xml = XML_3.format(guid=guid).replace(old, new) if old else XML_3.format(guid=guid)
    assert new in xml, new
    return lambda path: as_fmi3.pack(path, xml, fmus.library("broken", option, str(as_fmi3.SOURCE)), None, "broken")


def _renamed(case: Case) -> Case:
    names = {"an error on SetupExperiment": "", "status pending": "a status that there is not"}
    message = case.message
    for old, new in _NAMES_3.items():
        message = message.replace(old, new)
    return replace(case, name=names.get(case.name, case.name), message=message, guid="", make=_three(case.guid))


_CLOCK = '<Clock name="tick" valueReference="7" causality="input" intervalVariability="triggered"/></ModelVariables>'
CASES_3 = [
    *(case for case in map(_renamed, (case for case in CASES if case.guid)) if case.name),
    Case("a request for event mode", "fmi3DoStep at 1 s: asks for event mode", make=_three("step-event"), samples=11),
    Case("a request to end the simulation", "fmi3DoStep at 1 s: asks to end the", make=_three("step-end"), samples=11),
    Case("a return before its time", "fmi3DoStep at 1 s: has returned early", make=_three("step-early"), samples=11),
    Case("a crash on loading", f"loading its library {_IN}: crashed with", make=_three(option="-DLOADING"), status=2),
    Case("a missing symbol", "needs the symbol vendor_runtime_start", make=_three(option="-DMISSING"), status=2),
    Case("a function of FMI's missing", "lacks the function fmi3DoStep", make=_three(option="-DWITHOUT_STEP_3"), status=2),
    Case("XML that breaks its schema", "is not valid", make=_three(old='"input"', new='"inptu"'), status=2),
    Case("clocks", "has clocks, which need event mode: tick;", make=_three(old="</ModelVariables>", new=_CLOCK), status=2),
    Case("an array without elements", "has the dimensions [0]", make=_three(old='start="0"/>', new='start="0"><Dimension start="0"/></Float64>'), status=2),
    Case("too few start values", "x has 2 start values; expected one or 3", make=_three(old='start="0"/>', new='start="0 0"><Dimension start="3"/></Float64>'), status=2),
    Case("model exchange only", "is for model exchange only", make=_three(old="<CoSimulation", new="<ModelExchange"), status=2),
    Case("scheduled execution only", "is for scheduled execution only", make=_three(old="<CoSimulation", new="<ScheduledExecution"), status=2),
]  # fmt: skip
TESTED_3 = ("a segmentation fault", "NaN", "status fatal", "a return before its time", "an error on Set", "clocks")
"""Of FMI 3.0, the cases that the tests run."""


def outcome(case: Case, folder: Path) -> Outcome:
    """Runs a case by the command itself, in the given folder."""
    home, temporary = folder / "home", folder / "temporary"
    home.mkdir()
    temporary.mkdir()
    if case.make is not None:
        case.make(home / "vendor.fmu")
    else:
        _write(home / "vendor.fmu", xml=XML.format(guid=case.guid))
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

    It writes its exit status into a file: `Process.exitcode` is 255 where a thread that starts another process reads it first.
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
    """tests/orchestration/broken.md, with all cases of FMI 3.0; raises AssertionError where one of these does not end as it should."""
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

What becomes of a run with an FMU that breaks, as its exit status (3: an FMU failed; 2: found before anything ran), its message and
the samples on disk. Each row is a test, which also sees to it that the run ends by itself, that no process is left over and that no
file lies where it should not. This file is made from their output by `python -m tests.orchestration.broken > tests/orchestration/broken.md`,
which tests all rows; of those of FMI 3.0, `make test` tests some.

The FMU is given by its path, so it runs in a process of its own, here with `timeout: 1 s` (`20 s` where it takes memory) and `memory: 300 MB`; it breaks in the step
that begins at 1 s, or where the row says. A sample is taken every 0.1 s from 0 on: 11 up to 1 s, 21 in a whole run.

| what is broken | message | status | samples |
|---|---|---|---|"""


if __name__ == "__main__":
    if "--json" in sys.argv:
        print(json.dumps({name: [o.status, o.seconds, o.output] for name, o in outcomes().items()}, indent=1))
    else:
        print(page(), end="")
