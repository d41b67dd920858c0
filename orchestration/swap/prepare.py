"""Another team's FMU in a block's place: what a scenario's `interface` and `map` mean for a run.

`prepare` looks at every block whose FMU is given by its path and whose interface is known. It refuses
what does not fit, leaves out what refers to ignored outputs, and says all of it in notes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..errors import InputError, Problem, Problems
from ..fmu.archive import Fmu, shown
from ..fmu.interfaces import Interface, is_path, own, place, reference, with_inputs
from ..fmu.model import Element
from ..paths import located
from ..scenario import mapping as mappings
from ..scenario.load import load
from ..scenario.references import Connection
from ..scenario.scenario import BlockEntry, Scenario
from ..scenario.source import Key, Source
from ..system.order import Hook
from .as_ours import held
from .findings import Finding, Fit, unfed
from .fit import fit
from .prepared import Prepared
from .settle import settle


def interface_of(scenario: Scenario, name: str, model_name: str) -> str | None:
    """The interface that a block is held to; None where it is one of the project's own blocks, or none is known.

    An FMU that is called as one of ours for this place, as `controller_planned` for `controller`, is held to that.
    """
    entry = scenario.blocks[name]
    if entry.interface is not None:
        return entry.interface
    if not is_path(entry.fmu) or name not in own():
        return None
    return model_name if model_name in own() and place(model_name) == place(name) else name


def prepare(scenario: Scenario, fmus: Mapping[str, Fmu]) -> Prepared:
    """Fits every swapped block to its interface. Raises InputError with everything that does not fit."""
    prepared = Prepared(
        scenario, {name: with_inputs(fmu.model, scenario.blocks[name].fmu) for name, fmu in fmus.items()}
    )
    interfaces: dict[str, Interface] = {}
    with Problems() as problems:
        for name, entry in scenario.blocks.items():
            asked = interface_of(scenario, name, fmus[name].model.name)
            if asked is not None:
                with problems.gathered():
                    interfaces[name] = _reference(scenario, name, asked)
                    _fit(prepared, name, entry, interfaces[name], fmus[name])
            elif entry.map is not None:
                text, remedy = (
                    "a mapping needs to know whose ports stand on its left",
                    "'interface: ...' in the entry of this block",
                )
                problems.append(scenario.error(("blocks", name, "map"), text, remedy=remedy))
    if interfaces:
        settle(prepared)
        _connect(prepared)
        prepared.feedthrough = _hook(prepared, interfaces)
    return prepared


def _reference(scenario: Scenario, name: str, asked: str) -> Interface:
    with scenario.source.naming(("blocks", name, "interface")):
        return reference(asked, scenario.source.folder)


def _fit(prepared: Prepared, name: str, entry: BlockEntry, interface: Interface, fmu: Fmu) -> None:
    scenario = prepared.scenario
    mapping, source = read_mapping(scenario, name, entry)
    fitted = fit(interface, fmu.model, mapping)

    def where(finding: Finding) -> Problem:
        if not finding.key:
            return scenario.error(("blocks", name, "fmu"), finding.text, remedy=finding.remedy)
        holder, key = (source, finding.key) if source else (scenario, ("blocks", name, "map", *finding.key))
        return holder.error(key, finding.text, remedy=finding.remedy)

    errors = [where(finding) for finding in fitted.errors if not unfed(finding)]
    errors += _starts_without(prepared, name, entry, fitted, fmu)
    if mapping is None and any(finding.topic == "missing" for finding in fitted.errors):
        remedy = f"a mapping, as 'orchestrate check {shown(fmu.path)} --as {interface.name} --suggest' proposes one"
        errors.append(scenario.error(("blocks", name, "fmu"), "its ports have other names than ours", remedy=remedy))
    if errors:
        raise InputError(*errors)
    prepared.fits[name] = fitted
    for theirs, signal in fitted.fed.items():
        key: Key = ("inputs", theirs)
        origin = source.where(key) if source else scenario.source.where(("blocks", name, "map", *key))
        prepared.connections.append((Connection(f"{signal} -> {name}.{theirs}"), origin))
    prepared.models[name] = held(prepared.models[name], fitted)
    prepared.notes += [f"{name}: {note}" for note in _notes(fitted, entry)]


def _connect(prepared: Prepared) -> None:
    """Puts into the scenario what the mappings connect, unless it says so already, as that of a manifest does."""
    source, there = prepared.scenario.source, {(c.source, c.target) for c in prepared.scenario.connections}
    for connection, origin in prepared.connections:
        if (connection.source, connection.target) not in there:
            source = source.with_item("connections", str(connection), origin)
    if source is not prepared.scenario.source:
        prepared.scenario = load(source)


def read_mapping(scenario: Scenario, name: str, entry: BlockEntry) -> tuple[mappings.Mapping | None, Source | None]:
    """A block's mapping, and its own file where it has one."""
    if entry.map is None or entry.map.file is None:
        return entry.map, None
    with scenario.source.naming(("blocks", name, "map")):
        return mappings.load(located(entry.map.file, scenario.source.folder))


def _starts_without(prepared: Prepared, name: str, entry: BlockEntry, fitted: Fit, fmu: Fmu) -> list[Problem]:
    """Errors: values of the scenario for parameters of ours that theirs lacks."""
    errors = []
    for key in entry.start:
        ours = key.variable
        if ours in fitted.missing and fitted.missing[ours].causality == "parameter":
            message = (
                f"{shown(fmu.path)} has no parameter {ours}, so this value would be lost; remedy: map it to one "
                "of theirs "
                "under ports in the mapping, or list it under ignore there"
            )
            errors.append(prepared.scenario.error(("blocks", name, "start", key), message))
    return errors


def _notes(fitted: Fit, entry: BlockEntry) -> list[str]:
    """Returns what a user should know of a fit, in few lines."""
    notes = [finding.text for finding in fitted.findings if finding.level == "warning"]
    if fitted.ignored:
        names = [f"{ours.causality} {name}" for name, ours in fitted.ignored.items()]
        notes.append(f"does without {', '.join(names)}, as the mapping says")
    outputs = [name for name, ours in fitted.missing.items() if ours.causality == "output"]
    if outputs:
        notes.append(f"its FMU lacks {_listed('output', outputs)}, not recorded then")
    for causality, what in (("output", "recorded under their own names"), ("parameter", "which keep the FMU's values")):
        given = {str(name).partition("[")[0] for name in entry.start}
        names = [v.name for v in fitted.extra if v.causality == causality and v.name not in given]
        if names and entry.python and causality == "parameter":
            notes.append(f"its law has parameters of its own, with the file's values: {', '.join(names)}")
        elif names:
            notes.append(f"its FMU has further {causality}s, {what}: {', '.join(names)}")
    return notes


def _listed(what: str, names: list[str]) -> str:
    return f"the {what}{'s' if len(names) > 1 else ''} {', '.join(names)}"


def _hook(prepared: Prepared, interfaces: Mapping[str, Interface]) -> Hook:
    """Our interface's feedthrough, where an FMU declares none."""
    for name, interface in interfaces.items():
        declared = prepared.models[name].feedthrough
        silent = {e.variable for e in interface.model.feedthrough if e in declared and declared[e] is None}
        absent = {
            v.name
            for v in prepared.models[name].of("output")
            if v.name in interface.model.variables and v.elements[0] not in declared
        }
        if unknown := sorted(silent | absent):
            prepared.notes.append(
                f"{name}: its FMU does not say on which inputs {', '.join(unknown)} "
                f"{'depends' if len(unknown) == 1 else 'depend'} directly; "
                f"what the interface {interface.name} says is taken"
            )

    return _Feedthrough(prepared, interfaces)


@dataclass(frozen=True)
class _Feedthrough:
    """That of our interfaces. No local function, since the workers of a campaign get it pickled."""

    prepared: Prepared
    interfaces: Mapping[str, Interface]

    def __call__(self, block: str, element: Element) -> frozenset[Element] | None:
        interface = self.interfaces.get(block)
        known = interface.model.feedthrough.get(element) if interface is not None else None
        if known is None:
            return None
        theirs = self.prepared.models[block].variables
        more = (e for name in self.prepared.fits[block].feeding for e in theirs[name].elements)
        return frozenset(e for e in known if e.variable in theirs) | frozenset(more)
