"""Wrong scenarios, options and FMUs, each with the message that it must give.

`python -m tests.orchestration.wrong_inputs > tests/orchestration/wrong_inputs.md` writes them.
"""

from __future__ import annotations

import os
import re
import tempfile
import traceback
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

import fmpy
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
    """What the error output must hold."""
    old: str = ""
    new: str = ""
    """Text of SCENARIO and what stands there instead; without `old`, `new` is the whole file."""
    options: tuple[str, ...] = ()
    spoil: Callable[[Path], object] = lambda folder: None
    """Spoils the folder that holds the scenario and its FMUs."""
    status: int = 2
    runs: bool = False
    """Whether an FMU has to be loaded to find it."""


def _repack(name: str, **entries: bytes | None) -> Callable[[Path], object]:
    """An FMU with entries replaced (bytes) or left out (None); `x__y` stands for `x/y`."""

    def spoil(folder: Path) -> None:
        path = folder / name
        changed = {key.replace("__", "/"): value for key, value in entries.items()}
        with zipfile.ZipFile(path) as archive:
            kept = {n: archive.read(n) for n in archive.namelist() if n not in changed}
        with zipfile.ZipFile(path, "w") as archive:
            for entry, data in {**kept, **changed}.items():
                if data is not None:
                    archive.writestr(entry, data)

    return spoil


def _xml(old: str, new: str, name: str = "motor") -> Callable[[Path], object]:
    def spoil(folder: Path) -> None:
        xml = fmus.description(name)
        assert old in xml, old
        fmus.write(folder / f"{name}.fmu", xml.replace(old, new))

    return spoil


def _other_platform(folder: Path) -> None:
    other = "win64" if fmpy.platform != "win64" else "linux64"
    fmus.write(folder / "motor.fmu", fmus.description("motor"), folder=other)


def _file(name: str, data: bytes) -> Callable[[Path], object]:
    return lambda folder: (folder / name).write_bytes(data)


def _truncate(folder: Path) -> None:
    path = folder / "motor.fmu"
    path.write_bytes(path.read_bytes()[:-200])


MOTOR, EXPECT = "blocks.motor", "expect[1]"
EXPECT_BEGIN = "expect:\n"
CASES = [
    # ---------------------------------------------------------------- the file
    Case("no such scenario", "lop.yaml: there is no such file; did you mean 'loop.yaml'?", options=("lop.yaml",)),
    Case(
        "a folder instead of a scenario",
        "results: it is a folder; expected a file",
        options=("results",),
        spoil=lambda f: (f / "results").mkdir(),
    ),
    Case("a misspelt command", "bild: there is no such command or scenario; did you mean 'build'?", options=("bild",)),
    Case("an empty file", "loop.yaml: is empty", new="# nothing\n"),
    Case("a file that is no text", "loop.yaml: expected text in UTF-8", spoil=_file("loop.yaml", b"\xff\xfe\x00name")),
    Case(
        "broken YAML",
        "loop.yaml:13: no valid YAML: while parsing a flow mapping from line 12 on, expected ',' or '}'",
        "enabled: true}",
        "enabled: true",
    ),
    Case("a tab for indentation", "loop.yaml:6: no valid YAML:", "    fmu: motor.fmu", "\tfmu: motor.fmu"),
    Case("a key twice", "loop.yaml:3: 'step' is given twice; first in line 2", "duration: 2 s", "step: 0.2 s"),
    Case(
        "a list instead of keys",
        "loop.yaml:1: expected keys such as 'name' and 'blocks', found a list",
        new="- a\n- b\n",
    ),
    # ---------------------------------------------------------------- files that it extends, values that it shares
    Case(
        "a file to extend that is not there",
        "loop.yaml:2: extends: parts/motor.yaml: there is no such file",
        "step: 0.1 s",
        "extends: parts/motor.yaml\nstep: 0.1 s",
    ),
    Case(
        "files that extend each other",
        "part.yaml:1: extends[1]: the files extend each other in a circle: loop.yaml -> part.yaml -> loop.yaml",
        "step: 0.1 s",
        "extends: part.yaml\nstep: 0.1 s",
        spoil=_file("part.yaml", b"extends: [loop.yaml]\n"),
    ),
    Case(
        "a wrong value in a file that is extended",
        "part.yaml:3: shared.gain: expected a number or text with a unit, found true",
        "    start: {gain: -1, enabled: true}\n",
        "extends: part.yaml\n",
        spoil=_file("part.yaml", b"shared:\n\n  gain: true\n"),
    ),
    Case(
        "a shared value that no block takes",
        "loop.yaml:2: shared.inertai: no block has a parameter 'inertai'; did you mean 'inertia'?",
        "step: 0.1 s",
        "shared: {inertai: 0.5}\nstep: 0.1 s",
    ),
    Case(
        "a difference declared of what is no parameter",
        "loop.yaml:7: blocks.motor.differs[1]: motor has no parameter 'gain' that other blocks state, too",
        "    fmu: motor.fmu",
        "    fmu: motor.fmu\n    differs: [gain]",
    ),
    Case(
        "a form of a matrix for a scalar",
        "blocks.motor.start.inertia: expected one value, found 2 rows of 2",
        "inertia: 0.5",
        "inertia: {diagonal: [1, 2]}",
    ),
    Case(
        "times counted in what no cycle names",
        "loop.yaml:3: duration: unknown unit 'orbits'; expected seconds, text such as '10 min', or a count of "
        "what 'cycle' names",
        "duration: 2 s",
        "duration: 2 orbits",
    ),
    # ---------------------------------------------------------------- keys and types
    Case("a misspelt key", "loop.yaml:3: unknown key 'duratoin'; did you mean 'duration'?", "duration:", "duratoin:"),
    Case("a missing key", "loop.yaml:1: 'step' is missing: the base communication step", "step: 0.1 s\n", ""),
    Case(
        "a misspelt key of a block",
        f"loop.yaml:7: {MOTOR}: unknown key 'strat'; did you mean 'start'?",
        "start:\n      speed0",
        "strat:\n      speed0",
    ),
    Case("a number for a name", "loop.yaml:1: name: expected text, found 7", "name: loop", "name: 7"),
    Case(
        "a name that is no folder's",
        "loop.yaml:1: name: expected a name of letters, digits and _ . -, found '../loop'",
        "name: loop",
        "name: ../loop",
    ),
    Case(
        "a block's name with a dot",
        "loop.yaml:5: blocks.motor.a: expected a name of letters, digits and _, found 'motor.a'",
        "  motor:",
        "  motor.a:",
    ),
    Case(
        "text for a list",
        "loop.yaml:13: connections: expected a list, found 'all'",
        "connections:\n  - motor.speed -> regulator.speed\n  - regulator.voltage -> motor.voltage",
        "connections: all",
    ),
    Case(
        "a choice that is none",
        "loop.yaml:3: exchange: expected 'sequential' or 'parallel', found 'sequentail'; did you mean 'sequential'?",
        "duration: 2 s",
        "exchange: sequentail\nduration: 2 s",
    ),
    # ---------------------------------------------------------------- times
    Case("a step of zero", "loop.yaml:2: step: expected a time above zero, found 0 s", "step: 0.1 s", "step: 0"),
    Case(
        "a negative duration",
        "loop.yaml:3: duration: expected a time above zero, found -2 s",
        "duration: 2 s",
        "duration: -2 s",
    ),
    Case("a step that is no time", "loop.yaml:2: step: the unit 'm' does not fit 's'", "step: 0.1 s", "step: 0.1 m"),
    Case("a step of no number", "loop.yaml:2: step: expected a finite number, found nan", "step: 0.1 s", "step: .nan"),
    Case(
        "a rate that is no whole number",
        f"loop.yaml:6: {MOTOR}.every: expected a whole number, found 1.5",
        "    fmu: motor.fmu",
        "    every: 1.5\n    fmu: motor.fmu",
    ),
    Case(
        "a rate of zero",
        f"loop.yaml:6: {MOTOR}.every: expected 1 or more, found 0",
        "    fmu: motor.fmu",
        "    every: 0\n    fmu: motor.fmu",
    ),
    Case(
        "a rate slower than the run",
        f"loop.yaml:6: {MOTOR}.every: motor would never be stepped: the run has only 20 base steps",
        "    fmu: motor.fmu",
        "    every: 21\n    fmu: motor.fmu",
    ),
    Case(
        "a factor of real time that is none",
        "loop.yaml:4: realtime.factor: expected a number above zero, found 'fast'",
        "blocks:\n",
        "realtime: {factor: fast}\nblocks:\n",
    ),
    Case(
        "a policy for late steps that is none",
        "loop.yaml:4: realtime.late: expected 'continue' or 'stop', found 'sotp'; did you mean 'stop'?",
        "blocks:\n",
        "realtime: {late: sotp}\nblocks:\n",
    ),
    Case(
        "a tolerance for late steps of zero",
        "loop.yaml:4: realtime.tolerance: expected a time above zero, found 0 s",
        "blocks:\n",
        "realtime: {tolerance: 0}\nblocks:\n",
    ),
    Case(
        "--realtime before the scenario",
        "--realtime loop.yaml: expected a number or off; remedy: --realtime after the scenario, or --realtime=1",
        options=("run", "--realtime", "loop.yaml"),
    ),
    Case(
        "a factor of real time of zero",
        "--realtime 0: expected a number above zero, found 0",
        options=("loop.yaml", "--realtime", "0"),
    ),
    Case(
        "late steps of a run that is not in real time",
        "--late stop: only a run in real time has late steps; remedy: --realtime",
        options=("loop.yaml", "--late", "stop"),
    ),
    Case(
        "an interval that is no multiple of the step",
        "loop.yaml:16: record.interval: expected a multiple of the base step, 0.1 s, found 0.25 s; nearest: 0.2 s "
        "or 0.3 s",
        "interval: 0.1 s",
        "interval: 0.25 s",
    ),
    Case(
        "a duration of no step",
        "--duration 1e-30: expected at least one step, 0.1 s, found 1e-30 s",
        options=("loop.yaml", "--duration", "1e-30"),
    ),
    Case(
        "an interval longer than the run",
        "loop.yaml:16: record.interval: expected at most the duration, 2 s, found 3 s",
        "interval: 0.1 s",
        "interval: 3 s",
    ),
    # ---------------------------------------------------------------- start values
    Case(
        "a misspelt parameter",
        f"loop.yaml:9: {MOTOR}.start: motor has no parameter 'inertai'; did you mean 'inertia'?",
        "inertia: 0.5",
        "inertai: 0.5",
    ),
    Case(
        "a start value for an output",
        f"loop.yaml:9: {MOTOR}.start.speed: motor.speed is an output; only parameters and inputs take start "
        "values; did you mean 'speed0'?",
        "inertia: 0.5",
        "speed: 0.5",
    ),
    Case(
        "a value above its maximum",
        f"loop.yaml:9: {MOTOR}.start.inertia: expected at most 10 kg.m2, found 50 kg.m2",
        "inertia: 0.5",
        "inertia: 50",
    ),
    Case(
        "a value below its minimum, with a unit",
        f"loop.yaml:9: {MOTOR}.start.inertia: expected at least 0.001 kg.m2, found 1e-07 kg.m2 (1 g.cm2)",
        "inertia: 0.5",
        "inertia: 1 g.cm2",
    ),
    Case(
        "a value that is not finite",
        f"loop.yaml:9: {MOTOR}.start.inertia: expected a finite number, found nan",
        "inertia: 0.5",
        "inertia: .nan",
    ),
    Case(
        "text for a number",
        f"loop.yaml:9: {MOTOR}.start.inertia: expected a number with a unit such as '98 deg', found 'heavy'",
        "inertia: 0.5",
        "inertia: heavy",
    ),
    Case(
        "true for a number",
        f"loop.yaml:9: {MOTOR}.start.inertia: expected a number or text with a unit, found true",
        "inertia: 0.5",
        "inertia: true",
    ),
    Case(
        "nothing for a number",
        f"loop.yaml:9: {MOTOR}.start.inertia: expected a number or text with a unit, found nothing",
        "inertia: 0.5",
        "inertia:",
    ),
    Case("an unknown unit", f"loop.yaml:8: {MOTOR}.start.speed0: unknown unit 'rad/sec2nd'", "2 rad/s", "2 rad/sec2nd"),
    Case(
        "a unit of another quantity",
        f"loop.yaml:8: {MOTOR}.start.speed0: the unit 'm/s' does not fit 'rad/s'",
        "2 rad/s",
        "2 m/s",
    ),
    Case(
        "a unit where there is none",
        "loop.yaml:12: blocks.regulator.start.gain: gain has no unit, so expected a bare number, found '1 V'",
        "gain: -1",
        "gain: 1 V",
    ),
    Case(
        "a scalar for a vector",
        f"loop.yaml:9: {MOTOR}.start.axis: expected a list of 3 values, found 1",
        "inertia: 0.5",
        "axis: 1",
    ),
    Case(
        "a vector of a wrong length",
        f"loop.yaml:9: {MOTOR}.start.axis: expected a list of 3 values, found a list of 2",
        "inertia: 0.5",
        "axis: [1, 0]",
    ),
    Case(
        "a vector for a scalar",
        f"loop.yaml:9: {MOTOR}.start.inertia: expected one value, found a list of 3",
        "inertia: 0.5",
        "inertia: [1, 2, 3]",
    ),
    Case(
        "an element that is not there",
        f"loop.yaml:9: {MOTOR}.start.axis[4]: motor.axis is a real [3]; index 4 is outside 1 to 3",
        "inertia: 0.5",
        "'axis[4]': 1",
    ),
    Case(
        "a misspelt item",
        f"loop.yaml:9: {MOTOR}.start.mode: expected one of normal, brake, found 'brak'; did you mean 'brake'?",
        "inertia: 0.5",
        "mode: brak",
    ),
    Case(
        "a fraction for a whole number",
        f"loop.yaml:9: {MOTOR}.start.poles: expected a whole number, found 2.5",
        "inertia: 0.5",
        "poles: 2.5",
    ),
    Case(
        "a number for a boolean",
        f"loop.yaml:9: {MOTOR}.start.cooled: expected true or false, found 1",
        "inertia: 0.5",
        "cooled: 1",
    ),
    Case("a number for text", f"loop.yaml:9: {MOTOR}.start.label: expected text, found 5", "inertia: 0.5", "label: 5"),
    Case(
        "two units run together",
        f"loop.yaml:9: {MOTOR}.start.inertia: the unit 'Pas' would be read as 'pascal'; did you mean 'Pa.s'?",
        "inertia: 0.5",
        "inertia: 1 Pas",
    ),
    Case(
        "an element twice",
        f"loop.yaml:10: {MOTOR}.start.axis[2]: has a start value already, by 'axis', in line 9",
        "inertia: 0.5",
        "axis: [1, 0, 0]\n      'axis[2]': 1",
    ),
    Case(
        "a number of too many digits",
        f"loop.yaml:9: {MOTOR}.start.inertia: expected a number, found '1{'0' * 19}' ... of 400 digits",
        "inertia: 0.5",
        f"inertia: 1{'0' * 399}",
    ),
    Case(
        "a merge key",
        "loop.yaml:9: merging by '<<' is not supported; remedy: write the entries out",
        "inertia: 0.5",
        "<<: {inertia: 0.5}",
    ),
    # ---------------------------------------------------------------- options
    Case(
        "--set without a value",
        "--set motor.inertia: expected block.parameter=value",
        options=("loop.yaml", "--set", "motor.inertia"),
    ),
    Case(
        "--set of an unknown block",
        "--set moter.inertia=1: there is no block 'moter'; did you mean 'motor'?",
        options=("loop.yaml", "--set", "moter.inertia=1"),
    ),
    Case(
        "--set of an unknown parameter",
        "--set motor.inertai=1: motor has no parameter 'inertai'; did you mean 'inertia'?",
        options=("loop.yaml", "--set", "motor.inertai=1"),
    ),
    Case(
        "--set beyond a limit",
        "--set motor.inertia=11: expected at most 10 kg.m2, found 11 kg.m2",
        options=("loop.yaml", "--set", "motor.inertia=11"),
    ),
    Case(
        "--set of broken YAML",
        "--set motor.axis=[1,: no valid YAML",
        options=("loop.yaml", "--set", "motor.axis=[1,"),
    ),
    Case(
        "--step that is no time",
        "--step soon: expected a number with a unit such as '98 deg', found 'soon'",
        options=("loop.yaml", "--step", "soon"),
    ),
    Case(
        "an unknown format",
        "there is no format 'xls'; expected one of csv, parquet, mat",
        options=("loop.yaml", "--format", "xls"),
    ),
    Case(
        "results where a file is",
        "the results cannot be written to taken: taken is a file",
        options=("loop.yaml", "--out", "taken"),
        spoil=_file("taken", b""),
    ),
    # ---------------------------------------------------------------- connections
    Case(
        "a connection without an arrow",
        "loop.yaml:14: connections[1]: motor.speed regulator.speed: expected 'block.output -> block.input'",
        "motor.speed -> reg",
        "motor.speed reg",
    ),
    Case(
        "a connection to an unknown block",
        "there is no block 'regulater'; did you mean 'regulator'?",
        "-> regulator.speed",
        "-> regulater.speed",
    ),
    Case(
        "a misspelt output",
        "loop.yaml:14: connections[1]: motor.sped -> regulator.speed: motor has no output 'sped'; did you mean "
        "'speed'?",
        "motor.speed ->",
        "motor.sped ->",
    ),
    Case(
        "an input as a source",
        "motor.voltage is an input; expected an output of motor",
        "motor.speed -> regulator.speed",
        "motor.voltage -> regulator.speed",
    ),
    Case(
        "an output as a target",
        "regulator.voltage is an output; expected an input of regulator",
        "-> regulator.speed",
        "-> regulator.voltage",
    ),
    Case(
        "two sources for an input",
        "loop.yaml:15: connections[2]: regulator.voltage -> motor.voltage: motor.voltage already has a source: "
        "regulator.samples[1] -> motor.voltage",
        "motor.speed -> regulator.speed",
        "regulator.samples[1] -> motor.voltage",
    ),
    Case(
        "different shapes",
        "the shapes differ: regulator.samples is a real [2], motor.voltage is a real scalar",
        "regulator.voltage ->",
        "regulator.samples ->",
    ),
    Case("different types", "motor.steps is integer, regulator.speed is real", "motor.speed ->", "motor.steps ->"),
    Case(
        "units that do not fit",
        "the units do not fit: motor.speed is in rad/s, motor.voltage in V",
        "regulator.voltage ->",
        "motor.speed ->",
    ),
    Case(
        "an input without a value",
        "loop.yaml:5: blocks.motor: the input voltage is neither connected nor given a value",
        "  - regulator.voltage -> motor.voltage\n",
        "",
    ),
    Case(
        "an algebraic loop",
        "loop.yaml:13: connections: algebraic loop through regulator.voltage -> regulator.voltage; 'delays: "
        "[regulator.speed]' would break it",
        "motor.speed -> regulator.speed",
        "regulator.voltage -> regulator.speed",
        spoil=_xml(
            'valueReference="2" causality="input"><Real unit="rad/s"',
            'valueReference="2" causality="input"><Real unit="V"',
            "regulator",
        ),
    ),
    Case(
        "a delay of what is not connected",
        "loop.yaml:16: delays[1]: regulator.enabled is fed by no connection that could be delayed",
        "record:",
        "delays: [regulator.enabled]\nrecord:",
    ),
    # ---------------------------------------------------------------- recording and expectations
    Case(
        "an unknown signal",
        "loop.yaml:16: record.signals[1]: motor has no variable 'spead'; did you mean 'speed'?",
        "interval: 0.1 s",
        "signals: [motor.spead]",
    ),
    Case(
        "a pattern that nothing matches",
        "loop.yaml:16: record.signals[1]: no output matches 'moter.*'",
        "interval: 0.1 s",
        "signals: [moter.*]",
    ),
    Case(
        "text recorded",
        "loop.yaml:16: record.signals[1]: motor.label is text, which cannot be recorded",
        "interval: 0.1 s",
        "signals: [motor.label]",
    ),
    Case(
        "nothing recorded",
        "loop.yaml:16: record.signals: must not be empty",
        "interval: 0.1 s",
        "signals: []",
    ),
    Case(
        "a bound that nothing passes",
        f"loop.yaml:20: {EXPECT}.always.below: expected a finite number, found inf",
        "30 rpm",
        ".inf",
    ),
    Case(
        "two expectations of one name",
        "loop.yaml:21: expect[2].name: is that of expect[1], too; expected another",
        "    always: {below: 30 rpm}",
        "    zeros: 0\n  - {name: the motor stops, signal: motor.speed, zeros: 1}",
    ),
    Case(
        "two figures of one name",
        "loop.yaml:23: figures[2].name: is that of figures[1], too; expected another, since it names the file",
        "    always: {below: 30 rpm}",
        "    always: {below: 30 rpm}\nfigures:\n  - {name: speed, panels: [{signals: [motor.speed]}]}\n"
        "  - {name: speed, panels: [{signals: [motor.voltage]}]}",
    ),
    Case(
        "an expectation of an unknown signal",
        f"loop.yaml:19: {EXPECT}.signal: motor has no variable 'sped'; did you mean 'speed'?",
        "signal: motor.speed",
        "signal: motor.sped",
    ),
    Case(
        "an expectation without a bound",
        f"loop.yaml:18: {EXPECT}: expected exactly one of always, ever, zeros; found none",
        "    always: {below: 30 rpm}\n",
        "",
    ),
    Case(
        "a bound that is none",
        f"loop.yaml:20: {EXPECT}.always: unknown key 'belov'; did you mean 'below'?",
        "below",
        "belov",
    ),
    Case(
        "two bounds",
        f"loop.yaml:20: {EXPECT}.always: expected exactly one of below, above, within, equals; found below and above",
        "below: 30 rpm",
        "below: 30 rpm, above: 1",
    ),
    Case(
        "a bound in a wrong unit",
        f"loop.yaml:20: {EXPECT}.always.below: the unit 'V' does not fit that of speed, rad/s",
        "30 rpm",
        "30 V",
    ),
    Case(
        "a bound for a boolean",
        f"loop.yaml:20: {EXPECT}.always.below: motor.hot is boolean; expected 'equals: true' or 'equals: false'",
        "signal: motor.speed",
        "signal: motor.hot",
    ),
    Case(
        "an expectation after the end",
        f"loop.yaml:20: {EXPECT}.after: 20 s lies after the end of the run, 2 s",
        "    always: {",
        "    after: 20 s\n    always: {",
    ),
    Case(
        "an expectation of no span of time",
        f"loop.yaml:21: {EXPECT}.before: 1 s lies before 1.5 s, where the span begins",
        "    always: {",
        "    after: 1.5\n    before: 1 s\n    always: {",
    ),
    Case(
        "a condition that is no boolean",
        f"loop.yaml:20: {EXPECT}.when: expected one boolean, but motor.steps is an integer scalar",
        "    always: {",
        "    when: motor.steps\n    always: {",
    ),
    # ---------------------------------------------------------------- FMUs
    Case(
        "an unknown block of this project",
        f"loop.yaml:6: {MOTOR}.fmu: this project has no block 'moter'",
        "fmu: motor.fmu",
        "fmu: moter",
    ),
    Case(
        "no such FMU",
        f"loop.yaml:6: {MOTOR}.fmu: there is no FMU moter.fmu; did you mean 'motor.fmu'?",
        "fmu: motor.fmu",
        "fmu: moter.fmu",
    ),
    Case(
        "an address",
        f"loop.yaml:6: {MOTOR}.fmu: http://x/y.fmu is an address; expected the path of an .fmu file",
        "fmu: motor.fmu",
        "fmu: http://x/y.fmu",
    ),
    Case(
        "a flavour of a file",
        f"loop.yaml:7: {MOTOR}.flavour: only this project's own blocks have a flavour; motor.fmu is a file",
        "fmu: motor.fmu",
        "fmu: motor.fmu\n    flavour: python",
    ),
    Case(
        "a folder instead of an FMU",
        f"{MOTOR}.fmu: motor.fmu is a folder; expected a file",
        spoil=lambda f: ((f / "motor.fmu").unlink(), (f / "motor.fmu").mkdir()),
    ),
    Case(
        "a file that is no zip",
        f"{MOTOR}.fmu: motor.fmu is no FMU: an FMU is a zip archive",
        spoil=_file("motor.fmu", b"hello"),
    ),
    Case("a truncated zip", f"{MOTOR}.fmu: motor.fmu is a damaged or truncated zip archive", spoil=_truncate),
    Case(
        "a zip without modelDescription.xml",
        "motor.fmu is no FMU: it holds no modelDescription.xml",
        spoil=_repack("motor.fmu", **{"modelDescription.xml": None}),
    ),
    Case(
        "a zip that reaches outside",
        "motor.fmu would unpack to a place outside its folder: ../evil",
        spoil=_repack("motor.fmu", **{"..__evil": b""}),
    ),
    Case(
        "modelDescription.xml that is no XML",
        "motor.fmu: modelDescription.xml cannot be read:",
        spoil=_xml("</fmiModelDescription>", ""),
    ),
    Case(
        "an output that is no variable",
        "motor.fmu: modelDescription.xml:33: Outputs/Unknown: index: there is no variable 9999; expected 1 to 15, "
        "as there are 15",
        spoil=_xml('<Unknown index="14"', '<Unknown index="9999"'),
    ),
    Case(
        "modelDescription.xml against its schema",
        "motor.fmu: modelDescription.xml is not valid:\n  ERROR",
        spoil=_xml('causality="input"', 'causality="inptu"'),
    ),
    Case(
        "an undefined unit",
        'The unit "rad/s" of variable "speed"',
        spoil=_xml('<Unit name="rad/s">', '<Unit name="rad/S">'),
    ),
    Case(
        "FMI 1.0",
        "motor.fmu is an FMU of FMI 1.0; expected FMI 2.0 or 3.0 for co-simulation",
        spoil=_xml('fmiVersion="2.0"', 'fmiVersion="1.0"'),
    ),
    Case(
        "FMI 3.1",
        "motor.fmu is an FMU of FMI 3.1; expected FMI 2.0 or 3.0 for co-simulation",
        spoil=_xml('fmiVersion="2.0"', 'fmiVersion="3.1"'),
    ),
    Case(
        "model exchange only",
        "motor.fmu is for model exchange only; expected an FMU for co-simulation",
        spoil=_xml("<CoSimulation", "<ModelExchange"),
    ),
    Case(
        "no binary for this platform",
        f"motor.fmu has no binary for this platform: expected binaries/{fmpy.platform}/",
        spoil=_other_platform,
    ),
    Case(
        "a binary that is none",
        "motor.fmu: motor: loading its library in initialization: binaries/",
        spoil=lambda f: fmus.write(f / "motor.fmu", fmus.description("motor")),
    ),
    Case(
        "a wrong GUID",
        "motor.fmu: motor: fmi2Instantiate in initialization: gave no instance\n  motor logged: [error] expected "
        "the GUID probe, found other",
        spoil=lambda f: fmus.write(f / "motor.fmu", fmus.description("motor", guid="other"), fmus.library()),
        runs=True,
    ),
    # ---------------------------------------------------------------- faults and isolation
    Case(
        "a fault that sets a fixed parameter",
        "loop.yaml:18: faults[1].set: motor.inertia is fixed: FMI lets only tunable parameters and inputs be set "
        "during a run",
        EXPECT_BEGIN,
        "faults:\n  - {at: 1 s, set: motor.inertia = 2}\n" + EXPECT_BEGIN,
    ),
    Case(
        "a fault of a misspelt signal",
        "faults[1].freeze: motor has no input or output or parameter 'sped'; did you mean 'speed'?",
        EXPECT_BEGIN,
        "faults:\n  - {at: 1 s, freeze: motor.sped}\n" + EXPECT_BEGIN,
    ),
    Case(
        "a fault in a unit that does not fit",
        "faults[1].bias: by: the unit 'V' does not fit that of speed, rad/s",
        EXPECT_BEGIN,
        "faults:\n  - {at: 1 s, bias: motor.speed, by: 3 V}\n" + EXPECT_BEGIN,
    ),
    Case(
        "a fault that says twice what goes wrong",
        "faults[1]: expected exactly one of set, freeze, bias, cut; found freeze and cut",
        EXPECT_BEGIN,
        "faults:\n  - {at: 1 s, freeze: motor.speed, cut: motor.speed}\n" + EXPECT_BEGIN,
    ),
    Case(
        "a time limit without a process",
        "loop.yaml:7: blocks.motor.timeout: only an FMU in a process of its own has this limit; remedy: "
        "isolation: process",
        "    fmu: motor.fmu\n",
        "    fmu: motor.fmu\n    timeout: 5 s\n    isolation: none\n",
    ),
    # ---------------------------------------------------------------- FMUs that fail
    Case(
        "a swap of a block that there is not",
        "--swap regulater=vendor.fmu: there is no block 'regulater'; did you mean 'regulator'?",
        options=("loop.yaml", "--swap", "regulater=vendor.fmu"),
        spoil=vendor.write,
    ),
    Case(
        "a swap that does not fit",
        "input speed, a real scalar in rad/s, is missing; by name or unit it may be rate; remedy: 'speed: THEIRS'",
        options=("loop.yaml", "--swap", "regulator=vendor.fmu"),
        spoil=vendor.write,
    ),
    Case(
        "a value that a swapped FMU would not get",
        "vendor.fmu has no parameter gain, so this value would be lost; remedy: map it",
        options=("loop.yaml", "--swap", "regulator=vendor.fmu", "--map", "short.yaml"),
        spoil=lambda folder: (
            vendor.write(folder),
            (folder / "short.yaml").write_text("ports: {speed: rate, voltage: command}\n"),
        ),
    ),
    Case(
        "a mapping whose unit does not fit",
        "input speed = rate: ours, rad/s, over 2 kg does not come out in rpm",
        options=("loop.yaml", "--swap", "regulator=vendor.fmu", "--map", "short.yaml"),
        spoil=lambda folder: (
            vendor.write(folder),
            (folder / "short.yaml").write_text("ports: {speed: {theirs: rate, divide: 2 kg}, voltage: command}\n"),
        ),
    ),
    Case(
        "a start value that the FMU refuses, and names",
        "loop.yaml:12: blocks.regulator.start.gain: the gain is refused: -1",
        options=("loop.yaml", "--set", "regulator.fault=5"),
        runs=True,
    ),
    Case(
        "an FMU that refuses its parameters",
        "motor: fmi2ExitInitializationMode in initialization: gave status error\n  motor logged: [error] the gain "
        "is refused: 0",
        options=("loop.yaml", "--set", "motor.fault=5"),
        status=3,
        runs=True,
    ),
    Case(
        "an FMU that fails in a step",
        "motor: fmi2DoStep at 1.5 s: gave status error\n  motor logged: [error] cannot step from 1.5",
        options=("loop.yaml", "--set", "motor.fault=1", "--set", "motor.fault_time=1.5"),
        status=3,
        runs=True,
    ),
    Case(
        "an FMU that discards a step",
        "motor: fmi2DoStep at 0 s: gave status discard\n  motor logged: [discard] step too long: 0.1",
        options=("loop.yaml", "--set", "motor.fault=4"),
        status=3,
        runs=True,
    ),
    Case(
        "an FMU with a fatal error",
        "motor: fmi2DoStep at 0 s: gave status fatal\n  motor logged: [fatal] broken at 0",
        options=("loop.yaml", "--set", "motor.fault=3"),
        status=3,
        runs=True,
    ),
    Case(
        "an output that is not a number",
        "motor: output speed at 1.1 s: is nan, expected a finite number",
        options=("loop.yaml", "--set", "motor.fault=2", "--set", "motor.fault_time=1"),
        status=3,
        runs=True,
    ),
]


@contextmanager
def _inside(folder: Path) -> Iterator[None]:
    here = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(here)


def outcome(case: Case, folder: Path) -> tuple[int, str]:
    """Exit status and error output of a case, run in the given folder."""
    text = SCENARIO
    if case.old:
        assert case.old in text, case.old
        text = text.replace(case.old, case.new, 1)
    elif case.new:
        text = case.new
    (folder / "loop.yaml").write_text(text, "utf-8")
    fmus.write_pair(folder, case.runs)
    case.spoil(folder)
    with _inside(folder):
        result = CliRunner().invoke(main, list(case.options or ("loop.yaml",)))
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
    lines = [
        "# Errors",
        "",
        "What `orchestrate` says of wrong scenarios, options and FMUs, and its exit status: 2 where the input is "
        "wrong and nothing was run,",
        "3 where an FMU failed. Each row is a test; this file is made from their output by",
        "`python -m tests.orchestration.wrong_inputs > tests/orchestration/wrong_inputs.md`. The scenario is a "
        "loop of a motor and its regulator.",
        "",
        "| what is wrong | message | status |",
        "|---|---|---|",
    ]
    for case in CASES:
        status, output, _ = outcomes[case.name]
        told, *more = [line for line in output.splitlines() if line]
        first = [told, *takewhile(lambda line: line.startswith("  "), more)]
        shown = "<br>".join(f"`{re.sub('[|]', '¦', line.strip())}`" for line in first)
        lines.append(f"| {case.name} | {shown} | {status} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(page(outcomes()), end="")
