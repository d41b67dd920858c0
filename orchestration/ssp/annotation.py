"""Our annotation in an SSP archive: what a scenario says beyond components, connections and values.

An archive comes from anywhere. So its annotation says what is simulated and judged, and never how an FMU is guarded
(isolation, timeout, memory, validation) nor anything that names a file (FMUs, mappings, interfaces).
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..errors import InputError, as_written, hint
from ..fmu.zipped import shown
from .words import ANNOTATION, NAMESPACES

KEYS = (
    *("name", "description", "step", "duration", "exchange", "delays", "record"),
    *("expect", "holds", "consistency", "faults", "timeline", "phases", "figures", "cycle", "data"),
)
"""What it may say of the scenario."""
BLOCK_KEYS = ("every",)
"""What it may say of a block."""


def annotation(path: Path, root: Any, blocks: Iterable[str]) -> dict[str, Any]:
    """Returns what it says, with an entry `blocks`; nothing where there is none. Raises InputError."""
    places = ("ssd:System/ssd:Annotations/ssc:Annotation", "ssd:Annotations/ssc:Annotation")
    entries = (entry for place in places for entry in root.findall(place, NAMESPACES))
    entry = next((entry for entry in entries if entry.get("type") == ANNOTATION), None)
    if entry is None:
        return {}
    where = f"{shown(path)}: the annotation {ANNOTATION}"
    try:
        data = json.loads("".join(entry.itertext()))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where} cannot be read: {error}") from None
    if not isinstance(data, dict):
        raise InputError(f"{where}: expected names with values, found {as_written(data)}")
    own = data.get("blocks", {})
    _check_keys(where, {key: value for key, value in data.items() if key != "blocks"}, KEYS)
    if not isinstance(own, dict):
        raise InputError(f"{where}: blocks: expected names with values, found {as_written(own)}")
    known = list(blocks)
    for name, values in own.items():
        if name not in known:
            raise InputError(f"{where}: blocks: the archive has no component {name!r}{hint(name, known)}")
        if not isinstance(values, dict):
            raise InputError(f"{where}: blocks.{name}: expected names with values, found {as_written(values)}")
        _check_keys(f"{where}: blocks.{name}", values, BLOCK_KEYS)
    return data


def _check_keys(where: str, data: dict[str, Any], allowed: tuple[str, ...]) -> None:
    for key in data:
        if key not in allowed:
            raise InputError(
                f"{where} says {key!r}, which an archive does not decide; expected one of {', '.join(allowed)}"
            )
