"""Finds the mapping that mends a swapped FMU which behaves as one of the wrong wirings, and confirms it.

Tests: tests/orchestration/acceptance/test_polarity.py.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...fmu.model import Floats
from ...quantities import parse, parse_unit
from ...scenario.mapping import Mapping as PortMapping
from ...scenario.mapping import PortMap
from ...scenario.references import Name
from ...scenario.source import Source
from ...scenario.text import written
from ...swap.findings import Fit
from .apart import apart, flown, inside
from .causes import Cause
from .fly import Found, Loop
from .identify import SAME
from .ports import Port
from .search import SECONDS, SMALL, identify
from .wrongs import RARE, USUAL, Wrong, left_handed, wrongs

_FACTOR = 1e-6
"""How near a factor has to be to that of a usual unit."""


@dataclass(frozen=True)
class Mended:
    """The wrong wiring as which a swapped FMU behaves, and the mapping that mends it."""

    block: str
    behaves: dict[str, str]
    """By port of ours: the wrong wiring that theirs behaves as; empty where none leaves a small difference only."""
    mapping: dict[str, Any]
    """As data for `map:`."""
    before: float
    after: float
    """Difference from ours on the same inputs, as a share: as wired, and with what is named taken out."""
    left: Found | None
    """The first that the loop does not meet with it; None where all is met."""
    complete: bool
    causes: tuple[Cause, ...] = ()
    """What else differs; empty where nothing leaves a small difference."""
    first: tuple[str, float] | None = None
    """The output that differs first, and when, s."""
    equally: tuple[str, ...] = ()
    """Other wirings that serve as well, in words."""

    @property
    def named(self) -> bool:
        """Returns whether anything explains the difference."""
        return bool(self.behaves or self.causes)


def mend(ours: Source, theirs: Source, block: str, seconds: float = SECONDS) -> Mended:
    """Looks for the mapping of a swapped block under which it does what ours does; for wirings so many seconds.

    Raises InputError and BlockError.
    """
    found = apart(theirs, identify, ours, inside(theirs), block, seconds)
    loop = Loop(theirs)
    fit = loop.opened.prepared.fits[block]
    present = fit.mapping or PortMapping()
    data = present.model_dump(exclude_none=True, exclude_defaults=True)
    data["ports"] = {name: _data(entry) for name, entry in present.ports.items()}
    behaves: dict[str, str] = {}
    given = {**data, "ports": dict(data["ports"])}
    likely = found.named or found.likely
    explained = (("input", found.inputs), ("output", found.outputs)) if likely else ()
    for causality, changes in explained:
        for name, wrong in changes.items():
            said = wrong.name if causality == "input" else named(found.ports[name], wrong)
            behaves[name] = said + _handed(fit, name, wrong)
            entry = present.ports.get(name) or PortMap(theirs=[Name(name)], inverse=False)
            declared = fit.links[name].theirs[0]
            unit = fit.theirs.variables[declared.variable].at([declared.position]).unit
            factor = unit.factor if unit is not None and unit.exponents is not None else found.ports[name].unit.factor
            data["ports"][name] = _mended(entry, found.ports[name], wrong, factor)
    left = None
    if behaves:
        left, _ = flown(theirs.with_entry(("blocks", block, "map"), data))
    if not found.named and left is not None:  # only a loop that meets all confirms it
        behaves, data, left = {}, given, None
    others = found.equally if found.named else ()
    words = [", ".join(f"{n}: {w.name}{_handed(fit, n, w)}" for n, w in other.items()) for other in others]
    causes = found.causes if found.named else ()
    return Mended(
        block, behaves, data, found.before, found.after, left, found.complete, causes, found.first, tuple(words)
    )


def _handed(fit: Fit, name: str, wrong: Wrong) -> str:
    return " (left-handed)" if left_handed(wrong) and fit.links[name].ours.frame not in (None, "", "rods") else ""


def named(port: Port, change: Wrong) -> str:
    """Returns the wrong wiring that a change undoes, by its name in the tables."""
    if change.matrix is None:
        return change.name
    undone = np.linalg.inv(change.matrix)
    known = (w for w in wrongs(port, True) if w.matrix is not None and np.allclose(w.matrix, undone, rtol=_FACTOR))
    return next((w.name for w in known), change.name)


def _data(entry: PortMap) -> dict[str, Any]:
    kept = entry.model_dump(exclude_none=True, exclude_defaults=True)
    names = [str(name) for name in entry.theirs]
    return kept | {"theirs": names[0] if len(names) == 1 else names}


def _mended(entry: PortMap, port: Port, change: Wrong, declared: float) -> dict[str, Any]:
    """Returns the entry of a port with a change in it: of what is handed to theirs, or of an output of theirs."""
    data = _data(entry)
    if entry.quaternion is not None:
        return data | _quaternion(entry, change)
    if entry.rotation is not None:
        return data | {"inverse": not entry.inverse}
    if change.along is not None:
        data = {key: value for key, value in data.items() if key not in ("turn", "inverse")}
        return data if entry.turn is not None else data | {"turn": change.along[0], "inverse": not change.along[1]}
    assert change.matrix is not None
    matrix = np.linalg.inv(change.matrix)  # what is handed over, or what they give for ours
    size = float(np.abs(matrix).max())
    matrix = np.round(matrix / size)
    if abs(size - 1.0) > _FACTOR:
        data = _with_factor(data, size, port, declared)
    if len(matrix) == 1:
        return _with_sign(data) if matrix[0, 0] < 0.0 else data
    before = np.eye(len(matrix)) if entry.matrix is None else np.array(entry.matrix, float)
    product: Floats = before @ matrix
    if np.array_equal(product, np.eye(len(product))) and len(entry.theirs) > 1:
        data.pop("matrix", None)
    elif not np.array_equal(matrix, np.eye(len(matrix))):
        data["matrix"] = [[_whole(x) for x in row] for row in product.tolist()]
    return data


def _quaternion(entry: PortMap, change: Wrong) -> dict[str, Any]:
    order = entry.quaternion
    inverse = entry.inverse
    if change.turn is None:
        inverse = not inverse
    else:
        order = "scalar last" if order == "scalar first" else "scalar first"
        inverse = inverse != (change.turn[1] != change.turn[0].startswith("inverse"))
    return {"quaternion": order, "inverse": inverse}


def _with_factor(data: dict[str, Any], size: float, port: Port, declared: float) -> dict[str, Any]:
    """Returns the entry with another unit of theirs, where a usual one has the factor; else with a scale."""
    wanted = (parse_unit(data["unit"]).factor if "unit" in data else declared) / size
    for family in (*USUAL, *RARE):
        for name in family:
            unit = parse_unit(name)
            if (
                unit.exponents == port.unit.exponents
                and abs(unit.factor / wanted - 1.0) < _FACTOR
                and "divide" not in data
            ):
                return data | {"unit": name}
    if "divide" in data:
        return data | {"divide": _times(data["divide"], 1.0 / size)}
    return data | {"scale": _times(data.get("scale", 1), size)}


def _with_sign(data: dict[str, Any]) -> dict[str, Any]:
    key = "divide" if "divide" in data else "scale"
    return data | {key: _times(data.get(key, 1), -1.0)}


def _times(value: Any, by: float) -> Any:
    """Returns a factor times a number, with its unit."""
    if isinstance(value, str):
        number, unit = parse(value)
        return f"{number * by:.10g} {unit}" if unit is not None else number * by
    return _whole(value * by)


def _whole(x: float) -> float:
    return int(x) if float(x).is_integer() else x


def as_yaml(mapping: Mapping[str, Any]) -> str:
    """Returns a mapping as YAML, an entry a line."""
    ports = {name: e["theirs"] if set(e) == {"theirs"} else e for name, e in mapping.get("ports", {}).items()}
    lines = ["ports:" if ports else "ports: {}"]
    lines += [f"  {name}: {written(entry, flow=True)}" for name, entry in ports.items()]
    rest = {key: mapping[key] for key in ("inputs", "start", "ignore") if mapping.get(key)}
    return "\n".join([*lines, *(f"{key}: {written(value, flow=True)}" for key, value in rest.items())]) + "\n"


def in_words(mended: Mended) -> list[str]:
    """Returns what explains how theirs differs from ours, or else how it differs; nothing where it does not."""
    if not math.isfinite(mended.before):
        return [f"{mended.block}: on the inputs that ours has in its run it fails, or an output is not finite"]
    if mended.before <= SAME:
        return []
    differs = f"{mended.block}: on the same inputs its outputs differ by {100 * mended.before:.3g} % of ours"
    if mended.before >= 1.0:
        differs += " (an output counts with 200 % at most)"
    if mended.first is not None:
        differs += f", {mended.first[0]} first by more than 1 % of its largest, at {mended.first[1]:.5g} s"
    if not mended.named:
        no = "no sign, axis, unit, attitude or other cause, alone or in the pairs that were tried, explains that"
        if mended.after <= SMALL:
            no = "several things together would explain that, and others could as well"
        return [f"{differs}; {no}: the best leaves {100 * mended.after:.3g} %, so none is named"]
    lines = [f"{differs}; with what follows taken out, by {100 * mended.after:.2g} %"]
    if mended.after > SMALL:
        lines[0] += ", which nothing explains; the loop with the mapping meets all expectations and checks"
    if mended.behaves:
        lines.append(f"{mended.block} behaves as wired wrongly:")
        lines += [f"  {port}: {wrong}" for port, wrong in mended.behaves.items()]
    lines += [f"  or equally well: {other}" for other in mended.equally]
    if mended.causes:
        lines.append(f"{mended.block} differs" + (" also:" if mended.behaves else ":"))
        lines += [f"  {cause}; that leaves {100 * cause.left:.2g} %" for cause in mended.causes]
    return lines


def summary(mended: Mended) -> dict[str, Any]:
    """Returns all of it as plain data."""
    return {
        "block": mended.block,
        "behaves_as": mended.behaves,
        "causes": [asdict(cause) for cause in mended.causes],
        "equally": list(mended.equally),
        "differs_first": None if mended.first is None else {"output": mended.first[0], "time": mended.first[1]},
        "map": mended.mapping,
        "difference_as_wired": mended.before if math.isfinite(mended.before) else None,
        "difference_as_mended": mended.after if math.isfinite(mended.after) else None,
        "mends": bool(mended.behaves) and mended.left is None,
    }
