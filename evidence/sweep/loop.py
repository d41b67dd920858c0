"""Tumbles of docs/evidence/flight.md flown by the blocks' own C, with variables in place of the planned controller's constants."""

from __future__ import annotations

import copy
import ctypes
import math
import re
import shutil
from collections.abc import Iterable, Mapping
from ctypes import byref, c_char_p, c_double, c_int, c_int32, c_void_p
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fmus.block import Block
from fmus.build import ensure
from fmus.interface import load as load_interface
from fmus.native import COMMON, generated_sources
from fmus.native.toolchain import compile_library, host_platform
from orchestration import InputError, load
from orchestration.fmu.archive import open_fmu
from orchestration.fmu.interfaces import with_inputs
from orchestration.fmu.model import Model
from orchestration.scenario.source import Source
from orchestration.system.starts import resolve

from ..flight.cases import RATE, Group
from ..flight.schemes import Data, change
from ..structures import filled
from .constants import CONSTANTS

BLOCKS = {
    "plant": "plant",
    "sensors": "plant_sensors",
    "controller": "controller_planned",
    "allocator": "allocator_bounded",
    "judge": "plant_judge",
}
"""By their places in the scenario, in the order of the structures of loop.c."""
ANGLE = math.radians(5.0)
"""Settled: below it and RATE, rad."""
STEP, UNTIL, QUIET = 0.5, 3000.0, 300.0
"""Of a flight, s: its step, its longest time, and how long it stays settled before it is ended."""

FROZEN_ATTITUDE, FROZEN_FIELD, ALARMS = 1, 2, 7
"""Measurements that freeze, and how many alarms there are: in the order of loop.c."""
UNUSED = '#pragma GCC diagnostic ignored "-Wunused-const-variable"\n'

Given = dict[str, dict[str, Any]]


class Course(ctypes.Structure):
    """What loop.c is told of a flight beside its parameters."""

    _fields_ = (
        *((name, c_double) for name in ("step", "until", "quiet", "angle", "rate", "hold", "fails")),
        ("frozen", c_int32),
    )


class Flown(ctypes.Structure):
    """What loop.c tells of a flight: times in s, infinite where never; errors of the attitude in rad."""

    _fields_ = (("settled", c_double), ("rms", c_double), ("largest", c_double), ("told", c_double * ALARMS))


@dataclass(frozen=True)
class Flight:
    """Parameters by place, and what becomes of them: from `fails`, s, on those that have `failed` and what is `frozen`."""

    given: Given
    failed: Given | None = None
    frozen: int = 0
    fails: float = math.inf
    expected: tuple[int, ...] = ()
    """Alarms that this failure is to raise; the last one has found it."""
    until: float = UNTIL
    hold: float = math.inf
    """s, from when the hold is judged; without it the flight ends once it is settled."""
    angle: float = ANGLE
    rate: float = RATE


def _assigned(name: str) -> re.Pattern[str]:
    return re.compile(rf"(\b{name} = )(-?[0-9.e-]+|{{)[^;]*;")


def value_of(file: str, name: str) -> str:
    """The constant's value as it stands in a C source of the planned controller; 1.0, a factor, of a structure.

    Raises InputError where there is no such constant.
    """
    match = _assigned(name).search(_source(_folder("controller_planned"), file).read_text("utf-8"))
    if match is None:
        raise InputError(f"{file}: expected a constant {name}, found none; remedy: correct evidence/sweep/constants.py")
    return match[2].replace("{", "1.0")


def _variable(file: str, name: str) -> str:
    return f"swept_{file.replace('.', '_')}_{name}"


def _opened(text: str, file: str, name: str) -> str:
    """The source with a variable in the constant's place; of a structure each use of a member is multiplied by it."""
    variable, kind = _variable(file, name), _kind(value_of(file, name))
    structure = re.search(rf"\b{name} = {{", text)
    use = "" if structure else f"#define {name} {variable}\n"
    text = _assigned(name).sub(rf"\g<0> extern {kind} {variable};\n{use}", text, count=1)
    return UNUSED + (re.sub(rf"\b{name}\.", f"{variable} * {name}.", text) if structure else text)


def _kind(value: str) -> str:
    return "int" if value.isdigit() else "double"


def built(folder: Path) -> ctypes.CDLL:
    """The loop, compiled into a new folder (a process loads one library of a path), with CONSTANTS as variables."""
    own = folder / "controller"
    shutil.copytree(_folder("controller_planned"), own, ignore=shutil.ignore_patterns("__pycache__"))
    variables = []
    for file, name in ((c.file, c.name) for c in CONSTANTS):
        value = value_of(file, name)
        variables.append(f'__attribute__((visibility("default"))) {_kind(value)} {_variable(file, name)} = {value};\n')
        source = _source(own, file)
        source.write_text(_opened(source.read_text("utf-8"), file, name), "utf-8")
    (folder / "variables.c").write_text("".join(variables), "utf-8")
    for block in BLOCKS.values():
        for name, text in generated_sources(Block.named(block).folder).items():
            (folder / name).write_text(text, "utf-8")
    natives = [own if block == "controller_planned" else _folder(block) for block in BLOCKS.values()]
    sources = [
        Path(__file__).with_name("loop.c"),
        *(path for native in natives for path in sorted(native.rglob("*.c"))),
    ]
    sources += sorted(folder.glob("*.c"))
    host = host_platform()
    path = folder / "loop.library"
    path.write_bytes(compile_library("loop", sources, [COMMON, folder, *natives], [host])[host])
    library = ctypes.CDLL(str(path))
    library.sweep_fly.restype = c_char_p
    return library


def put(library: ctypes.CDLL, file: str, name: str, value: str) -> None:
    """Gives the constant this value from now on."""
    if _kind(value_of(file, name)) == "int":
        c_int.in_dll(library, _variable(file, name)).value = int(value)
    else:
        c_double.in_dll(library, _variable(file, name)).value = float(value)


def _source(native: Path, name: str) -> Path:
    """The file of this name in the folder or below it. Raises InputError where there is none."""
    path = next(native.rglob(name), None)
    if path is None:
        raise InputError(f"{name}: no such file in {native}; remedy: correct evidence/sweep/constants.py")
    return path


def _folder(block: str) -> Path:
    return Block.named(block).folder / "native"


def tumbles_of(group: Group) -> list[Given]:
    """The parameters of each run, by place."""
    return [parameters({**group.scenario, "duration": UNTIL}, drawn) for drawn in group.drawn()]


def parameters(scenario: Data, *changes: Mapping[str, Any]) -> Given:
    """The parameters of the scenario with start values changed, by place. Raises InputError."""
    data: Data = copy.deepcopy(scenario)
    for each in changes:
        change(data, each)
    checked = load(Source(data))
    starts = resolve(checked, _models(tuple((name, b.fmu) for name, b in checked.blocks.items())))
    return {place: _values(block, starts[place]) for place, block in BLOCKS.items()}


@cache
def _models(fmus: tuple[tuple[str, str], ...]) -> dict[str, Model]:
    return {name: with_inputs(open_fmu(ensure(fmu, "native")), fmu) for name, fmu in fmus}


def _values(block: str, starts: list[Any]) -> dict[str, Any]:
    """Parameters as the structure takes them."""
    values: dict[str, Any] = {}
    variables = load_interface(block).variables
    for start in starts:
        name, position = start.element.variable, start.element.position
        if variables[name].shape:
            values.setdefault(name, np.array(variables[name].start, float)).flat[position] = start.value
        else:
            values[name] = start.value
    return values


def flown(library: ctypes.CDLL, flight: Flight) -> Flown:
    """The flight by the loop. Raises InputError for parameters that a block refuses."""
    given, failed = (_structures("parameter", each) for each in (flight.given, flight.failed or flight.given))
    wires = _structures("input", {place: {} for place in BLOCKS})
    course = Course(STEP, flight.until, QUIET, flight.angle, flight.rate, flight.hold, flight.fails, flight.frozen)
    told = Flown()
    refused = library.sweep_fly(*(_pointers(each) for each in (given, failed, wires)), byref(course), byref(told))
    if refused is not None:
        raise InputError(f"a block refuses {refused.decode()}; remedy: correct the scenario's start values")
    return told


def _structures(causality: Literal["parameter", "input"], given: Given) -> list[Any]:
    return [filled(block, causality, **given[place]) for place, block in BLOCKS.items()]


def _pointers(structures: Iterable[Any]) -> Any:
    return (c_void_p * len(BLOCKS))(*(ctypes.addressof(each) for each in structures))


def settled(library: ctypes.CDLL, tumble: Given) -> float:
    """Since when the tumble is within the angle and the rate of docs/evidence/flight.md, s; infinite where it does not settle."""
    return float(flown(library, Flight(tumble)).settled)
