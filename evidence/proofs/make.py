"""docs/evidence/proofs.md: what is proved of the flight code, and what is argued for."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from fmus.block import Block
from fmus.kit import flight
from orchestration import InputError
from orchestration.cli.console import say

from .. import markdown
from ..paper import ROOT
from ..tools import side_by_side
from . import rules
from .analysis import Result
from .argued import arguments, stale, unproved
from .bounds import bounds_of
from .contracts import CONTRACTS, Contract
from .coverage import FLIGHT
from .coverage import rows as rows_of_coverage
from .faults import faults
from .harness import STEP_MAX, TIME_MAX
from .kept import FOLDER, result_of
from .loops import rows as rows_of_loops
from .rounds import proved
from .subjects import CALLS, HERE, REACHED, SUBJECTS, Subject

PAGE = ROOT / "docs" / "evidence" / "proofs.md"
BEFORE = ("check", "prepare")
"""Calls before a flight."""


def prove(names: Sequence[str]) -> list[tuple[Subject, Result]]:
    """Analyses all subjects, or those of these names, and says what each came to.

    Raises InputError where a property is neither proved nor argued for, or an argument is for nothing or for another C.
    """
    given, left = arguments(), 0
    if changed := stale(given):
        raise InputError("\n".join(changed))
    subjects = [subject for subject in SUBJECTS if not names or subject.name in names]
    results = []
    for subject, result in zip(subjects, side_by_side(result_of, subjects), strict=True):
        results.append((subject, result))
        open_ones = unproved(result.alarms, given)
        left += len(open_ones)
        say(
            f"{subject.title}: {result.proved} proved, {len(result.alarms) - len(open_ones)} argued, "
            f"{len(open_ones)} open; {result.statements[0]} of {result.statements[1]} statements; "
            f"{result.seconds:.0f} s"
        )
        for alarm in open_ones:
            say(f"  {alarm}")
        for loop in (loop for loop, holds in result.rounds if not holds):
            say(f"  {loop}: its bound in loops.yaml is not proved")
            left += 1
    if not names:
        followed_elsewhere(results)
    if left:
        raise InputError(f"{left} properties are neither proved nor argued for in evidence/proofs/arguments.yaml")
    met = [alarm for _, result in results for alarm in result.alarms]
    if not names and (idle := [a for a in given if not any(map(a.holds, met))]):
        raise InputError(
            f"arguments.yaml: {idle[0].file}: {idle[0].function}: no analysis meets this; remedy: remove it"
        )
    return results


def followed_elsewhere(results: Sequence[tuple[Subject, Result]]) -> None:
    """Each contract that stands in for a body is one that another program proves. Raises InputError."""
    for subject, _ in results:
        for name in subject.by_contract:
            if not any(name in r.functions and name not in s.by_contract for s, r in results):
                raise InputError(f"{subject.title}: no program follows {name}; remedy: one that does, in subjects.py")


def prove_contracts() -> list[tuple[Contract, Result]]:
    """All of them, and says what each came to. Raises InputError where a goal is not proved."""
    results = [(c, c.prove(FOLDER / c.title.replace(", ", "-").replace(" ", "-"))) for c in CONTRACTS]
    for contract, result in results:
        say(f"{contract.title}: {result.proved} of {result.statements[1]} goals proved; {result.seconds:.0f} s")
    if left := [str(alarm) for _, result in results for alarm in result.alarms]:
        raise InputError("these goals are not proved:\n" + "\n".join(left))
    return results


def make(names: Sequence[str]) -> Path | None:
    """Proves, and writes the page where all was proved, and the rules hold. `contracts` is one of the names."""
    before = digests()
    if not names:
        say(f"{rules.check().total()} findings of rules, all as in {rules.FILE.name}")
    results = [] if tuple(names) == ("contracts",) else prove([name for name in names if name != "contracts"])
    contracts = prove_contracts() if not names or "contracts" in names else []
    if names:
        return None
    if digests() != before:
        raise InputError("the C of a block changed while it was proved; remedy: once more")
    keep(results)
    return page_of(results, contracts)


def digests() -> dict[str, str]:
    """Those of the C of each block that is proved for any numbers."""
    blocks = [Block.named(s.name) for s in SUBJECTS if s.span == "any"]
    return {b.name: flight.digest_of(flight.sources(b.interface, b.folder)) for b in blocks}


def refuse_stale() -> None:
    """Raises InputError where the C that was proved is not that which is there."""
    if digests() != json.loads((ROOT / flight.PROVED).read_text("utf-8")):
        raise InputError(f"{flight.PROVED}: the C that was proved is another; remedy: make prove")


def keep(results: Sequence[tuple[Subject, Result]]) -> None:
    """Writes how much each program reached, and the digest of the C of each block that was proved."""
    REACHED.write_text("".join(f"{s.title!r}: {r.statements[0]}\n" for s, r in results), "utf-8")
    (ROOT / flight.PROVED).write_text(json.dumps(digests(), indent=1, sort_keys=True) + "\n", "utf-8")


def page_of(results: Sequence[tuple[Subject, Result]], contracts: Sequence[tuple[Contract, Result]]) -> Path:
    """Writes the page of these results."""
    given = arguments()
    met = sorted({a for _, result in results for a in result.alarms})
    rows = []
    for subject, result in results:
        left = len(unproved(result.alarms, given))
        argued, reached = str(len(result.alarms) - left), "{} of {}".format(*result.statements)
        rows.append((f"`{subject.name}`, {subject.span or 'any'}", reached, argued))
    blocks, finite = (list(dict.fromkeys(s.name for s, _ in results if s.span == span)) for span in ("any", "limits"))
    rounds = proved(r.rounds for _, r in results)
    missing = [name for name in FLIGHT if name not in blocks]
    coverage = rows_of_coverage(FLIGHT, results)
    whole = [row for row in coverage if row[2:] == ("0", "none")]
    stacks = [bounds_of(name) for name in FLIGHT]
    listed = [places for _, _, places in rules.deviations()]
    PAGE.write_text(
        markdown.render(
            HERE,
            blocks=_names(blocks) + ", the link's frames, dates and the elementary functions",
            finite=_names(finite),
            missing=_names(missing),
            argued=len(met),
            faults=len(faults()),
            rows=rows,
            contracts=len(contracts),
            goals="{} of {}".format(*(sum(r.statements[i] for _, r in contracts) for i in (0, 1))),
            minutes=f"{sum(r.seconds for _, r in (*results, *contracts)) / 60.0:.0f}",
            stacks=[(f"`{b.block}`", *(str(b.stack[call]) for call in CALLS if call not in BEFORE)) for b in stacks],
            before=max(b.stack[call] for b in stacks for call in BEFORE),
            loops=rows_of_loops(FLIGHT, {loop for loop, holds in rounds.items() if holds}),
            rounds=f"{sum(rounds.values())} of {len(rounds)}",
            coverage=[row for row in coverage if row not in whole],
            whole=", ".join(f"{row[0]} ({row[1]})" for row in whole),
            findings=sum(sum(places.values()) for places in listed),
            broken=len(listed),
            years=f"{TIME_MAX / 3.156e7:.0f}",
            step_max=f"{STEP_MAX:.0f}",
            room=24,
        ),
        "utf-8",
    )
    return PAGE


def _names(blocks: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in blocks)
