"""A scenario is opened: its FMUs located, read and checked, its swaps prepared and its plan made; no code of them
runs."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from fmus.build import BLOCKS, FLAVOURS, BuildError, ensure, ensure_all
from fmus.fingerprint import unchanging
from fmus.interface import load as load_interface

from ..errors import InputError, Kind, Problem, Problems, hint, reason
from ..fmu.archive import Fmu, open_fmu, second, shown
from ..fmu.interfaces import is_path
from ..fmu.model import Element
from ..instances.block import Block
from ..instances.own_parameters import refuse_missing, with_own
from ..paths import located
from ..scenario.load import load
from ..scenario.scenario import Scenario
from ..swap.prepare import prepare
from ..swap.prepared import Prepared
from ..system import cycles
from ..system.rates import Rates, rates
from ..telemetry.pack import notes_of, packed, unit_notes
from .limits import limits
from .manifest import described
from .plan import Plan, plan


@dataclass(frozen=True)
class Opened:
    """A scenario held against its FMUs, of which no code has run yet."""

    fmus: dict[str, Fmu]
    prepared: Prepared
    rates: Rates
    plan: Plan

    @cached_property
    def described(self) -> dict[str, Any]:
        """Entry of it in a manifest, whatever comes of a run."""
        return described(self.plan, self.fmus, self.prepared.handed_on(self.plan.starts))

    def adapted(self, block: Block) -> Block:
        """The instance as the master sees it: behind our interface, and stepped as its FMU can be stepped."""
        substeps = self.rates.substeps.get(block.name)
        return self.prepared.adapted(substeps.before(block) if substeps else block)

    def only(self, name: str) -> Opened:
        """Returns the same with one block alone."""
        return replace(self, fmus={name: self.fmus[name]})


def open_scenario(scenario: Scenario, fmus: dict[str, Fmu] | None = None) -> Opened:
    """Locates and opens the FMUs, where they are not given, prepares what is swapped and plans the run.

    Raises InputError with all errors.
    """
    fmus = open_fmus(scenario) if fmus is None else fmus
    scenario, unfed = _without_inputs(scenario)
    _refuse_second(scenario, fmus)
    prepared = prepare(scenario, fmus)
    prepared.scenario, follows = cycles.followed(prepared.scenario, prepared.models)
    prepared.notes += follows
    timed = rates(prepared.scenario, fmus)
    ready = plan(timed.scenario, prepared.models, prepared.feedthrough)
    told = [*_of_records(scenario, fmus), *scenario.source.notes]
    ready.notes[:0] = [*_not_valid(scenario, fmus), *told, *unfed, *prepared.notes, *timed.notes]
    ready.not_evaluated = prepared.not_evaluated
    return Opened(fmus, prepared, timed, ready)


def open_fmus(scenario: Scenario, here: bool = True) -> dict[str, Fmu]:
    """Returns the FMUs of the blocks, located and opened. Raises InputError with all errors.

    `here`: those of this project need only run on this machine.
    """
    with unchanging():
        return _open_fmus(scenario, here)


def _open_fmus(scenario: Scenario, here: bool) -> dict[str, Fmu]:
    fmus: dict[str, Fmu] = {}
    _build(scenario, here)
    laws = [name for name, entry in scenario.blocks.items() if entry.python]
    with Problems() as problems:
        for name, entry in scenario.blocks.items():
            if entry.flavour and is_path(entry.fmu):
                text = f"only this project's own blocks have a flavour; {entry.fmu} is a file"
                problems.append(scenario.error(("blocks", name, "flavour"), text))
            try:
                if entry.python is not None:
                    fmus[name] = _law(scenario, name, entry.python)
                    continue
                if entry.telemetry is not None:
                    path = packed(scenario, name, entry.telemetry)
                else:
                    path = locate(entry.fmu, scenario.source.folder, entry.flavour or scenario.flavour, here)
                fmus[name] = open_fmu(path, entry.validation == "lenient")
            except InputError as error:
                problems += error.problems if entry.telemetry or entry.python else with_remedies(error, scenario, name)
    return fmus | {name: asked_for(scenario, name, fmus) for name in laws}


def _build(scenario: Scenario, here: bool) -> None:
    """Builds the project's own blocks of a scenario side by side; what cannot be built is an error where it is
    located."""
    with suppress(BuildError, OSError):
        ensure_all(
            (
                entry.fmu
                for entry in scenario.blocks.values()
                if entry.fmu in BLOCKS and (entry.flavour or scenario.flavour) == "native"
            ),
            here,
        )


def _law(scenario: Scenario, name: str, text: str) -> Fmu:
    """Returns what stands for a law in Python: its file, with the ports of the interface. Raises InputError."""
    kind = scenario.blocks[name].interface or name
    with scenario.source.naming(("blocks", name, "python")):
        path = located(text, scenario.source.folder).resolve()
        refuse_missing(path, text)
        if kind not in BLOCKS:
            remedy = f"remedy: 'interface: NAME' beside it, one of {', '.join(BLOCKS)}"
            raise InputError(f"the project has no interface {kind!r}; {remedy}")
        own = open_fmu(locate(kind, scenario.source.folder, "native"))
        own = replace(own, model=with_own(own.model, path))
    return replace(own, path=path, sha256=hashlib.sha256(path.read_bytes()).hexdigest())


def asked_for(scenario: Scenario, name: str, fmus: Mapping[str, Fmu]) -> Fmu:
    """Returns the same with the outputs that it has to give; those for optional inputs alone start at the value that
    means that there is none."""
    needed: set[str] = set()
    absent: dict[Element, Any] = {}
    law = fmus[name]
    for connection in (c for c in scenario.connections if c.source.block == name):
        source, target = law.model.named(connection.source.variable), None
        if connection.target.block in fmus:
            target = fmus[connection.target.block].model.named(connection.target.variable)
        if source is None or target is None or not target.optional:
            needed.add(connection.source.variable)
        else:
            absent |= dict.fromkeys(source.elements, fmus[connection.target.block].model.starts.get(target.elements[0]))
    starts = {**law.model.starts, **{e: v for e, v in absent.items() if e.variable not in needed}}
    return replace(law, model=replace(law.model, needed=frozenset(needed), starts=starts))


def _refuse_second(scenario: Scenario, fmus: dict[str, Fmu]) -> None:
    """Raises InputError for two instances in this process of an FMU that can have one only.

    Each would have a copy of its library, loaded from a folder of its own. That may do, but nobody else knows what it
    shares beyond its library (files, a license, another library), and FMI forbids it.
    """
    if pair := second({name: fmu for name, fmu in fmus.items() if limits(scenario, name) is None}):
        text = (
            f"{shown(fmus[pair[1]].path)} can have one instance in a process "
            f"(canBeInstantiatedOnlyOncePerProcess), and {pair[0]} is one in this process, too"
        )
        raise InputError(scenario.error(("blocks", pair[1], "fmu"), text, remedy="isolation: process"))


def _not_valid(scenario: Scenario, fmus: dict[str, Fmu]) -> list[str]:
    """Returns what is not valid in the descriptions of FMUs that run all the same, by `validation: lenient`."""
    return [
        scenario.note(
            ("blocks", name, "validation"), f"{shown(fmu.path)}: modelDescription.xml is not valid: {problem}"
        )
        for name, fmu in fmus.items()
        for problem in fmu.problems
    ]


def _without_inputs(scenario: Scenario) -> tuple[Scenario, list[str]]:
    """Returns the scenario without connections to records, which take none, and what to say of it."""
    records = {name for name, entry in scenario.blocks.items() if entry.telemetry is not None}
    fed = [i for i, connection in enumerate(scenario.connections) if connection.target.block in records]
    if not fed:
        return scenario, []
    names = ", ".join(str(scenario.connections[i].target) for i in fed)
    return load(scenario.source.without(("connections", i) for i in fed)), [
        f"a record takes no inputs; left out: {names}"
    ]


def _of_records(scenario: Scenario, fmus: dict[str, Fmu]) -> list[str]:
    records = {name: entry.telemetry for name, entry in scenario.blocks.items() if entry.telemetry is not None}
    told = [
        f"{name}: {note}"
        for name, record in records.items()
        for note in notes_of(fmus[name].path, record.file, scenario.duration)
    ]
    return told + [note for name, record in records.items() for note in unit_notes(scenario, name, record)]


def locate(fmu: str, folder: Path, flavour: str, here: bool = True) -> Path:
    """The file of an FMU: a block of this project by its bare name, built when need be, or a path."""
    if "://" in fmu:
        raise InputError(f"{fmu} is an address; expected the path of an .fmu file")
    if is_path(fmu):
        return located(fmu, folder).resolve()
    if fmu not in BLOCKS:
        raise InputError(f"this project has no block {fmu!r}{hint(fmu, BLOCKS)}; the path of an FMU ends in .fmu")
    if flavour in FLAVOURS and flavour not in (has := load_interface(fmu).flavours):
        there = " or ".join(f"'flavour: {one}'" for one in has)
        raise InputError(f"the block {fmu!r} has no flavour {flavour!r}; remedy: {there} for this block")
    try:
        return ensure(fmu, flavour, here=here)
    except BuildError as error:
        raise InputError(f"the block {fmu!r} cannot be built: {error}") from None
    except OSError as error:
        where = error.filename or "the disk"
        raise InputError(f"the block {fmu!r} cannot be built: {where}: {reason(error)}") from None


def with_remedies(error: InputError, scenario: Scenario, name: str) -> list[Problem]:
    """Returns the errors of a block's FMU at its place, with what helps where its description is not valid, or where a
    file of this project's own has been spoilt."""
    entry = scenario.blocks[name]
    flavour = "" if (entry.flavour or scenario.flavour) == "native" else " --flavour python"
    there = f"'validation: lenient' in the entry of {name} under blocks in the scenario"
    remedies: dict[Kind, str] = {
        "not valid": f"correct it in the exporting tool, or write {there}, to run it all the same",
        "damaged": "" if is_path(entry.fmu) else f"orchestrate build {entry.fmu}{flavour}",
    }
    place = scenario.source.place(("blocks", name, "fmu"))
    return [replace(problem, remedy=remedies.get(problem.kind, problem.remedy)).at(place) for problem in error.problems]
