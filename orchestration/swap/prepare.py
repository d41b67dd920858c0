"""Another team's FMU in a block's place: what a scenario's `interface` and `map` mean for a run.

`prepare` looks at every block whose FMU is given by its path and whose interface is known. It refuses
what does not fit, leaves out what refers to ignored outputs, honours the sample time of a block that
cannot vary its step, and says all of it in notes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError, hint
from ..fmu.interfaces import Reference, is_path, own, place, reference
from ..fmu.model import Element, Model
from ..instances.block import Block
from ..scenario import mapping as mappings
from ..scenario.load import load
from ..scenario.references import split
from ..scenario.scenario import BlockEntry, Scenario
from ..scenario.source import Key, Source
from ..system.order import Hook
from ..system.starts import Start
from .fit import Fit, fit, model, unfed

if TYPE_CHECKING:
    from ..fmu.archive import Fmu


@dataclass
class Prepared:
    """A scenario with its swapped blocks understood."""

    scenario: Scenario
    """Without what refers to ignored outputs, and with the sample times of the blocks."""
    models: dict[str, Model]
    """What the master sees of each block."""
    fits: dict[str, Fit] = field(default_factory=dict)
    substeps: dict[str, int] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    feedthrough: Hook | None = None

    def adapted(self, block: Block) -> Block:
        """The block behind our interface; itself where there is nothing to adapt."""
        found = self.fits.get(block.name)
        often = self.substeps.get(block.name, 1)
        if found is None or (found.identical and often == 1):
            return block
        from .adapter import Adapter

        return Adapter(block, found, often)

    def handed_on(self, starts: Mapping[str, Sequence[Start]]) -> dict[str, dict[Element, Any]]:
        """What the adapted blocks are given for a scenario's start values, by their own elements."""
        from .adapter import handed_on

        found = {name: fit for name, fit in self.fits.items() if self.models[name] is not fit.theirs}
        return {name: handed_on(fit, [(s.element, s.value) for s in starts[name]]) for name, fit in found.items()}


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
    """Fits every swapped block to its interface. Raises InputError with every fault that it finds."""
    prepared = Prepared(scenario, {name: fmu.model for name, fmu in fmus.items()})
    faults: list[str] = []
    references: dict[str, Reference] = {}
    for name, entry in scenario.blocks.items():
        asked = interface_of(scenario, name, fmus[name].model.name)
        if asked is None:
            if entry.map is not None:
                message = "a mapping needs to know whose ports stand on its left; say 'interface: ...' beside it"
                faults.append(scenario.error(("blocks", name, "map"), message))
            continue
        try:
            references[name] = _reference(scenario, name, asked)
            _fit(prepared, name, entry, references[name], fmus[name])
        except InputError as error:
            faults += error.messages
    if faults:
        raise InputError(*faults)
    if references:
        _settle(prepared, fmus)
        prepared.feedthrough = _hook(prepared, references)
    return prepared


def _reference(scenario: Scenario, name: str, asked: str) -> Reference:
    try:
        return reference(asked, scenario.source.folder)
    except InputError as error:
        raise InputError(*(scenario.error(("blocks", name, "interface"), m) for m in error.messages)) from None


def _fit(prepared: Prepared, name: str, entry: BlockEntry, interface: Reference, fmu: Fmu) -> None:
    scenario = prepared.scenario
    told, source = read_mapping(scenario, name, entry)
    found = fit(interface, fmu.model, told)

    def where(key: Key, message: str) -> str:
        if not key:
            return scenario.error(("blocks", name, "fmu"), message)
        return source.error(key, message) if source else scenario.error(("blocks", name, "map", *key), message)

    faults = [where(finding.key, str(finding)) for finding in found.faults if not unfed(finding)]
    faults += _starts_without(prepared, name, entry, found, fmu)
    if faults:
        raise InputError(*faults)
    prepared.fits[name] = found
    if not found.identical:
        prepared.models[name] = model(found)
    prepared.notes += [f"{name}: {note}" for note in _notes(found)]


def read_mapping(scenario: Scenario, name: str, entry: BlockEntry) -> tuple[mappings.Mapping | None, Source | None]:
    """A block's mapping, and its own file where it has one."""
    if entry.map is None or entry.map.file is None:
        return entry.map, None
    try:
        return mappings.load(scenario.source.folder / entry.map.file)
    except InputError as error:
        missing = all("there is no such file" in message for message in error.messages)
        key = ("blocks", name, "map")
        raise InputError(*(scenario.error(key, m) if missing else m for m in error.messages)) from None


def _starts_without(prepared: Prepared, name: str, entry: BlockEntry, found: Fit, fmu: Fmu) -> list[str]:
    """Faults: values of the scenario for parameters of ours that theirs lacks."""
    from ..fmu.archive import shown

    faults = []
    for key in entry.start:
        ours = key.partition("[")[0]
        if ours in found.missing and found.missing[ours].causality == "parameter":
            message = (
                f"{shown(fmu.path)} has no parameter {ours}, so this value would be lost; remedy: map it to one of theirs "
                "under ports in the mapping, or list it under ignore there"
            )
            faults.append(prepared.scenario.error(("blocks", name, "start", key), message))
    return faults


def _notes(found: Fit) -> list[str]:
    """What a user should know of a fit, in few lines."""
    notes = [finding.text for finding in found.findings if finding.level == "warning"]
    if found.ignored:
        names = [f"{ours.causality} {name}" for name, ours in found.ignored.items()]
        notes.append(f"does without {', '.join(names)}, as the mapping says")
    outputs = [name for name, ours in found.missing.items() if ours.causality == "output"]
    if outputs:
        notes.append(f"its FMU lacks {_listed('output', outputs)}, not recorded then")
    for causality, what in (("output", "recorded under their own names"), ("parameter", "which keep the FMU's values")):
        names = [variable.name for variable in found.extra if variable.causality == causality]
        if names:
            notes.append(f"its FMU has further {causality}s, {what}: {', '.join(names)}")
    return notes


def _listed(what: str, names: list[str]) -> str:
    return f"the {what}{'s' if len(names) > 1 else ''} {', '.join(names)}"


# ---------------------------------------------------------------- what refers to outputs that are not there


def _settle(prepared: Prepared, fmus: Mapping[str, Fmu]) -> None:
    """Takes out of the scenario what refers to outputs that are not there, and fixes how often each block is stepped."""
    scenario = prepared.scenario
    faults: list[str] = []
    gone: dict[Key, None] = {}
    lost: dict[str, None] = {}
    for key, signal, whole in _references(scenario):
        block, name, _ = split(signal) or ("", "", ())
        found = prepared.fits.get(block)
        if found is not None and name in found.without:
            gone[whole] = lost[f"{block}.{name}"] = None
            continue
        ours = None if found is None else found.ignored.get(name) or found.missing.get(name)
        if found is None or ours is None or ours.causality != "output":
            continue
        if name in found.missing and key[0] in ("record", "expect"):
            text = (
                f"{block} lacks the output {name}, to which this refers; remedy: map it in the mapping, or list it under "
                "ignore there, and this is left out"
            )
            faults.append(scenario.error(key, text))
        gone[whole] = lost[f"{block}.{name}"] = None
    if gone and not faults:
        told = "; ".join(dict.fromkeys(_name(scenario, key) for key in gone))
        prepared.notes.append(f"left out, since {', '.join(lost)} {'are' if len(lost) > 1 else 'is'} not there: {told}")
    unconnected = _unconnected(prepared)
    gone |= dict.fromkeys(unconnected)
    for number, text in enumerate(scenario.connections):
        block, name, _ = split(text.split("->")[0]) or ("", "", ())
        found = prepared.fits.get(block)
        if (
            found is not None
            and (name in found.ignored or name in found.missing)
            and name not in found.theirs.variables
            and ("connections", number) not in unconnected
        ):
            message = f"{text.strip()}: {block} lacks the output {name}; remedy: map it, or take out the connection"
            faults.append(scenario.error(("connections", number), message))
    for number, fault in enumerate(scenario.faults):
        signal = str(getattr(fault, fault.kind)).partition("=")[0].strip()
        block, name, _ = split(signal) or ("", "", ())
        if block in prepared.fits and name in prepared.fits[block].without:
            text = f"{signal} is optional and {block} lacks it, so the fault would change nothing; remedy: take out the fault"
            faults.append(scenario.error(("faults", number, fault.kind), text))
        if block in prepared.fits and name in prepared.fits[block].ignored:
            text = (
                f"{signal} is under 'ignore' in the mapping of {block}, so the fault would change nothing; remedy: map it, "
                "or take out the fault"
            )
            faults.append(scenario.error(("faults", number, fault.kind), text))
    source = scenario.source.without(gone) if gone else scenario.source
    for name, found in prepared.fits.items():
        try:
            source = _timed(prepared, source, name, fmus[name], found)
        except InputError as error:
            faults += error.messages
    if faults:
        raise InputError(*faults)
    if source is not scenario.source:
        prepared.scenario = load(source)


def _unconnected(prepared: Prepared) -> list[Key]:
    """What a scenario says of optional inputs that a swapped block lacks, or to which one gives nothing."""
    scenario, dropped = prepared.scenario, []
    keys: list[Key] = []
    free: set[str] = set()

    def lacks(block: str, name: str) -> bool:
        return block in prepared.fits and name in prepared.fits[block].without

    for number, text in enumerate(scenario.connections):
        ends = [split(end) or ("", "", ()) for end in text.split("->")]
        if len(ends) != 2:
            continue
        (source, output, _), (target, name, _) = ends
        found = prepared.fits.get(source)
        gives = found is None or output in found.theirs.variables or output not in found.ignored | found.missing
        taken = prepared.models[target].variables.get(name) if target in prepared.models else None
        if lacks(target, name) or (not gives and taken is not None and taken.optional):
            keys.append(("connections", number))
            dropped.append(text.strip())
            free.add(f"{target}.{name}")
    for number, text in enumerate(scenario.delays):
        if text.partition("[")[0].strip() in free:
            keys.append(("delays", number))
    for block, entry in scenario.blocks.items():
        for key in entry.start:
            if lacks(block, key.partition("[")[0]):
                keys.append(("blocks", block, "start", key))
                dropped.append(f"the value of {block}.{key}")
    if dropped:
        prepared.notes.append(
            f"dropped, since an end of it is not there and the input is optional: {'; '.join(dropped)}"
        )
    return keys


def _references(scenario: Scenario) -> list[tuple[Key, str, Key]]:
    """Every mention of a signal outside connections: where it stands, what it says, and what goes with it."""
    found: list[tuple[Key, str, Key]] = []
    for i, signal in enumerate(scenario.record.signals or ()):
        if "*" not in signal:
            found.append((("record", "signals", i), signal, ("record", "signals", i)))
    for i, expectation in enumerate(scenario.expect):
        for field_name in ("signal", "when"):
            if getattr(expectation, field_name):
                found.append((("expect", i, field_name), getattr(expectation, field_name), ("expect", i)))
    for i, hold in enumerate(scenario.holds):
        found += [(("holds", i), signal, ("holds", i)) for signal in (hold.signal, *hold.keeps)]
        found += [(("holds", i, "limits", n), s, ("holds", i, "limits", n)) for n, s in hold.limits.items()]
    for i, entry in enumerate(scenario.figures):
        for field_name in ("shade", "mark"):
            if getattr(entry, field_name):
                found.append((("figures", i, field_name), getattr(entry, field_name), ("figures", i, field_name)))
        for j, panel in enumerate(entry.panels):
            for k, signal in enumerate(panel.signals):
                key: Key = ("figures", i, "panels", j, "signals", k)
                alone = key[:4] if len(panel.signals) == 1 else key
                found.append((key, signal, key[:2] if len(alone) == 4 and len(entry.panels) == 1 else alone))
    return found


def _name(scenario: Scenario, key: Key) -> str:
    """An entry of the scenario in words."""
    if key[0] == "expect":
        return f"the expectation '{scenario.expect[int(key[1])].name}', which is not judged"
    if key[0] == "holds":
        return f"the hold '{scenario.holds[int(key[1])].name}'"
    if key[0] == "figures":
        if "signals" in key:
            return f"a curve of the figure '{scenario.figures[int(key[1])].name}'"
        part = {"shade": "the shading of ", "mark": "the marks of "}.get(str(key[2]) if len(key) > 2 else "", "")
        what = "a panel of " if "panels" in key and not part else ""
        return f"{part}{what}the figure '{scenario.figures[int(key[1])].name}'"
    return "a recorded signal"


# ---------------------------------------------------------------- sample times


def _timed(prepared: Prepared, source: Source, name: str, fmu: Fmu, found: Fit) -> Source:
    """The scenario's source with the sample time of a block that cannot vary its step."""
    scenario = prepared.scenario
    try:
        own_step = sample_time(fmu.description)
    except ValueError as error:
        raise InputError(scenario.error(("blocks", name, "fmu"), str(error))) from None
    if own_step is None:
        return source
    entry, base = scenario.blocks[name], Fraction(repr(scenario.step))
    given = entry.every if "every" in entry.model_fields_set else None
    step = base * (given or 1)
    ratio = own_step / step
    why = f"its FMU cannot vary its step of {float(own_step):.10g} s"
    key: Key = ("blocks", name, "every") if given else ("blocks", name, "fmu")
    if ratio == 1:
        return source
    if 1 / ratio > _SUBSTEPS_MAX:
        message = f"{why}, more than {_SUBSTEPS_MAX} of them in each step of {float(step):.10g} s"
        raise InputError(
            scenario.error(key, f"{message}; remedy: a smaller base step, or a larger stepSize in the FMU")
        )
    if (1 / ratio).denominator == 1:
        prepared.substeps[name] = int(1 / ratio)
        prepared.notes.append(f"{name}: {why}: {int(1 / ratio)} of them in each step of {float(step):.10g} s")
        return source
    if given is None and ratio.denominator == 1:
        prepared.notes.append(f"{name}: {why}: it is stepped once in {int(ratio)} base steps ('every: {int(ratio)}')")
        return source.with_entry(("blocks", name, "every"), int(ratio))
    remedy = f"'every: {int(own_step / base)}'" if (own_step / base).denominator == 1 else _steps(own_step, base)
    message = f"{why}, which is no multiple of the step, {float(step):.10g} s; remedy: {remedy}"
    raise InputError(scenario.error(key, message))


_SUBSTEPS_MAX = 10_000


def sample_time(description: Any) -> Fraction | None:
    """The step that an FMU insists on, s; None where it can vary it or does not say. Raises ValueError."""
    experiment = description.defaultExperiment
    step = experiment.stepSize if experiment is not None else None
    if description.coSimulation.canHandleVariableCommunicationStepSize or step is None:
        return None
    number = float(step)
    if not 0.0 < number < math.inf:
        raise ValueError(
            f"its FMU cannot vary its step, and its stepSize is {step}, expected a finite number above 0; "
            "remedy: declare DefaultExperiment.stepSize in the FMU"
        )
    return Fraction(repr(number))


def _steps(own_step: Fraction, base: Fraction) -> str:
    fitting = [own_step / n for n in range(1, 100) if own_step / n <= base]
    return f"a base step that divides it, such as 'step: {float(fitting[0] if fitting else own_step):.10g} s'"


# ---------------------------------------------------------------- feedthrough


def _hook(prepared: Prepared, references: Mapping[str, Reference]) -> Hook:
    """Our interface's feedthrough, where an FMU declares none."""
    for name, interface in references.items():
        declared = prepared.models[name].feedthrough
        silent = {e.variable for e in interface.model.feedthrough if e in declared and declared[e] is None}
        absent = {
            v.name
            for v in prepared.models[name].of("output")
            if v.name in interface.model.variables and v.elements[0] not in declared
        }
        if silent | absent:
            prepared.notes.append(
                f"{name}: its FMU does not say on which inputs {', '.join(sorted(silent | absent))} depend directly; "
                f"what the interface {interface.name} says is taken"
            )

    def hook(block: str, element: Element) -> frozenset[Element] | None:
        interface = references.get(block)
        known = interface.model.feedthrough.get(element) if interface is not None else None
        if known is None:
            return None
        return frozenset(e for e in known if e.variable in prepared.models[block].variables)

    return hook


# ---------------------------------------------------------------- the command line


def swapped(source: Source, swaps: Sequence[str], maps: Sequence[str] = ()) -> Source:
    """A scenario's source with blocks swapped: `allocator=vendor.fmu`, and `mapping.yaml` or `allocator=mapping.yaml`."""
    files: dict[str, str] = {}
    for text in swaps:
        block, file = _parted(text, f"--swap {text}", "block=file.fmu, such as allocator=vendor.fmu")
        if block in files:
            raise InputError(f"--swap {text}: {block} is swapped twice")
        files[block] = file
    blocks = source.data.get("blocks") if isinstance(source.data, dict) else None
    mappings_of: dict[str, str] = {}
    for text in maps:
        block, _, file = text.rpartition("=")
        if not block and len(files) != 1:
            where = "the --swap that it belongs to" if not files else f"which of {', '.join(files)}: --map BLOCK={text}"
            raise InputError(f"--map {text}: expected {where}")
        block = block.strip() or next(iter(files))
        if block not in files:
            raise InputError(f"--map {text}: {block} is not swapped{hint(block, files)}")
        if block in mappings_of:
            raise InputError(f"--map {text}: {block} is mapped twice")
        mappings_of[block] = file.strip()
    for block, file in files.items():
        said = f"--swap {block}={file}"
        entry = blocks.get(block) if isinstance(blocks, dict) else None
        if not isinstance(entry, dict):
            raise InputError(f"{said}: there is no block {block!r}{hint(block, blocks or ())}")
        source = _swap(source, block, entry, file, mappings_of.get(block), said)
    return source


def _swap(source: Source, block: str, entry: dict[str, Any], file: str, map_file: str | None, said: str) -> Source:
    here = Path.cwd()
    if not is_path(file):
        raise InputError(f"{said}: expected the path of an .fmu")
    interface: Any = entry.get("interface", entry.get("fmu"))
    if "interface" not in entry and isinstance(interface, str) and is_path(interface):
        # What stands there now keeps an interface of its own, unless its name says which.
        interface = block if block in own() else str((source.folder / interface).resolve())
    values = {"fmu": str(here / Path(file).expanduser()), "interface": interface, "flavour": None}
    for key, value in values.items():
        source = source.with_entry(("blocks", block, key), value, said if value is not None else "")
    path = None if map_file is None else str(here / Path(map_file).expanduser())
    return source.with_entry(("blocks", block, "map"), path, f"--map {map_file}" if path else "")


def _parted(text: str, option: str, expected: str) -> tuple[str, str]:
    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name or not value:
        raise InputError(f"{option}: expected {expected}")
    return name, value
