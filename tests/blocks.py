"""Parameters and inputs of the blocks for tests: the interfaces' start values, with changes.

p = parameters("controller", reference="inertial", K0=[0.1, 0.2, 0.3])
u = inputs("controller", omega_B=[0.1, 0.0, 0.0])
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from fmus.build import Block
from fmus.interface import Variable, load, package_of

PYRAMID = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0]]) / np.sqrt(3.0)
"""Axes of four wheels, rows."""


def module(block: str) -> ModuleType:
    """The Python package of a block."""
    return import_module(package_of(block))


def folder(block: str) -> Path:
    """Where a block stands."""
    return Block.named(block).folder


def parameters(block: str, **changes: Any) -> Any:
    """The block's `Parameters` from the start values of its interface. Unchecked: call the block's `check`."""
    return _build(block, "parameter", "Parameters", changes)


def inputs(block: str, **changes: Any) -> Any:
    """The block's `Inputs` from the start values of its interface."""
    return _build(block, "input", "Inputs", changes)


def some(cases: Iterable[Any], *quick: Any) -> list[Any]:
    """Cases as a test's parameters, such as blocks: the quick ones in every run, the others in a thorough one."""
    return [case if case in quick else pytest.param(case, marks=pytest.mark.thorough) for case in cases]


def _build(block: str, causality: Any, record: str, changes: dict[str, Any]) -> Any:
    variables = {v.name: v for v in load(block).of(causality)}
    if unknown := sorted(set(changes) - set(variables)):
        raise TypeError(f"{block} has no {causality} {unknown[0]!r}; it has {', '.join(variables)}")
    values = {name: _value(v, changes.get(name, v.start)) for name, v in variables.items()}
    return getattr(module(block), record)(**values)


def _value(variable: Variable, value: Any) -> Any:
    if variable.shape:
        array = np.array(value, dtype=np.float64 if variable.type == "real" else None)
        if array.shape != variable.shape:
            raise TypeError(f"{variable.name}: expected the shape {variable.shape}, found {array.shape}")
        return array
    convert: Any = {"real": float, "integer": int, "boolean": bool}.get(variable.type, str)
    return convert(value)
