"""Which port of another team's FMU stands for which of ours, and what does not fit.

`fit` finds everything that can be known without running anything. `orchestrate check` prints it, and a
swap refuses to run where it holds an error, so the two never disagree.
"""

from __future__ import annotations

from ..errors import hint
from ..fmu.interfaces import Interface
from ..fmu.model import Element, Model, NameUnknown, Variable
from ..scenario.mapping import Mapping, PortMap
from ..scenario.references import Name
from .conversion import affine, change, quaternion, three
from .findings import Fit, Misfit, may_stay_unconnected, named
from .leftover import extra, lacking


def fit(reference: Interface, theirs: Model, mapping: Mapping | None = None) -> Fit:
    """Finds what of theirs stands for what of ours, and says of everything whether it fits."""
    fitted = Fit(reference, theirs, mapping)
    mapping = mapping or Mapping()
    _ignored(fitted, mapping)
    taken: dict[Element, str] = {}
    for name, entry in mapping.ports.items():
        _mapped(fitted, name, entry, taken)
    for name, ours in reference.model.variables.items():
        if name in mapping.ports or name in fitted.ignored or ours.causality not in ("input", "output", "parameter"):
            continue
        same = theirs.named(name)
        if same is None or any(element in taken for element in same.elements):
            lacking(fitted, ours, taken)
        else:
            _link(fitted, ours, tuple(same.elements), PortMap(theirs=[Name(name)], inverse=False), (), taken)
    _connected(fitted, mapping, taken)
    extra(fitted, mapping, taken)
    return fitted


def _ignored(fitted: Fit, mapping: Mapping) -> None:
    known = fitted.reference.model.variables
    for number, name in enumerate(mapping.ignore):
        key = ("ignore", number)
        if name not in known:
            fitted.say(
                "error",
                "mapping",
                f"the interface {fitted.reference.name} has no {name!r}{hint(name, known)}",
                key=key,
            )
        elif name in mapping.ports:
            fitted.say("error", "mapping", f"{name} is both mapped and ignored", "leave it out of one of the two", key)
        else:
            ours = known[name]
            fitted.ignored[name] = ours
            what = {
                "input": "what flows there reaches no one",
                "output": "it is not there for others, records and expectations",
            }.get(ours.causality, "its value in a scenario is not handed on")
            fitted.say("note", "ignored", f"{ours.causality} {name} is ignored, as the mapping says: {what}")


def _mapped(fitted: Fit, name: str, entry: PortMap, taken: dict[Element, str]) -> None:
    key = ("ports", name)
    known = fitted.reference.model.variables
    if name not in known:
        text = f"the interface {fitted.reference.name} has no {name!r}{hint(name, known)}"
        fitted.say("error", "mapping", text, "the names of the interface stand on the left", key)
        return
    elements: list[Element] = []
    for theirs in entry.theirs:
        try:
            elements += _elements(fitted.theirs, theirs)
        except NameUnknown as error:
            fitted.say("error", "mapping", str(error), key=(*key, "theirs"))
            return
    _link(fitted, known[name], tuple(elements), entry, key, taken)
    for element in elements:  # one finding, if it does not fit
        taken.setdefault(element, name)


def _connected(fitted: Fit, mapping: Mapping, taken: dict[Element, str]) -> None:
    """Takes what the mapping connects to inputs that only theirs has. Whether it is there, the wiring finds."""
    seen: set[Element] = set()
    for name, signal in mapping.inputs.items():
        key = ("inputs", name)
        try:
            elements = _elements(fitted.theirs, name)
        except NameUnknown as error:
            fitted.say("error", "mapping", str(error), key=key)
            continue
        variable = fitted.theirs.variables[elements[0].variable]
        ours = next((taken[element] for element in variable.elements if element in taken), None)
        if variable.causality != "input":
            text = f"{variable.name} is of causality {variable.causality}, expected input"
            fitted.say("error", "causality", text, "connect an input of theirs", key)
        elif ours is not None:
            text = f"{variable.name} stands for our {ours}, whose signal it takes"
            fitted.say(
                "error", "mapping", text, f"leave it out of ports or of inputs, or connect {ours} in the scenario", key
            )
        elif seen.intersection(elements):
            fitted.say("error", "mapping", f"{name} is connected more than once", "connect each of theirs once", key)
        else:
            fitted.fed[name] = signal
            seen.update(elements)


def _elements(model: Model, name: Name) -> list[Element]:
    if name in model.variables:
        return model.variables[name].elements
    variable, positions = model.find("", name.variable, name.indices)
    return [Element(variable.name, position) for position in positions]


def _link(
    fitted: Fit,
    ours: Variable,
    elements: tuple[Element, ...],
    entry: PortMap,
    key: tuple[str, ...],
    taken: dict[Element, str],
) -> None:
    theirs = [fitted.theirs.variables[element.variable] for element in elements]
    names = named(fitted.theirs, elements)
    label = f"{ours.causality} {ours.name}" + (f" = {names}" if names != ours.name else "")
    settable = ours.causality == "parameter" and ours.variability == "tunable"
    for variable in theirs:
        if settable and variable.causality == "input":
            text = f"{label}: {variable.name} is an input, which keeps its start value unless it is connected"
            fitted.say("note", "causality", text)
        elif variable.causality != ours.causality:
            text = f"{label}: {variable.name} is of causality {variable.causality}, expected {ours.causality}"
            return fitted.say("error", "causality", text, "map it to another variable, or change the FMU", key)
        if ours.type == "enumeration" and variable.type == "integer":
            text = f"{label}: {variable.name} is integer, and takes the numbers of the items: {ours.items_text}"
            fitted.say("note", "type", text, "check that theirs are the same")
            continue
        if variable.type != ours.type:
            text = f"{label}: {variable.name} is {variable.type}, expected {ours.type}"
            return fitted.say("error", "type", text, "change the type in the FMU", key)
        if variable.items != ours.items:
            text = f"{label}: the items differ, {variable.items_text}, expected {ours.items_text}"
            return fitted.say("error", "type", text, "give the enumeration of the FMU these items", key)
    if ours.causality != "output" and (twice := next((e for e in elements if e in taken), None)):
        label_twice = fitted.theirs.variables[twice.variable].label(twice.position)
        return fitted.say("error", "mapping", f"{label}: {label_twice} already stands for {taken[twice]}", key=key)
    if repeated := next((e for i, e in enumerate(elements) if e in elements[:i]), None):
        text = f"{label}: {named(fitted.theirs, (repeated,))} is named more than once"
        return fitted.say("error", "mapping", text, "name each of theirs once", key)
    if ours.type != "real" and any(
        getattr(entry, name) is not None
        for name in ("unit", "scale", "divide", "matrix", "offset", "quaternion", "rotation", "turn")
    ):
        return fitted.say("error", "mapping", f"{label}: only real variables are converted; it is {ours.type}", key=key)
    try:
        link = (
            quaternion(fitted, ours, elements, entry)
            if entry.quaternion
            else three(fitted, ours, elements, entry)
            if entry.rotation
            else affine(fitted, ours, elements, entry, label)
        )
    except Misfit as error:
        return fitted.say("error", error.topic, f"{label}: {error}", error.remedy, key)
    if ours.causality == "output" and link.A is not None and link.B is None:
        text = f"{label}: ours cannot be fitted from theirs, since the matrix has no inverse that keeps its digits"
        return fitted.say("error", "mapping", text, "give a square matrix of full rank", key)
    fitted.links[ours.name] = link
    taken.update(dict.fromkeys(elements, ours.name))
    fitted.say("ok", "port", f"{label}, {ours.kind}{change(ours, theirs, link)}")
    if ours.optional and not may_stay_unconnected(fitted, link):
        text = f"{label}: optional in ours, but theirs does not say that it may stay unconnected"
        fitted.say("note", "optional", text, "connect it in the scenario, or give it a value under start there")
    return None
