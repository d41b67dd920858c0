"""Tells what a block is, as plain data: its ports and parameters, and what its FMU says of itself.

Tests: tests/orchestration/cli/test_info.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fmus.interface import ABSENT, ABSENT_INTEGER, citations, load

from ..errors import InputError, hint
from ..fmu import zipped
from ..fmu.archive import examined, platforms
from ..fmu.interfaces import helpers, is_path, own, reference
from ..fmu.model import Element, Variable
from ..paths import located
from ..system.values import nested

HELPER = "helper"
"""The causality of an input that only scenarios have: it stands for start values."""
_CAPABILITIES = {
    "canHandleVariableCommunicationStepSize": "variable steps",
    "canInterpolateInputs": "interpolates inputs",
    "canGetAndSetFMUstate": "saves its state",
    "canSerializeFMUstate": "serializes its state",
    "providesDirectionalDerivative": "directional derivatives",
    "canBeInstantiatedOnlyOncePerProcess": "one instance in a process",
    "needsExecutionTool": "needs its tool",
}


def facts(name: str, lenient: bool = False) -> dict[str, Any]:
    """Returns what a block of the project or an FMU is, ready for JSON; nothing of it is run. Raises InputError."""
    if is_path(name):
        return _of_file(located(name).resolve(), lenient)
    if name not in own():
        remedy = (
            "; orchestrate validate says what a scenario is" if Path(name).suffix in (".yaml", ".yml", ".ssp") else ""
        )
        raise InputError(f"there is no block {name!r}{remedy or hint(name, own())}; the path of an FMU ends in .fmu")
    interface, declared = reference(name, Path()), load(name)
    variables = [*interface.model.variables.values(), *(helper.variable for helper in helpers(name).values())]
    return {
        "name": name,
        "kind": "block of this project",
        "description": declared.description,
        "flavours": list(declared.flavours),
        "experiment": {"start": 0.0, "stop": declared.stop, "step": declared.step},
        "equations": [{"equation": equation, "meaning": meaning} for equation, meaning in declared.equations],
        "limits": list(declared.limits),
        "citations": citations(declared),
        "variables": [
            {**_variable(v, interface.starts), **({"causality": HELPER} if v.name in helpers(name) else {})}
            for v in variables
        ],
    }


def _of_file(path: Path, lenient: bool) -> dict[str, Any]:
    fmu = examined(path, lenient)
    said = fmu.description
    experiment = said.defaultExperiment
    times = {"start": "startTime", "stop": "stopTime", "step": "stepSize", "tolerance": "tolerance"}
    return {
        "name": fmu.model.name,
        "kind": f"FMI {said.fmiVersion} FMU for co-simulation",
        "description": said.description or "",
        "file": str(zipped.shown(path)),
        "bytes": path.stat().st_size,
        "sha256": fmu.sha256,
        "guid": fmu.model.guid,
        "generation_tool": fmu.model.tool,
        "author": said.author or "",
        "version": said.version or "",
        "license": said.license or "",
        "platforms": platforms(zipped.names(path, "FMU")),
        "capabilities": [text for key, text in _CAPABILITIES.items() if getattr(said.coSimulation, key, False)],
        "experiment": {key: _time(getattr(experiment, name, None)) for key, name in times.items()},
        "not_valid": list(fmu.problems),
        "variables": [_variable(v, fmu.model.starts) for v in fmu.model.variables.values()],
    }


def _variable(variable: Variable, starts: Mapping[Element, Any]) -> dict[str, Any]:
    values = [starts[element] for element in variable.elements if element in starts]
    items = {number: item for item, number in variable.items}
    if variable.type == "enumeration":
        values = [items.get(value, value) for value in values]
    absent = variable.optional and values in ([ABSENT] * variable.size, [ABSENT_INTEGER] * variable.size)
    return {
        "name": variable.name,
        "causality": variable.causality,
        "variability": variable.variability,
        "type": variable.type,
        "shape": list(variable.shape),
        "unit": str(variable.unit) if variable.unit is not None else None,
        "display_unit": str(variable.display_unit) if variable.display_unit is not None else None,
        "frame": variable.frame,
        "start": nested(variable, list(map(_finite, values))) if len(values) == variable.size and not absent else None,
        "min": _limit(variable.minima),
        "max": _limit(variable.maxima),
        "items": list(items.values()),
        "optional": variable.optional,
        "quantity": variable.quantity,
        "description": variable.description,
    }


def _limit(limits: Sequence[float]) -> float | list[float | None] | None:
    """Returns the limit of all elements, or, where they differ, of each; None where there is none."""
    each = [limit if math.isfinite(limit) else None for limit in limits]
    return each[0] if len(set(each)) == 1 else each or None


def _finite(value: Any) -> Any:
    """Returns a value that JSON knows: a number that is not finite as text."""
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def _time(text: str | None) -> float | str | None:
    """Returns a time in s, which FMPy leaves as text."""
    try:
        return None if text is None else _finite(float(text))
    except ValueError:
        return text
