"""A scenario of the paper's three blocks as the blocks' own parameters, with its errors located.
Tests: tests/design/test_momentum.py."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import allocator
import controller
import plant
from fmus.build import BuildError, ensure
from fmus.interface import load
from orchestration import InputError, Scenario
from orchestration import load as load_scenario
from orchestration.fmu.archive import open_fmu
from orchestration.fmu.interfaces import with_inputs
from orchestration.fmu.model import Model
from orchestration.scenario.source import Source
from orchestration.system.starts import resolve

BLOCKS: dict[str, Any] = {"plant": plant, "controller": controller, "allocator": allocator}
"""The blocks of the paper's loop by their names."""
JUDGE = "plant_judge"
"""The block outside the loop by which runs are judged."""


@dataclass(frozen=True)
class Loop:
    """Parameters of a closed loop."""

    plant: plant.Parameters
    controller: controller.Parameters
    allocator: allocator.Parameters

    def change(self, changes: Mapping[str, Any]) -> Loop:
        """The same with parameters changed, by `block.parameter`."""
        blocks: dict[str, dict[str, Any]] = {}
        for name, value in changes.items():
            block, _, parameter = name.partition(".")
            blocks.setdefault(block, {})[parameter] = (
                np.asarray(value, np.float64) if isinstance(value, (list, tuple)) else value
            )
        return replace(self, **{block: replace(getattr(self, block), **new) for block, new in blocks.items()})


@dataclass(frozen=True)
class Setup:
    """A scenario, the names its blocks go by, and the loop it stands for."""

    scenario: Scenario
    names: Mapping[str, str]
    """Name in the scenario of each of the project's blocks."""
    loop: Loop

    def error(self, block: str, parameter: str, message: str) -> InputError:
        """An error that names the place of a parameter in the scenario."""
        name = self.names[block]
        key: tuple[str, ...] = ("blocks", name, "start", parameter)
        if parameter not in self.scenario.blocks[name].start and parameter in self.scenario.shared:
            key = ("shared", parameter)
        elif parameter not in self.scenario.blocks[name].start:
            key, message = key[:2], f"{parameter}: {message}"
        return InputError(self.scenario.error(key, message))


def read(scenario: str | Path | Source, overrides: Mapping[str, Any] | None = None) -> Setup:
    """Returns the loop of a scenario. Raises InputError, with file and line, for whatever is wrong with it."""
    loaded = load_scenario(scenario, overrides)
    names = {entry.fmu: name for name, entry in loaded.blocks.items() if entry.fmu in BLOCKS}
    if missing := [block for block in BLOCKS if block not in names]:
        raise InputError(loaded.error(("blocks",), f"expected a block with 'fmu: {missing[0]}', found none"))
    strange = [name for name, entry in loaded.blocks.items() if entry.fmu not in (*BLOCKS, JUDGE)]
    if strange:
        found = loaded.blocks[strange[0]].fmu
        raise InputError(
            loaded.error(("blocks", strange[0], "fmu"), f"expected one of {', '.join(BLOCKS)}, found {found!r}")
        )
    models = {name: _model(block, loaded.blocks[name].flavour or loaded.flavour) for block, name in names.items()}
    starts = resolve(loaded, models)
    parts = {}
    for block, name in names.items():
        given = {(s.element.variable, s.element.position): s.value for s in starts[name]}
        parts[block] = parameters(block, given, BLOCKS[block])
    setup = Setup(loaded, names, Loop(**parts))
    for block in BLOCKS:
        try:
            BLOCKS[block].check(parts[block])
        except ValueError as error:
            raise InputError(loaded.error(("blocks", names[block], "start"), str(error))) from None
    return setup


@cache
def _model(block: str, flavour: str) -> Model:
    try:
        return with_inputs(open_fmu(ensure(block, flavour)).model, block)
    except BuildError as error:
        raise InputError(f"the block {block!r} cannot be built: {error}") from None


def parameters(block: str, given: Mapping[tuple[str, int], Any], package: Any) -> Any:
    """Returns the Parameters, of the package, of a block: what is given over the interface's start values."""
    values = {}
    for v in load(block).of("parameter"):
        value = np.array(v.start) if v.shape else v.start
        for (name, position), new in given.items():
            if name != v.name:
                continue
            if v.type == "enumeration":
                new = v.items[int(new) - 1]
            if v.shape:
                value.flat[position] = new
            else:
                value = new
        convert: Any = {"real": float, "integer": int, "boolean": bool}.get(v.type, str)
        values[v.name] = np.asarray(value, np.float64) if v.shape else convert(value)
    return package.Parameters(**values)
