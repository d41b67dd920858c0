"""Tumbles of docs/flight.md flown by the blocks' own C, with a constant of the planned controller replaced in its sources."""

from __future__ import annotations

import ctypes
import math
import re
import shutil
from ctypes import byref, c_char_p, c_double, c_void_p
from pathlib import Path
from typing import Any

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
from ..flight.schemes import change
from ..structures import filled

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

Given = dict[str, dict[str, Any]]


def _assigned(name: str) -> re.Pattern[str]:
    return re.compile(rf"(\b{name} = )(-?[0-9.e-]+)")


def value_of(file: str, name: str) -> str:
    """The constant's value as it stands in a C source of the planned controller. Raises InputError where it has none."""
    match = _assigned(name).search((_folder("controller_planned") / file).read_text("utf-8"))
    if match is None:
        raise InputError(f"{file}: expected a constant {name}, found none; remedy: correct studies/sweep/constants.py")
    return match[2]


def built(constant: tuple[str, str] | None, value: str, folder: Path) -> ctypes.CDLL:
    """The loop, compiled into a new folder (a process loads one library of a path); `constant` (file, name) has another value there."""
    own = folder / "controller"
    shutil.copytree(_folder("controller_planned"), own, ignore=shutil.ignore_patterns("__pycache__"))
    if constant is not None:
        file, name = constant
        text = (own / file).read_text("utf-8")
        (own / file).write_text(_assigned(name).sub(rf"\g<1>{value}", text, count=1), "utf-8")
    for block in BLOCKS.values():
        for name, text in generated_sources(Block.named(block).folder).items():
            (folder / name).write_text(text, "utf-8")
    natives = [own if block == "controller_planned" else _folder(block) for block in BLOCKS.values()]
    sources = [Path(__file__).with_name("loop.c"), *(path for native in natives for path in sorted(native.glob("*.c")))]
    sources += sorted(folder.glob("*.c"))
    host = host_platform()
    path = folder / "loop.library"
    path.write_bytes(compile_library("loop", sources, [COMMON, folder, *natives], [host])[host])
    library = ctypes.CDLL(str(path))
    library.sweep_fly.restype = c_char_p
    return library


def _folder(block: str) -> Path:
    return Block.named(block).folder / "native"


def tumbles_of(group: Group) -> list[Given]:
    """The parameters of each run, by place."""
    models: dict[str, Model] = {}
    found = []
    for drawn in group.drawn():
        scenario = load(Source(change({**group.scenario, "duration": UNTIL}, drawn)))
        if not models:
            models = {n: with_inputs(open_fmu(ensure(b.fmu, "native")), b.fmu) for n, b in scenario.blocks.items()}
        starts = resolve(scenario, models)
        found.append({place: _values(block, starts[place]) for place, block in BLOCKS.items()})
    return found


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


def settled(library: ctypes.CDLL, tumble: Given) -> float:
    """Since when the tumble is within the angle and the rate of docs/flight.md, s; infinite where it does not settle."""
    parameters = [filled(block, "parameter", **tumble[place]) for place, block in BLOCKS.items()]
    inputs = [filled(block, "input") for block in BLOCKS.values()]
    pointers = [(c_void_p * len(BLOCKS))(*(ctypes.addressof(x) for x in each)) for each in (parameters, inputs)]
    time = c_double()
    limits = (c_double(x) for x in (STEP, UNTIL, QUIET, ANGLE, RATE))
    refused = library.sweep_fly(*pointers, *limits, byref(time))
    if refused is not None:
        raise InputError(f"a block refuses {refused.decode()}; remedy: correct the scenario's start values")
    return float(time.value)
