"""A scenario's faults and timeline as tables in C, for loop.c and changes.c."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from ..fmu.model import Element
from ..session.plan import Plan
from ..system.disturbances import Disturbance
from ..system.faults import Faults, Setting
from ..system.wiring import Node
from .c_text import Text, fields


class Places(Protocol):
    """Places in the tables that these join."""

    c: Text

    @property
    def seats(self) -> Mapping[str, int]: ...

    def place_of(self, node: Node) -> int: ...

    def moves(self, verb: str, block: str, places: Mapping[Element, int], values: str) -> list[str]: ...


def write_faults(plan: Plan, on: Places, faults: Sequence[Faults]) -> None:
    """The tables of all faults; each with its number, behind which the timeline has the last one."""
    disturbances = [(i, d) for i, each in enumerate(faults) for d in each.disturbances]
    on.c.define("static Disturbance disturbances", [_disturbance(plan, on, d) for _, d in disturbances])
    on.c.define("const size_t fault_of", [str(i) for i, _ in disturbances] or ["0"])
    spans = [f"{{{d.span[0]}, {_count(d.span[1])}}}" for _, d in disturbances]
    on.c.lines.append(f"const int64_t spans[][2] = {{{', '.join(spans) or '{0, 0}'}}};")
    given = [(len(faults), setting) for setting in plan.faults.settings if not setting.of_fault]
    _changes(plan, on, [*((i, setting) for i, each in enumerate(faults) for setting in each.settings), *given])
    on.c.lines.append(f"int32_t acting[{len(faults) + 1}] = {{[{len(faults)}] = 1}};")
    on.c.lines.append(f"int32_t shifted[{len(faults) + 1}];")


def _count(count: float) -> str:
    return "INT64_MAX" if count == math.inf else str(int(count))


def _disturbance(plan: Plan, on: Places, fault: Disturbance) -> str:
    entries = {
        "behind": fault.behind(plan.scenario.exchange == "parallel", on.seats),
        "value": float(fault.value),
        "seat": on.seats[fault.target.block],
        "place": on.place_of(fault.target),
        "kind": f"FAULT_{fault.kind.upper()}",
    }
    return fields(entries)


def _changes(plan: Plan, on: Places, settings: Sequence[tuple[int, Setting]]) -> None:
    """The begins and ends of settings; each with its fault's number."""
    nodes = dict.fromkeys(Node(s.block, element) for _, s in settings for element, _ in s.values)
    numbers = {node: number for number, node in enumerate(nodes)}
    for name in ("before", "sound", "given"):
        on.c.lines.append(f"double element_{name}[{max(1, len(numbers))}];")
    changes = []
    for place, (fault, setting) in enumerate(settings):
        block = setting.block
        mine = {element: numbers[Node(block, element)] for element, _ in setting.values}
        shared = {
            "every": plan.scenario.blocks[block].every,
            "setting": place,
            "fault": fault,
            "seat": on.seats[block],
            "elements": on.c.array("size_t", mine.values()),
            "values": on.c.array("double", (float(value) for _, value in setting.values)),
            "value_count": len(mine),
            **_listed(on.c, "get", on.moves("Get", block, mine, "element_before") if setting.of_fault else []),
            **_listed(on.c, "set", on.moves("Set", block, mine, "element_given")),
        }
        begin, end = setting.span
        changes.append({"count": begin, "kind": "BEGIN" if setting.of_fault else "GIVE", **shared})
        if end < math.inf:
            changes.append({"count": int(end), "kind": "END", **shared})
    on.c.define("const Change changes", [fields(change) for change in changes])
    on.c.lines.append(f"const size_t change_count = {len(changes)};")
    on.c.lines.append(f"size_t change_order[{max(1, len(changes))}];")


def _listed(c: Text, kind: str, made: Sequence[str]) -> dict[str, Any]:
    """Returns the entries for an array of exchanges: its name, and how many there are."""
    name = f"exchanges_{len(c.lines)}"
    c.define(f"static const Exchange {name}", made)
    return {f"{kind}s": name, f"{kind}_count": len(made)}
