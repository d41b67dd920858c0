"""Plays a recorded vector at a device, with no FMU between, and compares its outputs. It needs nothing but Python; a
kit holds a copy.

python bench.py vector run build/device              # starts a program that serves `pipe ADDRESS`, and plays it
python bench.py vector serial /dev/ttyUSB0           # a board; also udp HOST:PORT, tcp HOST:PORT, pipe ADDRESS
"""

from __future__ import annotations

import csv
import os
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from itertools import product
from pathlib import Path
from typing import Any, Protocol

from .device import (
    ANSWER,
    END,
    GREETING,
    HELLO,
    PARAMETERS,
    REFUSED,
    START,
    STEP,
    Field,
    Frame,
    Layout,
    Ports,
    Reader,
    frame,
)
from .lines import KINDS, Line

TRIES, WAIT = 4, 0.5
"""How often a request is sent, and how long each time its answer is waited for, s."""
ROUNDING = 1e-15


class Failed(Exception):
    """The device did not answer, or refused."""


class _Line(Protocol):
    def send(self, data: bytes) -> None: ...
    def receive(self, wait: float) -> bytes: ...


class Master:
    """Asks a device."""

    def __init__(self, ports: Ports, line: _Line) -> None:
        self._ports, self._line, self._reader = ports, line, Reader(ports.largest)
        self._session, self._sequence, self._token = time.monotonic_ns() & 0xFFFFFFFF, 0, os.urandom(8)
        self._layouts = [Layout(fields, 0) for fields in (ports.parameters, ports.inputs, ports.outputs)]

    def begin(self, parameters: dict[str, Any], inputs: dict[str, Any]) -> dict[str, Any]:
        """Greets the device, tells it the parameters and starts it; its outputs at the start. Raises Failed."""
        answer = self._ask(HELLO, GREETING.pack(0, 0, self._ports.hash, self._ports.name.encode(), self._token))
        _, _, digest, name, _ = GREETING.unpack(answer.payload)
        if digest != self._ports.hash:
            built = name.split(b"\0")[0].decode("ascii", "replace")
            other = " with other ports or parameters" if built == self._ports.name else ""
            raise Failed(f"the device is built for the interface {built}{other}; expected {self._ports.name}")
        self._ask(PARAMETERS, self._layouts[0].pack(parameters))
        return self._outputs(self._ask(START, struct.pack("<dd", 0.0, 0.0) + self._layouts[1].pack(inputs)), 0.0, 0.0)

    def step(self, t: float, h: float, inputs: dict[str, Any]) -> dict[str, Any]:
        """The outputs at t + h for the inputs there. Raises Failed."""
        return self._outputs(self._ask(STEP, struct.pack("<dd", t, h) + self._layouts[1].pack(inputs)), t + h, h)

    def end(self) -> None:
        """Tells the device that the run has ended."""
        self._line.send(frame(END, self._session, self._sequence + 1, b""))

    def _outputs(self, answer: Frame, asked: float, h: float) -> dict[str, Any]:
        (time_,) = struct.unpack_from("<d", answer.payload)
        if not abs(time_ - asked) <= 0.5 * h + 1e-6:
            raise Failed(f"expected outputs for {asked:g} s, found those for {time_:g} s")
        return vars(self._layouts[2].unpack(answer.payload[8:]))

    def _ask(self, type_: int, payload: bytes) -> Frame:
        self._sequence += 1
        request = frame(type_, self._session, self._sequence, payload)
        for _ in range(TRIES):
            self._line.send(request)
            until = time.monotonic() + WAIT
            while (left := until - time.monotonic()) > 0.0:
                for answer in self._reader.feed(self._line.receive(left)):
                    if (answer.session, answer.sequence) != (self._session, self._sequence):
                        continue
                    if answer.type == REFUSED:
                        raise Failed(
                            "the device refuses: " + answer.payload[1:].split(b"\0")[0].decode("ascii", "replace")
                        )
                    if answer.type == type_ | ANSWER:
                        return answer
        raise Failed(f"expected an answer within {TRIES * WAIT:g} s, found none")


def elements(field: Field) -> list[tuple[str, tuple[int, ...]]]:
    """The columns of a variable in vector.csv, and the place of each in it."""
    places = list(product(*(range(n) for n in field.shape)))
    return [(field.name + "".join(f"[{i + 1}]" for i in place), place) for place in places]


def _set(values: dict[str, Any], field: Field, place: tuple[int, ...], text: str) -> None:
    value: Any = text if field.type == "string" else float(text) if field.type == "real" else int(float(text))
    if not place:
        values[field.name] = value
        return
    target = values[field.name]
    for i in place[:-1]:
        target = target[i]
    target[place[-1]] = value


def _starts(fields: Iterable[Field]) -> dict[str, Any]:
    def copied(value: Any) -> Any:
        return [copied(v) for v in value] if isinstance(value, list) else value

    return {f.name: copied(f.start) for f in fields}


def _at(value: Any, place: tuple[int, ...]) -> float:
    for i in place:
        value = value[i]
    return float(value)


def play(ports: Ports, folder: Path, line: _Line) -> Iterator[tuple[float, dict[str, float], dict[str, float]]]:
    """Time, outputs of the device and recorded outputs, by column, at each instant of a vector. Raises Failed."""
    settings = {label: (f, place) for f in ports.parameters for label, place in elements(f)}
    feeds = {label: (f, place) for f in ports.inputs for label, place in elements(f)}
    reads = {label: (f, place) for f in ports.outputs for label, place in elements(f)}
    parameters, inputs = _starts(ports.parameters), _starts(ports.inputs)
    with (folder / "parameters.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            _set(parameters, *settings[row["name"]], row["value"])
    master, last = Master(ports, line), None
    with (folder / "vector.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            now = float(row["time"])
            for label in feeds.keys() & row.keys():
                _set(inputs, *feeds[label], row[label])
            outputs = master.begin(parameters, inputs) if last is None else master.step(last, now - last, inputs)
            columns = [label for label in row if label in reads]
            given = {label: _at(outputs[reads[label][0].name], reads[label][1]) for label in columns}
            yield now, given, {label: float(row[label]) for label in columns}
            last = now
    master.end()


def compare(ports: Ports, folder: Path, line: _Line, tolerance: float = 1e-6) -> bool:
    """Prints the largest difference of each output; whether all are within the tolerance of the output's
    largest value.
    """
    worst: dict[str, tuple[float, float]] = {}
    peak: dict[str, float] = {}
    rows = 0
    for now, given, wanted in play(ports, folder, line):
        rows += 1
        for label, value in wanted.items():
            difference = abs(given[label] - value)
            largest = worst.get(label, (-1.0, 0.0))[0]
            if largest == largest and not difference <= largest:  # one that is not a number stays
                worst[label] = difference, now
            peak[label] = max(peak.get(label, 0.0), abs(value))
    print(f"{rows} rows, tolerance {tolerance:g} of the largest value\n")
    print(f"        {'output':<24} {'difference':>12} {'relative':>10}  at")
    within = {label: d <= max(tolerance * peak[label], ROUNDING) for label, (d, _) in worst.items()}
    for label, (difference, at) in worst.items():
        share = difference / peak[label] if peak[label] else difference
        when = f"{at:g} s" if difference else ""
        print(
            f"{'ok    ' if within[label] else 'DIFFER'}  {label:<24} {difference:12.4g} {share:10.2g}  {when}".rstrip()
        )
    right = rows > 0 and all(within.values())
    print(f"\n{'all outputs are as expected' if right else 'outputs differ from what is expected'}")
    return right


def main(ports: Ports, arguments: list[str]) -> None:
    """VECTOR KIND PLACE [TOLERANCE]; the exit status is 1 where outputs differ or the device does not answer."""
    if len(arguments) not in (3, 4) or arguments[1] not in (*KINDS, "run"):
        sys.exit(
            f"use: bench.py VECTOR run PROGRAM | {' | '.join(f'{kind} PLACE' for kind in KINDS)}, then a tolerance"
        )
    folder, (kind, place) = Path(arguments[0]), arguments[1:3]
    tolerance = float(arguments[3]) if len(arguments) > 3 else 1e-6
    with tempfile.TemporaryDirectory() as temporary:
        program = None
        if kind == "run":
            command = [sys.executable, place] if place.endswith(".py") else [place]
            kind, place = "pipe", f"{temporary}/line"
            program = subprocess.Popen([*command, kind, place], stdout=subprocess.PIPE)
            assert program.stdout is not None
            program.stdout.readline()  # "ready"
        try:
            right = compare(ports, folder, Line(kind, place), tolerance)
        except (Failed, OSError) as error:
            sys.exit(f"{kind} {place}: {error}")
        finally:
            if program is not None:
                program.kill()
                program.wait()
    sys.exit(0 if right else 1)
