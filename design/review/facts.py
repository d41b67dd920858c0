"""The scenario that is reviewed, as the review needs it: its satellite, blocks by kind, and start values in force."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from orchestration import InputError, Scenario
from orchestration.session.open import open_scenario
from orchestration.session.read import load, read
from plant.so3 import Array

from ..plausible import NONE, PLANTS, Satellite, satellite

ONE = {f"{block}_wheels": block for block in ("plant_sensors", "estimator")}
"""Blocks for a set of wheels by the kind that they count as."""
GOAL = math.radians(5.0)
"""Of the hold, where no expectation states one."""


@dataclass(frozen=True)
class Facts:
    file: Path
    scenario: Scenario
    satellite: Satellite
    blocks: Mapping[str, str]
    """Names in the scenario by kind of block; a judge that is given its reference is `estimate_judge`."""
    starts: Mapping[str, Mapping[str, Array]]
    """By kind and variable the start values that are stated, in SI units."""

    @property
    def plant(self) -> str:
        return next(self.blocks[kind] for kind in PLANTS if kind in self.blocks)

    @property
    def controller(self) -> str:
        """The kind of the controller, such as controller_planned, or with its file for a law in Python; or ""."""
        return next((kind for kind in self.blocks if kind.startswith("controller")), "")

    @property
    def wheels(self) -> list[int]:
        """Places of the wheels; one of next to nothing is none."""
        return [i for i, wheel in enumerate(self.satellite.p.wheel_list) if wheel.momentum_max > NONE]

    @property
    def goal(self) -> float:
        """rad"""
        return self.satellite.goal or GOAL

    @cached_property
    def period(self) -> float:
        """s"""
        p = self.satellite.p
        return 2.0 * math.pi * math.sqrt(p.orbit.semi_major_axis**3 / p.gravitational_parameter)

    @property
    def R_d0(self) -> Array:
        """(3,3): the attitude that is held, relative to LVLH."""
        return self.start("plant_judge", "R_d0", np.eye(3)).reshape(3, 3)

    def start(self, kind: str, name: str, default: Array) -> Array:
        """Returns a start value that is stated, or the default."""
        return self.starts.get(kind, {}).get(name, default)

    def size(self, kind: str, name: str) -> float:
        """Returns the norm of a start value; zero where it is not stated."""
        return float(np.linalg.norm(self.start(kind, name, np.zeros(1))))


def facts(file: Path, mass: float | None) -> Facts:
    """Returns what is known of a scenario's file. Raises InputError where there is no satellite to review."""
    scenario = load(read(file))
    sat = satellite(scenario, mass)
    opened = open_scenario(scenario)
    blocks: dict[str, str] = {}
    fed = {c.target.block for c in scenario.connections if c.target.variable == "R_d"}
    for name, entry in scenario.blocks.items():
        kind = entry.fmu or entry.interface or "law"
        if entry.python and (kind.startswith("controller") or name == "controller"):
            kind = f"controller law {Path(str(entry.python)).name}"  # of which no more is known than of any law
        kind = ONE.get(kind, kind)
        blocks.setdefault("estimate_judge" if kind == "plant_judge" and name in fed else kind, name)
    if "plant_judge" not in blocks:
        raise InputError(
            scenario.error(("blocks",), "expected a block with 'fmu: plant_judge' that judges the plant, found none")
        )
    starts: dict[str, dict[str, Array]] = {}
    for kind, name in blocks.items():
        found: dict[str, dict[int, Any]] = {}
        for start in opened.plan.starts[name]:
            found.setdefault(start.element.variable, {})[start.element.position] = start.value
        starts[kind] = {
            variable: np.array([elements[i] for i in sorted(elements)])
            for variable, elements in found.items()
            if not any(isinstance(value, str) for value in elements.values())
        }
    return Facts(file, scenario, sat, blocks, starts)
