"""The loop of a set of wheels in which a law demands a torque, which the bounded allocator shares out.

So laws that were written for one wheel, and the planned controller, fly in the place of one that commands wheels and
rods itself. Tests: tests/design/test_rank.py.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from orchestration.scenario.source import Source

COMMANDS = ("dipole_cmd", "wheel_torque_cmd")
DEMAND = ("tau_cmd_B", "dipole_ff", "wheel_torque_ff")
SEEN = ("b_B", "omega_B", "h_w")
LAW, ALLOCATOR = "controller_planned_wheels", "allocator_bounded_wheels"
COMMON = ("dipole_max", "command_period")
"""Start values that both new blocks have of the one that they replace."""


def allocated(source: Source, place: str, law: Path | None) -> Source:
    """Returns the scenario with a law that demands a torque in the place of a block that commands rods and wheels;
    the planned controller where none is given."""
    blocks = source.data["blocks"]
    entry: dict[str, Any] = blocks[place]
    name = next(n for n in ("allocator", f"{place}_allocator") if n not in blocks)
    start = {key: value for key, value in (entry.get("start") or {}).items() if key in COMMON}
    kept = {key: entry[key] for key in ("every", "differs") if key in entry}
    block = {"fmu": LAW} if law is None else {"interface": LAW, "python": str(law.resolve())}
    source = source.with_entry(("blocks", place), {**kept, "start": start, **block})
    source = source.with_entry(("blocks", name), {**kept, "start": dict(start), "fmu": ALLOCATOR})
    wires = []
    for text in source.data["connections"]:
        origin, _, target = (part.strip() for part in str(text).partition("->"))
        if origin in [f"{place}.{port}" for port in COMMANDS]:
            text = f"{name}.{origin.partition('.')[2]} -> {target}"
        wires.append(text)
        wires += [f"{origin} -> {name}.{port}" for port in SEEN if target == f"{place}.{port}"]
    wires += [f"{place}.{port} -> {name}.{port}" for port in DEMAND]
    wires += [f"{name}.{flag} -> {place}.{flag}" for flag in ("wheel_failed", "h_w_failed")]
    wires.append(f"{name}.dipole_cmd -> {place}.dipole_applied")
    if law is None:
        wires.append(f"{place}.rod_gains_estimate -> {name}.rod_gains")
    return source.with_entry(("connections",), wires)
