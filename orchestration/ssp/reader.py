"""Reads an SSP 1.0 archive as a scenario: ours, or another tool's.

Systems within systems are laid flat. What SSP has no words for comes from our annotation; where there is none, the step
and the duration come from the archive's or the FMUs' default experiments, or from --step and --duration.
"""

from __future__ import annotations

import atexit
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .. import temporary
from ..errors import InputError, hint
from ..fmu import zipped
from ..fmu.archive import Fmu, open_fmu, shown
from ..fmu.model import Element, Variable
from ..fmu.starts import scalars_of
from ..quantities import SECOND, QuantityError, convert, value_in
from ..scenario.source import Source
from ..system.wiring import Node
from . import structure as structures
from .annotation import annotation
from .documents import inside, parsed
from .structure import End, Given, Path_, Structure
from .words import NAMESPACES, STRUCTURE


def read(path: Path) -> Source:
    """The scenario that an archive describes. Raises InputError."""
    folder = _unpacked(path)
    root = parsed(path, folder / STRUCTURE, "ssd:SystemStructureDescription")
    system = root.find("ssd:System", NAMESPACES)
    if system is None:
        raise InputError(f"{shown(path)}: {STRUCTURE} describes no system")
    structure = structures.read(path, folder, system)
    if not structure.components:
        raise InputError(f"{shown(path)}: the system has no components")
    names = _names(structure.components)
    data = annotation(path, root, names.values())
    own = data.pop("blocks", {})
    fmus = _opened(path, folder, structure.components)
    entries: dict[str, Any] = {}
    for place, fmu in fmus.items():
        start = _starts(path, place, fmu, structure, bool(data.get("delays")))
        entries[names[place]] = {
            "fmu": str(fmu.path),
            **own.get(names[place], {}),
            **({"start": start} if start else {}),
        }
    connections = list(_connections(path, structure, names, fmus))
    experiment = root.find("ssd:DefaultExperiment", NAMESPACES)
    times = _times(experiment, list(fmus.values()))
    stated = experiment is not None and experiment.get("stopTime")
    if stated and _changed(times.get("duration"), data.get("duration")):
        del data["duration"]
    scenario = times | {"name": _word(root.get("name") or path.stem)} | data
    scenario |= {"blocks": entries, "connections": connections}
    return Source(scenario, str(shown(path)), folder)


def _unpacked(path: Path) -> Path:
    """The folder of an unpacked archive, which goes when the process ends."""
    if STRUCTURE not in zipped.names(path, "SSP archive"):
        raise InputError(f"{shown(path)} is no SSP archive: it holds no {STRUCTURE}")
    kept = temporary.make("orchestrate-ssp-")
    atexit.register(temporary.remove, kept)
    zipped.unpack(path, kept, "SSP archive")
    return kept


def _opened(path: Path, folder: Path, components: dict[Path_, str]) -> dict[Path_, Fmu]:
    """The FMU of each component; those of one file are opened once."""
    fmus: dict[Path, Fmu] = {}
    places: dict[Path_, Fmu] = {}
    for place, source in components.items():
        file = inside(path, folder, source)
        try:
            places[place] = fmus[file] = fmus.get(file) or open_fmu(file)
        except InputError as error:
            raise InputError(f"{shown(path)}: {str(error).replace(str(file), source)}") from None
    return places


def _names(places: dict[Path_, str]) -> dict[Path_, str]:
    """A name of its own for each component that a scenario's block may have."""
    names: dict[str, Path_] = {}
    for place in places:
        name = base = _word("_".join(place))
        number = 1
        while name in names:
            number += 1
            name = f"{base}_{number}"
        names[name] = place
    return {place: name for name, place in names.items()}


def _word(text: str) -> str:
    word = re.sub(r"\W", "_", text) or "_"
    return f"_{word}" if word[0].isdigit() else word


def _variables(fmu: Fmu) -> dict[str, tuple[Variable, int]]:
    """Variables and positions by FMI's names."""
    known = fmu.model.variables
    elements = ((name, element) for name, _, element in scalars_of(fmu.description, fmu.model))
    return {name: (known[e.variable].at([e.position]), e.position) for name, e in elements}


def _starts(path: Path, place: Path_, fmu: Fmu, structure: Structure, delayed: bool) -> dict[str, Any]:
    """Values of the parameter sets, and the FMU's own start for an input that nothing feeds.

    An input that is fed takes the value that comes to it already at t = 0, unless there are delays.
    """
    variables = _variables(fmu)
    starts: dict[str, Any] = {}
    for name, (variable, position) in variables.items():
        if variable.causality == "input" and structure.source(End(place, name)) is None:
            value = fmu.model.starts.get(Element(variable.name, position))
            items: dict[Any, Any] = {number: item for item, number in variable.items}
            starts[variable.label(position)] = items.get(value, value)
    for name, given in structure.values.get(place, {}).items():
        if name not in variables:
            ending = hint(name, variables)
            raise InputError(f"{shown(path)}: {'.'.join(place)} has no variable {name!r}{ending}")
        variable, position = variables[name]
        fed = variable.causality == "input" and structure.source(End(place, name)) is not None
        if variable.causality == "parameter" or (variable.causality == "input" and (delayed or not fed)):
            try:
                starts[variable.label(position)] = start_value(given, variable)
            except (ValueError, OverflowError) as error:
                value = f"the value {given.value!r} of {'.'.join(place)}.{name}"
                raise InputError(f"{shown(path)}: {value}: {error}") from None
    return starts


def start_value(given: Given, variable: Variable) -> Any:
    """A value of a parameter set as a scenario has it. Raises ValueError."""
    if given.kind == "Boolean":
        return given.value in ("true", "1")
    if given.kind in ("Integer", "Real") and variable.type == "enumeration":
        return {number: item for item, number in variable.items}.get(int(float(given.value)), given.value)
    if given.kind == "Integer":
        return int(given.value)
    if given.kind == "Real":
        number = float(given.value)
        if given.unit is None or variable.unit is None or given.unit.name == variable.unit.name:
            return number
        return convert(number, given.unit, variable.unit)
    return given.value


def _connections(path: Path, structure: Structure, names: dict[Path_, str], fmus: dict[Path_, Fmu]) -> Iterator[str]:
    """One for each element, in the order of the inputs."""
    variables = {place: _variables(fmu) for place, fmu in fmus.items()}
    for place in fmus:
        for name in dict.fromkeys(end.connector for end in structure.flows if end.element == place):
            feed = structure.source(End(place, name))
            if feed is None or (structure.kinds.get(End(place, name)) == "output"):
                continue
            source, factor, offset, suppressed = feed
            ends = []
            for owner, connector in (source, End(place, name)):
                if connector not in variables[owner]:
                    ending = hint(connector, variables[owner])
                    raise InputError(f"{shown(path)}: {'.'.join(owner)} has no variable {connector!r}{ending}")
                variable, position = variables[owner][connector]
                ends.append((Node(names[owner], Element(variable.name, position)), variable))
            text = " -> ".join(f"{node.block}.{v.label(node.element.position)}" for node, v in ends)
            _check_transformation(path, text, ends[0][1], ends[1][1], (factor, offset), suppressed)
            yield text


def _check_transformation(
    path: Path, text: str, source: Variable, target: Variable, asked: tuple[float, float], suppressed: bool
) -> None:
    """A scenario converts units and no more: a transformation must be that, or none."""
    converted = (1.0, 0.0)
    if source.unit is not None and target.unit is not None and source.unit.fits(target.unit):
        converted = source.unit.conversion(target.unit)
    wanted = converted if suppressed or asked != (1.0, 0.0) else (1.0, 0.0)
    if any(abs(a - b) > 1e-12 * abs(b) for a, b in zip(asked, wanted, strict=True)):
        raise InputError(
            f"{shown(path)}: {text} has the factor {asked[0]:g} and the offset {asked[1]:g}, which is no "
            "conversion of its units; orchestrate converts units only"
        )


def _changed(stated: float | None, annotated: Any) -> bool:
    """Returns whether a tool has given the archive another duration than the annotation's; not where that counts
    cycles.
    """
    if stated is None or annotated is None:
        return False
    try:
        duration = value_in(annotated, SECOND)
    except QuantityError:
        return False
    return not abs(stated - duration) <= 1e-9 * abs(duration)


def _times(experiment: Any | None, fmus: list[Fmu]) -> dict[str, float]:
    """Step and duration, as far as archive or FMUs say them."""
    times = {}
    own = [fmu.description.defaultExperiment for fmu in fmus if fmu.description.defaultExperiment is not None]
    steps = [float(e.stepSize) for e in own if e.stepSize]
    if steps:
        times["step"] = min(steps)
    stops = [float(e.stopTime) for e in own if e.stopTime]
    if experiment is not None and experiment.get("stopTime"):
        stops = [float(experiment.get("stopTime", "0")) - float(experiment.get("startTime", "0"))]
    if stops:
        times["duration"] = max(stops)
    return times
