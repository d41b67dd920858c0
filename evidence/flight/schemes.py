"""The scenarios of docs/evidence/flight.md as data: scenarios/flight_*.yaml with other start values, and other blocks
in the same places. Tests: tests/evidence/flight/test_flight.py."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fmus.build import Block, ensure
from fmus.interface import Interface, load, parse
from orchestration.session.read import read

from ..paper import ROOT, constants

Data = dict[str, Any]

TUNED = {"K0": [5.53e-3, 6.14e-3, 6.75e-3], "L0": (0.273 * np.eye(3)).tolist()}
"""Gains of law [8] in SI units with the bounded allocator: the best of 60 drawn at random, by tumbles that nothing
else flies."""
RIVAL = {"slow": 0.035, "K": 6.1e-4, "L": 0.069, "detumble_gain": 280.0, "look_ahead": 118.0}
"""Of evidence/flight/rival: the best of a random search on tumbles that nothing else flies (docs/evidence/rival.md)."""


@cache
def _text(scenario: str) -> str:
    return json.dumps(read(ROOT / "scenarios" / f"{scenario}.yaml").data)


def base(scenario: str = "tumble") -> Data:
    """A flight scenario as data that expects and draws nothing."""
    return base_of(f"flight_{scenario}")


def base_of(scenario: str) -> Data:
    """The same of any scenario of the project."""
    data: Data = json.loads(_text(scenario))
    for key in ("expect", "figures", "phases"):
        data.pop(key, None)
    data["record"] = {"interval": 1.0}
    return data


def change(data: Data, changes: Mapping[str, Any]) -> Data:
    """Start values by `block.parameter`, set in place."""
    for name, value in changes.items():
        block, _, parameter = name.partition(".")
        data["blocks"][block].setdefault("start", {})[parameter] = (
            value.tolist() if isinstance(value, np.ndarray) else value
        )
    return data


NO_ERRORS: dict[str, Any] = {
    "plant.J_error_B": np.zeros((3, 3)),
    "plant.rod_gain": [1.0, 1.0, 1.0],
    "sensors.attitude_noise": 0.0,
    "sensors.rate_noise": 0.0,
    "sensors.field_noise": 0.0,
    "controller.field_error": [0.0, 0.0, 0.0],
}


def without(data: Data, *targets: str) -> Data:
    """Takes out the connections to these inputs, `block.input` with all its elements; in place."""
    data["connections"] = [
        c for c in data["connections"] if c.split("->")[1].strip().partition("[")[0] not in set(targets)
    ]
    return data


def fit(data: Data, block: str, fmu: str, every: int | None = None, interface: Interface | None = None) -> Data:
    """Puts another block in a block's place, with the connections that both ends have; in place.

    `fmu`: the name of one of the project's blocks, or a file with this interface.
    """
    entry = {"fmu": fmu, "every": every or data["blocks"][block]["every"]}
    given = load(fmu) if interface is None else interface
    ports = {v.name for v in given.variables.values() if v.causality != "parameter"}
    known = {v.name for v in given.of("parameter")}
    entry["start"] = {k: v for k, v in data["blocks"][block].get("start", {}).items() if k in known}
    data["blocks"][block] = entry

    def there(end: str) -> bool:
        owner, _, port = end.strip().partition("[")[0].partition(".")
        return owner != block or port in ports

    data["connections"] = [c for c in data["connections"] if all(map(there, c.split("->")))]
    return data


def papers(data: Data) -> Data:
    """The paper's scheme with its gains in SI units, at 10 Hz as in its reproduction."""
    fit(data, "controller", "controller", 1)
    fit(data, "allocator", "allocator", 1)
    data["blocks"]["sensors"]["every"] = 1
    gains = {k: v for k, v in constants(mass=1.0).items() if k in ("controller.K0", "controller.L0")}
    return change(data, {"allocator.hold_fraction": 0.8} | gains)


def tuned(data: Data, gains: Mapping[str, Any] = TUNED) -> Data:
    """Law [8] with gains tuned for SI units and the bounded allocator without feed-forward."""
    fit(data, "controller", "controller")
    return change(data, {f"controller.{k}": v for k, v in gains.items()})


def literature(data: Data, gains: Mapping[str, Any] = RIVAL) -> Data:
    """Detumbling of arXiv 2407.02724 and a proportional-derivative law (evidence/flight/rival), with the bounded
    allocator."""
    folder = Path(__file__).parent / "rival"
    block = Block(parse((folder / "interface.toml").read_text("utf-8"), "interface.toml"), folder)
    fit(data, "controller", str(ensure(block, "python")), interface=block.interface)
    data["blocks"]["controller"]["isolation"] = "none"
    return change(data, {f"controller.{k}": v for k, v in gains.items()})


SCHEMES: dict[str, Callable[[Data], Data]] = {
    "planned": lambda data: data,
    "tuned": tuned,
    "paper": papers,
    "literature": literature,
}
