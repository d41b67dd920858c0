"""A small block that has one of everything, for tests of what holds for every block: a leaky integrator with a hold."""

from __future__ import annotations

from pathlib import Path

from fmus.build import Block
from fmus.interface import parse

INTERFACE = """
[block]
name = "toy"
description = "Leaky integrator of a vector"

[experiment]
stop = 1.0
step = 0.1

[variables.rate]
causality = "input"
shape = [2]
unit = "m/s"
display_unit = "km/h"
description = "What is integrated"
start = [1.0, 2.0]

[variables.hold]
causality = "input"
type = "boolean"
description = "Keep the sum as it is"
start = false

[variables.sum]
causality = "output"
shape = [2]
unit = "m"
frame = "F"
description = "The integral"
initially_depends_on = ["offset"]

[variables.speed]
causality = "output"
unit = "m/s"
description = "Speed now, times gain"
depends_on = ["rate"]
initially_depends_on = ["rate", "gain"]

[variables.steps]
causality = "output"
type = "integer"
description = "Steps since the start"

[variables.holding]
causality = "output"
type = "boolean"
description = "Hold of the last step"
depends_on = ["hold"]
initially_depends_on = ["hold"]

[variables.mode_used]
causality = "output"
type = "enumeration"
items = ["leaky", "exact"]
description = "Mode in use"
initially_depends_on = ["mode"]

[variables.label_used]
causality = "output"
type = "string"
description = "Label in use"
initially_depends_on = ["label"]

[variables.first_rate]
causality = "output"
shape = [2]
unit = "m/s"
description = "Rate when initialization was left: latched"
initially_depends_on = ["rate"]

[variables.gain]
causality = "parameter"
variability = "tunable"
description = "Gain of speed"
start = 2.0
min = 0.0
max = 100.0

[variables.offset]
causality = "parameter"
variability = "fixed"
shape = [2, 1]
unit = "m"
description = "Initial sum"
start = [[0.5], [0.25]]

[variables.mode]
causality = "parameter"
variability = "fixed"
type = "enumeration"
items = ["leaky", "exact"]
description = "How to integrate"
start = "leaky"

[variables.label]
causality = "parameter"
variability = "fixed"
type = "string"
description = "Any text; 'wrong' is refused, 'fail' makes every step fail, 'tables' is replaced by the table's text"
start = "50 %s of nothing"

[variables.order]
causality = "parameter"
variability = "fixed"
type = "integer"
description = "A number"
start = 2
min = 1
max = 6
"""

_CODE = """
import math
from dataclasses import dataclass
import numpy as np
from . import helper, tables

@dataclass(frozen=True)
class Parameters:
    gain: float
    offset: np.ndarray
    mode: str
    label: str
    order: int

@dataclass(frozen=True)
class Inputs:
    rate: np.ndarray
    hold: bool

@dataclass(frozen=True)
class State:
    t: float
    sum: np.ndarray
    first_rate: np.ndarray
    held: np.ndarray | None
    steps: int
    holding: bool

@dataclass(frozen=True)
class Outputs:
    sum: np.ndarray
    speed: float
    steps: int
    holding: bool
    mode_used: str
    label_used: str
    first_rate: np.ndarray

def check(p):
    if p.label == "wrong":
        raise ValueError(f"label: expected anything but 'wrong', found {p.label!r}")

def start(p, u):
    return State(0.0, p.offset[:, 0].copy(), u.rate.copy(), None, 0, False)

def outputs(x, u, p):
    label = tables.read() if p.label == "tables" else p.label
    speed = helper.VERSION * p.gain * math.sqrt(u.rate @ u.rate)
    return Outputs(x.sum, speed, x.steps, bool(u.hold), p.mode, label, x.first_rate)

def step(x, u, p, h):
    if p.label == "fail":
        raise ValueError("rate: 100 % wrong \\udc80")
    if u.rate[0] > 1e6:
        return x, Outputs(x.sum * math.inf, 0.0, 0, False, p.mode, p.label, x.first_rate)
    if u.hold:
        s = x.sum
    elif p.mode == "exact":
        s = x.sum + u.rate * h
    else:
        s = x.sum * math.exp(-h / 3.0) + u.rate * h
    x = State(x.t + h, s, x.first_rate, u.rate / 3.0, x.steps + 1, bool(u.hold))
    return x, outputs(x, u, p)
"""
_TABLES = '''
from pathlib import Path
_FILE = Path(__file__).parent / "table.bin"
def dump():
    return {"table.bin": b"outside"}
def read():
    """Where the table comes from: read only when asked, as a block's tables may be."""
    return _FILE.read_bytes().decode() if _FILE.exists() else "package"
'''


def toy(folder: Path, version: int = 1) -> Block:
    """Writes the block's package into a folder. Its `speed` is proportional to the version."""
    package = folder / "toy"
    (package / "tables").mkdir(parents=True)
    names = "Inputs, Outputs, Parameters, State, check, outputs, start, step"
    (package / "__init__.py").write_text(f"from .block import {names}\n")
    (package / "block.py").write_text(_CODE)
    (package / "helper.py").write_text(f"VERSION = {version}\n")
    (package / "tables" / "__init__.py").write_text(_TABLES)
    return Block(parse(INTERFACE, "toy.toml"), package)
