"""Scenarios changed at random, in their data, their text and their bytes: each is loaded, planned, and flown where it
is short.

An input may be refused, with a message, or accepted. Any other exception is a failure, and so are 5 s of processor
time, or a minute, without an end.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import tempfile
import traceback
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any

import click
import yaml

from orchestration import BlockError, InputError, load
from orchestration.errors import ResultsError
from orchestration.session.open import open_scenario
from orchestration.session.run import execute

from ..orchestration import fmus, vendor
from ..orchestration.wrong_inputs import SCENARIO

SECONDS = 5
"""What one input may take."""
_STEPS = 40
"""A scenario of no more steps is flown, where its FMUs run in this process."""
_SHOWN = 5
WHOLE = (
    SCENARIO.replace("duration: 2 s", "duration: 1 s\nisolation: none").replace(
        "fmu: regulator.fmu", "fmu: vendor.fmu\n    interface: regulator.fmu\n    map: mapping.yaml\n    every: 1"
    )
    + """\
  - {name: settles, signal: motor.speed, when: motor.hot, after: 0.5 s, ever: {above: 1 rad/s}}
  - {name: samples, signal: regulator.samples, measure: norm, always: {within: 5 V}}
holds:
  - {name: heat, signal: motor.hot, keeps: [motor.speed, 'regulator.samples[1]'], limits: {hot: motor.hot}}
faults:
  - {at: 0.3 s, until: 0.5 s, set: 'regulator.gain = -0.5'}
  - {at: 0.4 s, freeze: motor.speed}
figures:
  - {name: speed, title: 'Speed', shade: motor.hot, mark: motor.speed,
     panels: [{signals: [motor.speed], unit: rpm, lines: [30 rpm]}, {signals: [regulator.samples], measure: norm}]}
cycle: {name: turns, period: 0.5 s}
delays: []
"""
)
INLINE = WHOLE.replace(
    "map: mapping.yaml",
    f"map: {{ports: {{voltage: command, gain: {{theirs: kp, scale: {vendor.GAIN!r}}}}}, ignore: [speed], "
    "inputs: {rate: motor.speed}}",
)
"""Theirs takes the motor's speed by an input that only it has."""
VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 2, 3.5, 1e300, -1e-300, 10**400, float("inf"), float("nan"), "", " ", "x"),
    *("nan", "1 s", "0.1", "51,6 deg", "10 dB", "1 m", "1 N-m", "1e999 s", "9**9", "motor", "motor.speed"),
    *("motor.speed[1]", "motor.speed[0]", "motor.*", "*.*", "regulator.samples[3]", "motor.speed -> motor.voltage"),
    *("motor.hot", "motor.label", "regulator.enabled", "motor.axis[1,2]", "motor.axis[99999999999999999999]"),
    *("a -> b -> c", "motor.fmu", "vendor.fmu", "mapping.yaml", "plant", "../..", "/dev/null", "/"),
    *("~nobody/x.fmu", "http://x/y.fmu", "process", "none", "parallel", "\ud800", "\x00", "\x1b[2J", "ü" * 300),
    *("{}", "[", "%", "'", "&a", "*a", "!!python/object:os.system x", [], [[]], [1, "x"], [1, 2, 3], [None], {}),
    *({"file": "x"}, {"theirs": "rate"}, {"above": 1}, {"within": [1, 2]}, {"fmu": "motor.fmu"}),
    *({"signal": "motor.speed"},),
)
KEYS = (
    *("", "x", "fmu", "map", "start", "every", "signal", "always", "ever", "at", "until", "set", "unit", "lines"),
    *("interval", "block", "ports", "inputs", "1", "motor", "a.b", "ü", "\x00", "<<", "null"),
)
PIECES = (
    *("\t", " ", ":", "- ", "[", "]", "{", "}", "&a ", "*a", "<<: ", "|", ">", "#", '"', "'", "\x00", "\ufeff"),
    *("\u2028", "\x85", "%", "!!binary ", "!!set ", "? ", "---\n", "...\n", "\r", "1e", "-", ",", "->", "."),
)


class _Hang(BaseException):
    """An input that does not come to an end."""


@click.command("scenarios")
@click.option("--count", default=10_000, show_default=True, help="Inputs.")
@click.option("--seed", default=1, show_default=True)
def command(count: int, seed: int) -> None:
    """Load, plan and fly scenarios that are changed at random."""
    here, handlers = Path.cwd(), [(number, signal.signal(number, _hang)) for number in (signal.SIGALRM, signal.SIGPROF)]
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        fmus.write_pair(Path())
        vendor.write(Path(), runnable=True)
        ends: Counter[str] = Counter()
        failures: list[str] = []
        for number in range(count):
            random = Random(f"{seed}.{number}")
            file = random.choice(("loop.yaml", "loop.yaml", "mapping.yaml"))
            Path("loop.yaml").write_text(INLINE if random.random() < 0.3 else WHOLE, "utf-8")
            Path("mapping.yaml").write_text(vendor.MAPPING, "utf-8")
            Path(file).write_bytes(changed(random, Path(file).read_text("utf-8")))
            end = _end(Path("loop.yaml"))
            ends[end.partition("\n")[0]] += 1
            if end.startswith("FAILURE"):
                failures.append(f"input {number}, {file}: {end}")
        os.chdir(here)
    for number, handler in handlers:
        signal.signal(number, handler)
    for end, times in sorted(ends.items()):
        click.echo(f"{times:8}  {end}")
    for failure in failures[:_SHOWN]:
        click.echo(failure)
    click.echo(f"{count} scenarios, seed {seed}: {len(failures)} failures")
    sys.exit(1 if failures else 0)


def _hang(*_: Any) -> None:
    raise _Hang


def _end(path: Path) -> str:
    """How it ended; a failure with its traceback."""
    signal.alarm(12 * SECONDS)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        opened = open_scenario(load(path))
        scenario = opened.plan.scenario
        short = opened.plan.clock.steps <= _STEPS
        alone = [scenario.isolation, *(entry.isolation for entry in scenario.blocks.values())]
        if not short or "process" in alone or scenario.isolation != "none":
            return "planned"
        result = execute(scenario)
        result.save(Path("out"))
        return "flown" if result.failure is None else "flown up to a failure of an FMU"
    except InputError as error:
        if all(message.strip() for message in error.messages) and error.messages:
            return "refused"
        return "FAILURE: refused without a word"
    except (BlockError, ResultsError) as error:
        return f"ended with {type(error).__name__}"
    except _Hang:
        return f"FAILURE: no end within {SECONDS} s\n{traceback.format_exc(limit=-4)}"
    except Exception as error:
        return f"FAILURE: {type(error).__name__}\n{traceback.format_exc(limit=-6)}"
    finally:
        signal.alarm(0)
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def changed(random: Random, text: str) -> bytes:
    """The file with one to four changes."""
    kind = random.random()
    if kind < 0.65:
        data = yaml.safe_load(text)
        for _ in range(random.choice((1, 1, 1, 2, 3))):
            data = _data(random, data)
        text = json.dumps(data, ensure_ascii=random.random() < 0.5, allow_nan=True, indent=random.choice((None, 1)))
        text = text.replace("Infinity", ".inf").replace("NaN", ".nan")
    else:
        for _ in range(random.choice((1, 1, 1, 2, 3))):
            text = _text(random, text)
    return _bytes(random, text)


def _data(random: Random, data: Any) -> Any:
    """A value, a key or a type exchanged, an entry left out, doubled, moved or nested."""
    places: list[tuple[Any, Any]] = []
    _collect(data, places)
    if not places:
        return random.choice(VALUES)
    holder, key = random.choice(places)
    kind = random.randrange(8)
    if kind <= 2:
        holder[key] = random.choice(VALUES)
    elif kind == 3:
        del holder[key]
    elif kind == 4:
        other, there = random.choice(places)
        holder[key] = json.loads(json.dumps(other[there])) if there in other or isinstance(other, list) else None
    elif kind == 5 and isinstance(holder, dict):
        holder[random.choice(KEYS)] = holder.pop(key)
    elif kind == 6 and isinstance(holder, list):
        holder.insert(key, holder[key])
    elif kind == 7 and isinstance(holder[key], str) and holder[key]:
        holder[key] = _text(random, holder[key])
    else:
        holder[key] = random.choice(([holder[key]], {"x": holder[key]}, [[holder[key]] * 3], str(holder[key])))
    return data


def _collect(data: Any, places: list[tuple[Any, Any]]) -> None:
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        places.append((data, key))
        _collect(value, places)


def _text(random: Random, text: str) -> str:
    """Characters, words or lines left out, doubled, exchanged or put in."""
    kind = random.randrange(5)
    if kind == 0:
        at = random.randrange(len(text) + 1)
        return text[:at] + random.choice(PIECES) + text[at:]
    if kind == 1 and text:
        at = random.randrange(len(text))
        return text[:at] + text[at + random.randint(1, 5) :]
    lines = text.splitlines(keepends=True)
    if kind == 2 and lines:
        at = random.randrange(len(lines))
        return "".join([*lines[:at], *lines[at : at + 1] * random.choice((0, 2)), *lines[at + 1 :]])
    if kind == 3 and len(lines) > 1:
        a, b = random.randrange(len(lines)), random.randrange(len(lines))
        lines[a], lines[b] = lines[b], lines[a]
        return "".join(lines)
    words = text.split(" ")
    words[random.randrange(len(words))] = str(random.choice(VALUES))
    return " ".join(words)


def _bytes(random: Random, text: str) -> bytes:
    """Mostly UTF-8; at times another encoding, an order mark, a byte changed, or the end cut off."""
    kind = random.random()
    if kind < 0.9:
        return text.encode("utf-8", "surrogatepass" if kind < 0.02 else "replace")
    if kind < 0.94:
        others = "utf-16", "utf-16-le", "utf-32", "latin-1", "cp1252", "utf-8-sig", "utf-7"
        return text.encode(random.choice(others), "replace")
    data = bytearray(text.encode("utf-8", "replace"))
    if kind < 0.97 and data:
        data[random.randrange(len(data))] = random.randrange(256)
        return bytes(data)
    return bytes(data[: random.randrange(len(data) + 1)])
