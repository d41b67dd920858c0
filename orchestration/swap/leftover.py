"""Ports that only one side has: ours that theirs lacks, and theirs that stand for none of ours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fmus.interface import SAMPLE_PERIOD

from ..errors import hint, nearest
from ..fmu.model import Element, NameUnknown, Variable
from ..quantities import ONE, QuantityError
from ..scenario.mapping import Mapping as PortMapping
from ..scenario.references import Name
from ..system.values import values_of
from .conversion import NO_MEMORY, is_rate
from .findings import Fit, named


def lacking(fitted: Fit, ours: Variable, taken: Mapping[Element, str]) -> None:
    if ours.name == SAMPLE_PERIOD:  # of our FMUs' shell; theirs acts in each of its steps
        fitted.missing[ours.name] = ours
        return
    gone = {*fitted.reference.model.variables, *(element.variable for element in taken)}
    free = [v for v in fitted.theirs.of(ours.causality) if v.name not in gone]
    match = nearest(ours.name, (v.name for v in free))
    meant = [match] if match else []
    alike = [v.name for v in free if v.type == ours.type and v.size == ours.size and _unit_fits(ours, v)]
    meant += [name for name in alike if name not in meant]
    key = f"'{ours.name}: {match or 'THEIRS'}' under ports in the mapping"
    kind = f"{ours.kind}" + (f" in {ours.unit}" if str(ours.unit or ONE) != "1" else "")
    text = f"{ours.causality} {ours.name}, {kind}, is missing"
    signals = free if ours.causality != "parameter" else []
    if meant:
        text += f"; by name or unit it may be {' or '.join(meant[:3])}"
    elif rates := [v for v in signals if v.size == ours.size and is_rate(ours.unit or ONE, v.unit or ONE)]:
        text += f"; {rates[0].name}, in {rates[0].unit}, cannot stand for it: {NO_MEMORY}"
    if ours.optional:
        fitted.without[ours.name] = ours
        text = f"{text}, which is optional: theirs runs without it, and a scenario's connection to it is dropped"
        fitted.say("note", "optional", text, f"none needed, or {key}")
    elif ours.causality == "input":
        fitted.candidates.update(meant)
        fitted.say("error", "missing", text, f"{key}; or list it under ignore, if their FMU does not need it")
    if ours.causality == "input":
        return
    fitted.missing[ours.name] = ours
    if ours.causality == "output" and ours.name in fitted.reference.needed:
        fitted.say("error", "missing", f"{text}; other blocks need it", key)
    elif ours.causality == "output":
        fitted.say("note", "missing", f"{text}; no other block needs an input of its name", f"none needed, or {key}")
    else:
        text += "; a scenario that gives it a value is refused"
        fitted.say("note", "missing", text, f"none needed, or {key}, or list it under ignore")


def _unit_fits(ours: Variable, theirs: Variable) -> bool:
    if ours.type != "real" or str(ours.unit or ONE) == "1" or theirs.unit is None:
        return False
    return (ours.unit or ONE).fits(theirs.unit)


def extra(fitted: Fit, mapping: PortMapping, taken: Mapping[Element, str]) -> None:
    ours = fitted.reference.model.variables
    known = fitted.theirs.variables
    for name, value in mapping.start.items():
        variable = known.get(name) or known.get(name.variable)
        key = ("start", name)
        if variable is None or variable.causality not in ("input", "parameter"):
            names = (v.name for v in fitted.theirs.of("input", "parameter"))
            fitted.say(
                "error", "mapping", f"their FMU has no input or parameter {name!r}{hint(name.variable, names)}", key=key
            )
        else:
            _started(fitted, variable, name, value, taken)
    fed = fitted.feeding
    partial: dict[str, list[str]] = {}
    for variable in fitted.theirs.of("input", "output", "parameter"):
        left = [e for e in variable.elements if e not in taken and e not in fitted.start]
        if not left:
            continue
        if len(left) < variable.size and variable.name not in fitted.ignored:
            label = named(fitted.theirs, left)
            if variable.causality == "input":
                text = (
                    f"input{_s(left)} {label} {'are' if len(left) > 1 else 'is'} only in their FMU, and nothing feeds "
                )
                text += "them" if len(left) > 1 else "it"
                remedy = f"give a value under start in the mapping, such as '{label.split()[0]}: 0', or map the whole"
                fitted.say("error", "elements", text, remedy)
            else:
                partial.setdefault(variable.causality, []).append(label)
            continue
        if variable.name in ours:
            if variable.name in fitted.links or variable.name in fitted.ignored:
                text = f"their {variable.causality} {variable.name} has the name of ours, but is not mapped to it"
                fitted.say("note", "extra", text, "none needed, if that is meant")
            continue
        fitted.extra.append(variable)
        if variable.name in fed:
            feeds = f"{fed[variable.name].whole} feeds it, as the mapping says"
            fitted.say("ok", "extra", f"input {variable.name}, {variable.kind}, is only in their FMU; {feeds}")
        elif variable.optional:
            text = f"input {variable.name}, {variable.kind}, is only in their FMU, and optional"
            fitted.say("note", "extra", text, "none needed, or connect it in the scenario")
        elif variable.causality == "input" and variable.name not in fitted.candidates:
            text = f"input {variable.name}, {variable.kind}, is only in their FMU, and nothing feeds it"
            remedy = f"give it a value under start in the mapping, or connect it: {_connection(fitted, variable)}"
            fitted.say("error", "extra", text, remedy)
    outputs = [f"{v.name}, {v.kind}" for v in fitted.extra if v.causality == "output"]
    if outputs:
        text = f"output{_s(outputs)} only in their FMU: {'; '.join(outputs)}"
        fitted.say("note", "extra", text, "none needed; they are recorded under these names")
    if "output" in partial:
        text = f"elements of outputs that stand for nothing of ours: {', '.join(partial['output'])}"
        fitted.say("note", "extra", text, "none needed; they are not recorded")
    parameters = [v.name for v in fitted.extra if v.causality == "parameter"] + partial.get("parameter", [])
    if parameters:
        text = f"parameter{_s(parameters)} only in their FMU, at its own values: {', '.join(parameters)}"
        fitted.say("note", "extra", text, "other values, if they are wanted, under start in the mapping")


def _started(fitted: Fit, variable: Variable, name: Name, value: Any, taken: Mapping[Element, str]) -> None:
    """Takes a start value of the mapping, unless it is for what ours give a value."""
    key = ("start", name)
    try:
        values = values_of("theirs", fitted.theirs, name, value)
    except (QuantityError, NameUnknown) as error:
        return fitted.say("error", "mapping", f"{name}, under start: {error}", key=key)
    if (signal := fitted.feeding.get(variable.name)) is not None:
        text = f"{signal} feeds {variable.name}, as inputs in the mapping says"
        return fitted.say("error", "mapping", text, "leave it out of start or of inputs", key)
    standing = [element for element in values if element in taken]
    if standing:
        port = taken[standing[0]]
        label = name if len(standing) == len(values) else named(fitted.theirs, standing)
        text = f"{label} stands for our {port}, whose value it takes"
        return fitted.say("error", "mapping", text, f"give the value to {port} in the scenario", key)
    fitted.start.update(values)
    return fitted.say("ok", "extra", f"{variable.causality} {name} of theirs is {value}, as the mapping says")


def _connection(fitted: Fit, variable: Variable) -> str:
    """Returns how a mapping connects an input: to the output of a similar name, or else with those named that have its
    unit and shape.
    """
    outputs = ((block, v) for block, kind in fitted.reference.others.items() for v in kind.of("output"))
    alike = {
        v.name: f"{block}.{v.name}" for block, v in outputs if v.shape == variable.shape and _unit_fits(v, variable)
    }
    match = nearest(variable.name, alike)
    text = f"'inputs: {{{variable.name}: {alike[match] if match else 'BLOCK.OUTPUT'}}}' there"
    if match or not alike:
        return text
    names = list(alike.values())[:3]
    return f"{text}; {', '.join(names)} {'have' if len(names) > 1 else 'has'} its unit and shape"


def _s(items: Sequence[Any]) -> str:
    return "s" if len(items) > 1 else ""
