"""Stability margins of the hold, by what `orchestrate margins` does.

Tests: tests/design/review/test_review.py.
"""

from __future__ import annotations

from orchestration import BlockError, InputError
from orchestration.scenario.source import Source
from orchestration.session.open import open_scenario
from orchestration.session.read import load
from orchestration.session.session import Session

from . import studies
from .content import Section, Table
from .facts import Facts

try:
    from orchestration.margins.floquet import coordinates
    from orchestration.margins.inject import Rig
    from orchestration.margins.measure import LIMIT, measure
    from orchestration.margins.periods import follow
    from orchestration.margins.report import HEADER, Found
    from orchestration.margins.site import site
except ModuleNotFoundError as missing:
    _MISSING = missing.name
else:
    _MISSING = None

WHEN = 0.5
"""Orbits after which the hold is measured."""
PIECE, LEFT = 10.0, 200.0
"""s: from plan to plan, and the time after which the rest of a disturbance is told."""


def section(facts: Facts, source: Source) -> Section:
    """Returns gain, phase, delay and disk margins where the loop has some, what is left of disturbances of a
    controller that plans, else the reason."""
    if _MISSING:
        return Section("Stability margins", notes=[f"Not measured: the package {_MISSING!r} is not installed."])
    port = _port(facts)
    for starts in (*studies.perfect(facts), studies.hold(facts)):
        for block, values in starts.items():
            for name, value in values.items():
                source = source.with_start(f"{block}.{name}", value)
    source = source.without([("record",), ("expect",), ("figures",), ("live",)])
    loaded = load(source.with_value("duration", f"{WHEN * facts.period:.6g} s", "review"))
    try:
        with Session(open_scenario(loaded)) as session:
            plan = session.opened.plan
            rig = Rig(session, site(plan, (port,)), round(loaded.duration / plan.clock.step))
            if facts.controller == "controller_planned":
                why = "controller_planned solves a new plan at its own times, so the loop has no margins of a moment"
                return _followed(facts, rig, port, why)
            response = measure(rig)
            varies = f"its response changes by {100 * response.change:.2g}% meanwhile" * (response.change > LIMIT)
            if refused := response.refused or varies:
                return _followed(facts, rig, port, f"At {port} the loop has no margins: {refused}")
    except (InputError, BlockError) as error:
        return Section("Stability margins", notes=[f"Not measured at {port}: {error}"])
    note = (
        f"In the hold, at {port}, on an attitude that is measured to 0.01 deg: noise of sensors would hide the loop. "
        f"Of small motions {WHEN:g} orbits after the start; meanwhile the response changed by "
        f"{100 * response.change:.2g}%. They do not hold in a slew, while momentum is shed, or at a limit of a rod or "
        "wheel."
    )
    found = Found.of(loaded.name, loaded.duration, response)
    p = facts.satellite.p
    spare = [f"{facts.plant}.wheel_torque_cmd[{i}]" for i in range(p.wheels + 1, 5)] if p.is_set else []
    rows = [list(row) for row in found.rows() if row[0] not in spare]
    return Section(
        "Stability margins",
        [Table("Stability margins", list(HEADER), rows, note)],
        notes=response.warnings,
    )


def _port(facts: Facts) -> str:
    """Returns where the loop is opened: at the torque that a law demands, else at the wheels or the rods."""
    demand = f"{facts.blocks.get(facts.controller)}.tau_cmd_B"
    if facts.controller != "controller_planned" and any(str(c.source) == demand for c in facts.scenario.connections):
        return demand
    return f"{facts.plant}.wheel_torque_cmd" if facts.satellite.p.is_set else f"{facts.plant}.dipole_cmd"


def _followed(facts: Facts, rig: Rig, port: str, why: str) -> Section:
    """Returns what is left of disturbances where a loop has no margins of a moment, for this reason."""
    seen = coordinates(rig.session.opened.plan, [f"{facts.plant}.R_NB", f"{facts.plant}.omega_B"])
    pieces = max(round(PIECE / rig.period), 1)
    found = follow(rig, seen, round(LEFT / PIECE) * pieces, 3, pieces)
    if found.refused:
        return Section("Stability margins", notes=[f"{why}. Pulses at {port}: {found.refused}"])
    rows = [
        [f"{k * LEFT:g} s", f"{one.ratio:.3g}", f"{one.least:.3g} to {one.most:.3g}", f"{100 * one.error:.2g}%"]
        for k, one in enumerate(found.windows, start=1)
    ]
    note = (
        f"{why}. Left: attitude and rate after pulses at {port} over {LEFT:g} s beside those over the {LEFT:g} s "
        "before, on an attitude that is measured to 0.01 deg. Below 1 the disturbance decays, above 1 it grows. "
        "orchestrate margins --change seeks the gain, delay or parameter that loses the hold."
    )
    columns = ["after", "left", "of the pulses", "error"]
    return Section("Stability margins", [Table("Decay of disturbances", columns, rows, note)])
