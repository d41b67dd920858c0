"""Accepts or refuses an FMU in a block's place: check, mapping, reference data, comparison and trials, as requirements.

Tests: tests/orchestration/acceptance/test_accept.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from fmus import kit

from ..errors import BlockError, InputError
from ..fmu import zipped
from ..fmu.platforms import PLATFORM
from ..scenario.source import Source
from ..scenario.text import parse
from ..session.limits import limits
from ..session.open import open_scenario
from ..session.read import load
from ..swap.findings import Finding, Fit, unfed
from ..swap.option import Swap, swapped
from ..temporary import temporary
from . import verdict
from .check import check
from .compare import Comparison, compare
from .facts import facts
from .itself.block import judge
from .polarity.mend import as_yaml
from .robustness import Trial, tried
from .suggest import suggest
from .vector import name_of, scenario_of

_INSTANTS = 400
"""Of the run that the trials play."""
_TIMEOUT = "10 s"
"""That a call of it may take, where the scenario does not say."""
_REFERENCE = "reference"
"""What topics of findings about reference data begin with."""


@dataclass
class Acceptance:
    """All that was looked at, and what came of it."""

    facts: dict[str, Any]
    block: str
    scenario: str
    findings: list[Finding]
    fit: Fit | None
    mapping: str = ""
    """Where the mapping comes from: a file, proposed, or empty."""
    proposed: str = ""
    """The mapping that was proposed, as YAML."""
    comparison: Comparison | None = None
    alone: list[Trial] = field(default_factory=list)
    """What it keeps by itself, whatever ours answers."""
    trials: list[Trial] = field(default_factory=list)
    failure: BlockError | None = None
    license: list[str] = field(default_factory=list)

    @property
    def requirements(self) -> list[Trial]:
        """Returns each requirement with its verdict: met, failed, or empty where it could not be tried."""
        return list(_requirements(self))

    @property
    def passed(self) -> bool:
        """Returns whether none has failed, and the loop was flown."""
        return self.comparison is not None and all(one.status != "failed" for one in self.requirements)

    @property
    def corrected(self) -> str:
        """Returns the mapping that corrects it, as YAML, where it behaves as one that is wired wrongly."""
        mended = self.comparison.mended if self.comparison is not None else None
        return as_yaml(mended.mapping) if mended is not None and mended.behaves else ""

    @property
    def errors(self) -> list[Finding]:
        """Returns what does not fit."""
        return [f for f in self.findings if f.level == "error" and not unfed(f)]


def accept(path: Path, as_: str, map_: Path | None, source: Source, block: str) -> Acceptance:
    """Looks at an FMU for a scenario's block. Raises InputError where it cannot be looked at at all."""
    open_scenario(load(source))  # what is wrong in it is not the FMU's
    findings, fitted = check(path, as_, map_, tolerance=1e-6)
    made = Acceptance(facts(str(path), lenient=True), block, load(source).name, findings, fitted)
    made.mapping, made.license = str(map_ or ""), _license(path)
    theirs = patient(swapped(source, [Swap(block, str(path), "FMU", str(map_) if map_ else None, "--map")]), block)
    if map_ is None and fitted is not None and made.errors:
        made.proposed, made.mapping = suggest(fitted), "proposed"
        data: Any = parse(made.proposed, "the mapping that is proposed").data
        theirs = theirs.with_entry(("blocks", block, "map"), data)
        with temporary() as folder:
            file = folder / "proposed.yaml"
            file.write_text(made.proposed, "utf-8")
            made.findings, made.fit = check(path, as_, file, tolerance=1e-6)
    if made.errors:
        return made
    try:
        made.comparison = compare(source, theirs, block)
    except InputError as error:
        made.findings.append(Finding("error", "run", str(error)))
        return made
    except BlockError as error:
        made.failure = error
        return made
    made.failure = made.comparison.failure
    made.alone = judge(source, theirs, made.comparison)
    if len(made.comparison.played.rows) > 1:
        made.trials = tried(theirs, block, _inputs(made.comparison))
    else:
        made.trials = [Trial("trials of what hosts do", "", "the loop ended before its second instant")]
    return made


def patient(theirs: Source, block: str) -> Source:
    """Returns the scenario with the time that a call of the block may take, where it has a process of its own."""
    scenario = load(theirs)
    if scenario.blocks[block].timeout is not None or limits(scenario, block) is None:
        return theirs
    return theirs.with_entry(("blocks", block, "timeout"), _TIMEOUT)


def scenario_for(block: str) -> Path:
    """Returns the run of the project in which a block is flown by default: the one whose wirings are told apart best,
    where it has the block. Raises InputError."""
    best = kit.SCENARIO.with_name("paper_no_singularity.yaml")
    return best if name_of(load(best), block) else scenario_of(block)


def _inputs(comparison: Comparison) -> dict[str, Any]:
    """Returns the first of what ours was given in its run."""
    ours, model = comparison.ours, comparison.played.model
    names = [v.name for v in model.of("input") if f"{comparison.block}.{v.name}" in ours]
    rows = {name: ours.rows(f"{comparison.block}.{name}") for name in names}
    at = comparison.played.rows[:_INSTANTS]
    return {name: values.reshape(len(values), -1)[at].astype(float) for name, values in rows.items()}


def _license(path: Path) -> list[str]:
    names = zipped.names(path, "FMU")
    return [name for name in names if "license" in name.lower() and not name.endswith("/")]


def _requirements(made: Acceptance) -> Iterator[Trial]:
    errors = made.errors
    about = f" with the {made.mapping} mapping" if made.mapping == "proposed" else ""
    text = "; ".join(map(str, errors[:3])) or f"ports, units, shapes and directions fit{about}"
    yield Trial("it fits the interface", "failed" if errors else "met", text)
    here = PLATFORM in made.facts["platforms"] or made.comparison is not None
    yield Trial("it has a library for this machine", "met" if here else "failed", ", ".join(made.facts["platforms"]))
    warnings = sum(f.level == "warning" for f in made.findings)
    yield Trial("its description is valid", "failed" if made.facts["not_valid"] else "met", f"warnings: {warnings}")
    played = [f for f in made.findings if f.topic.startswith(_REFERENCE)]
    status = "" if not played else "failed" if any(f.level == "error" for f in played) else "met"
    yield Trial(
        "it gives the reference data that it carries", status, "; ".join(f.text for f in played) or "it has none"
    )
    comparison = made.comparison
    if comparison is None:
        why = str(made.failure) if made.failure else "it does not fit"
        yield Trial("the loop flies with it", "failed" if made.failure else "", why)
        return
    failed = comparison.failure
    yield Trial(
        "the loop flies with it",
        "failed" if failed else "met",
        str(failed) if failed else comparison.ours.scenario.name,
    )
    mended = comparison.mended
    wrong = mended is not None and bool(mended.behaves or mended.equally)  # another cause may be meant to be there
    status = "failed" if wrong or not (comparison.equivalent or comparison.met) else "met"
    text = " ".join(f"{verdict.verdict(comparison)}. {' '.join(verdict.explanation(comparison))}".split())
    yield Trial("no wrong wiring is found", status, text)
    for a, b in comparison.claims:
        status = "" if b is None else "met" if b.passed else "failed"
        yield Trial(
            f"in the loop: {a.name}",
            status,
            "it lacks an output that is read" if b is None else f"{b.text}, expected {a.expected}",
        )
    yield from made.alone
    yield from made.trials


def untested(made: Acceptance) -> list[str]:
    """Returns what the report says nothing of."""
    others = [name for name in made.facts["platforms"] if name != PLATFORM]
    left = [f"its libraries for {', '.join(others)}: they were read, not run"] if others else []
    left += [f"{one.name}: {one.text}" for one in made.requirements if not one.status]
    if made.fit is not None:
        ignored = ", ".join([*made.fit.ignored, *made.fit.missing])
        left += [f"ports and parameters of ours that it lacks: {ignored}"] if ignored else []
        extra = ", ".join(v.name for v in made.fit.extra)
        left += [f"its own ports and parameters, at their starts or as mapped: {extra}"] if extra else []
    if made.mapping == "proposed":
        left.append("whether the mapping is what its maker means: it was proposed from names and units")
    left += [
        f"other manoeuvres, parameters and durations than those of {made.scenario}",
        "its code: leaks of memory, undefined behaviour, what it does beyond its ports",
        "hardware: orchestrate card writes the test on ground",
    ]
    return left


def summary(made: Acceptance) -> dict[str, Any]:
    """Returns all of it as plain data."""
    return {
        "fmu": {key: value for key, value in made.facts.items() if key != "variables"},
        "license_files": made.license,
        "block": made.block,
        "scenario": made.scenario,
        "mapping": made.mapping,
        "proposed": made.proposed,
        "corrected": made.corrected,
        "accepted": made.passed,
        "requirements": [asdict(one) for one in made.requirements],
        "findings": [finding.data for finding in made.findings],
        "comparison": None if made.comparison is None else verdict.summary(made.comparison),
        "not_tested": untested(made),
    }
