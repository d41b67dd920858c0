"""Parameters that a law in Python states itself: `PARAMETERS = {"gain": 0.05}` in its file, beside those of its ports.

The text is looked at and not run, since a scenario is checked without running what it flies.
Tests: tests/orchestration/instances/test_own_parameters.py.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..fmu.model import Model, Variable

NAME = "PARAMETERS"
SUFFIX = ".py"


def with_own(model: Model, path: Path) -> Model:
    """Returns the model with the parameters that the law's file states, whose values are their start values.

    Raises InputError with file and line where one is no number or array of numbers, or has the name of a port.
    """
    variables, starts = dict(model.variables), dict(model.starts)
    for name, (value, line) in _stated(path).items():
        array = np.asarray(value, np.float64)
        if name in variables:
            raise InputError(f"{path}:{line}: {NAME}: {name!r} is a port of {model.name}; expected another name")
        shape = tuple(array.shape)
        variable = Variable(name, "parameter", shape=shape, references=(0,) * array.size, variability="tunable")
        variables[name] = replace(variable, description=f"stated in {path.name}")
        starts |= dict(zip(variable.elements, array.ravel().tolist(), strict=True))
    return replace(model, variables=variables, starts=starts)


def _stated(path: Path) -> Mapping[str, tuple[Any, int]]:
    """Returns values and lines by name; nothing of a file that cannot be read, of which the law itself tells."""
    try:
        tree = ast.parse(path.read_text("utf-8"))
    except (OSError, SyntaxError, ValueError):
        return {}
    found: dict[str, tuple[Any, int]] = {}
    for node in tree.body:
        if not (isinstance(node, ast.Assign) and [ast.unparse(target) for target in node.targets] == [NAME]):
            continue
        if not isinstance(node.value, ast.Dict):
            raise InputError(f"{path}:{node.lineno}: {NAME}: expected names with numbers, such as {{'gain': 0.05}}")
        for key, value in zip(node.value.keys, node.value.values, strict=True):
            try:
                name, number = ast.literal_eval(key) if key else None, ast.literal_eval(value)
                if not isinstance(name, str) or not name.isidentifier():
                    raise ValueError
                np.asarray(number, np.float64)
            except (ValueError, TypeError, SyntaxError):
                text = "expected a name with a number or lists of numbers"
                raise InputError(f"{path}:{value.lineno}: {NAME}: {text}, found {ast.unparse(value)}") from None
            found[name] = number, value.lineno
    return found


def refuse_missing(path: Path, text: str) -> None:
    """Raises InputError where there is no such file of Python."""
    if path.suffix != SUFFIX:
        raise InputError(f"expected the path of a .py file, found {text}")
    if not path.is_file():
        raise InputError(f"there is no file {text}")
