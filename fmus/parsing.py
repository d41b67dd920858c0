"""Reads an interface from its TOML file.

Longer than 250 lines: the description of the format stands here, beside what reads it.

The TOML file
-------------
`[block]` has `name` and `description`, `flavours` where there is one only: `["native"]`, `derivatives = true` where its
FMU of FMI 3.0 gives them, and `sampled = false` where the block has no instants of its own; any other gets the
parameter `sample_period`, its last variable, which stands in no file. `[experiment]` has `stop` and `step`, in seconds.
Each `[variables.NAME]` has

- `causality`: "input", "output" or "parameter";
- `type`: "real" (the default), "integer", "boolean", "string" or "enumeration" (with `items`);
- `shape`: nothing for a scalar, `[n]` or `[rows, columns]`; elements are named in FMI's structured
  way, one-based and row-major: `omega_B[1]`, `R_NB[2,3]`;
- `unit`, `display_unit`: units by their names (`A.m2`); none means dimensionless; where the elements differ, `unit` is
  a list of the variable's shape, with a unit for each element, and there is no `display_unit`;
- `nominal`: its usual size in that unit where that is far from 1, or a list of the variable's shape;
- `frame`: the frame of its components;
- `variability`: of a parameter, "fixed" or "tunable";
- `start` (inputs and parameters), `min`, `max`; those of an input are told to tools, and the block refuses in words of
  its own what it cannot take; an optional input with a limit has 1e9, its start, as its `max`;
- `optional` (inputs): `true` where it may stay unconnected; its start is then 1e9 in every element, and a magnitude of
  0.999e9 or more in any element means that it is not connected; an integer starts at -1, and a negative one means it;
- `quantity` (parameters): the quantity that it states, where the blocks of a loop should agree in it;
- `steps` (parameters in s): how many steps of its block the time has to be, "whole" (a whole number) or "at least one";
- `depends_on` (outputs): the inputs with direct feedthrough;
- `initially_depends_on` (outputs): the inputs and parameters that its initial value depends on;
- `each`: the name of a set, such as "wheel", of whose parts each has this variable: one in the block as it stands;
- `only`: the name of a set in whose block alone this variable is, such as the number of parts.

`[sets.NAME]` describes a second block of the same code, for a set of parts instead of one: `block`, its name, `count`,
the largest number of parts, and `description`. Its interface is that of the file with `set = "NAME"` in `[block]`:
there a variable with `each` has `count` as its first dimension and depends on the elements of the same index of others
with `each`; its terminal is `NAME_of_wheels`. In the block for one part names with `only` fall out of dependencies.

`[helpers.NAME]` is an input for scenarios that stands for start values of parameters and is in no FMU: `type`, `shape`,
`unit`, `display_unit`, `frame`, `min`, `max`, `description`, and `gives`, the parameter that follows. The function NAME
in the block's module `inputs` works them out.

`[cycles.NAME.PARAMETER]` says how long one of what a scenario's `cycle` of this NAME counts lasts, in s: by the item of
an enumeration, an expression of parameters in SI units.

`[terminals]` groups the ports that are wired together: a terminal's name and its variables, all inputs or all outputs;
terminals of one name fit each other. `[view]` has what a three-dimensional view of a loop takes of this block: the keys
of a scenario's `view`, with names of variables, and `lvlh_by`, a parameter whose item "lvlh" says that the desired
attitude is LVLH. `[page]` has what only a reader needs: `equations`, each with its meaning, and `limits`.

In the two lists of dependencies `name` means every element (of a set's part: those of the same part), `name[:]` those
of all parts, `name[i]` the element of the same index, `name[i,:]` and `name[:,i]` the row and the column of a matrix
that the output's first index names, and `@group` the names that `[groups]` gives for it.
Tests: tests/fmus/test_rules.py.
"""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import replace
from typing import Any

from .part_sets import for_set, terminals_for
from .variables import FLAVOURS, STEPS, Causality, Cycle, Element, Interface, InterfaceError, Type, Variable

ABSENT = 1e9
"""The start of every optional real input, which means that it is not connected."""
ABSENT_INTEGER = -1
"""The same of every optional integer input; any negative value means so."""
ABSENT_MIN = 0.999e9
"""An optional input with an element of this magnitude is not connected: a host may have rounded its start."""
SAMPLE_PERIOD = "sample_period"
"""The parameter of every sampled block, which its FMU's shell acts on."""
_SAMPLE_PERIOD = {
    "causality": "parameter",
    "variability": "fixed",
    "unit": "s",
    "start": 0.0,
    "min": 0.0,
    "description": "The block acts each so many seconds after the start, at the communication point that reaches the "
    "instant, and holds its outputs in between; 0: in each step",
}


def parse(text: str, file: str = "<interface>") -> Interface:
    """Reads an interface from TOML text. `file` is named in errors. Raises InterfaceError."""
    import tomllib  # takes 7 ms and is seldom needed, since interfaces are kept  # noqa: PLC0415

    data = tomllib.loads(text)
    sets: dict[str, dict[str, Any]] = data.get("sets", {})
    chosen: str | None = data["block"].get("set")
    try:
        entries = for_set(data["variables"], sets, chosen, data.get("groups", {}))
    except InterfaceError as error:
        raise InterfaceError(f"{file}: {error}") from None
    variables: dict[str, Variable] = {}
    reference = 0
    for name, entry in entries.items():
        try:
            variable = _variable(name, entry, reference)
        except InterfaceError as error:
            raise InterfaceError(f"{file}: variables.{name}: {error}") from None
        variables[name] = variable
        reference += len(variable.elements)
    if data["block"].get("sampled", True):
        if SAMPLE_PERIOD in variables:
            raise InterfaceError(f"{file}: variables.{SAMPLE_PERIOD}: every sampled block has it; leave it out")
        variables[SAMPLE_PERIOD] = replace(_variable(SAMPLE_PERIOD, _SAMPLE_PERIOD, reference), of_shell=True)
    _check_dependencies(variables, file)
    return Interface(
        name=sets[chosen]["block"] if chosen else data["block"]["name"],
        description=(sets[chosen] if chosen else data["block"])["description"],
        code=data["block"]["name"],
        sets={name: entry["count"] if name == chosen else 1 for name, entry in sets.items()},
        stop=float(data["experiment"]["stop"]),
        step=float(data["experiment"]["step"]),
        variables=variables,
        source=text,
        terminals=terminals_for(_terminals(data, variables, file), variables, chosen),
        equations=tuple((formula, meaning) for formula, meaning in data.get("page", {}).get("equations", ())),
        limits=tuple(data.get("page", {}).get("limits", ())),
        flavours=_flavours(data["block"], file),
        helpers=_helpers(data.get("helpers", {}), variables, file),
        cycles=_cycles(data.get("cycles", {}), variables, file),
        derivatives=data["block"].get("derivatives", False),
        view=data.get("view", {}),
    )


def _flavours(block: dict[str, Any], file: str) -> tuple[str, ...]:
    found = block.get("flavours", FLAVOURS)
    if not isinstance(found, (list, tuple)) or not found or not set(found) <= set(FLAVOURS):
        raise InterfaceError(f"{file}: block.flavours: expected a list of {', '.join(FLAVOURS)}, found {found!r}")
    return tuple(found)


_KEYS = (
    "causality type shape unit display_unit nominal frame variability optional quantity steps start min max items "
    "description depends_on initially_depends_on each"
).split()


def _variable(name: str, entry: dict[str, Any], reference: int) -> Variable:
    if unknown := [key for key in entry if key not in _KEYS]:
        raise InterfaceError(f"unknown key {unknown[0]!r}; expected one of {', '.join(_KEYS)}")
    causality: Causality = entry["causality"]
    kind: Type = entry.get("type", "real")
    shape = tuple(entry.get("shape", ()))
    items = tuple(entry.get("items", ()))
    start = entry.get("start")
    if (start is None) != (causality == "output"):
        raise InterfaceError("inputs and parameters need a start value, outputs have none")
    indices = list(itertools.product(*(range(1, n + 1) for n in shape)))
    starts = _flatten(start, shape) if start is not None else [None] * len(indices)
    if kind == "enumeration" and start is not None:
        if start not in items:
            raise InterfaceError(f"start {start!r} is none of its items {', '.join(items)}")
        starts = [items.index(start) + 1]
    optional = entry.get("optional", False)
    absent = ABSENT_INTEGER if kind == "integer" else ABSENT
    if optional and (causality != "input" or kind not in ("real", "integer") or set(starts) != {absent}):
        raise InterfaceError(
            f"only a real or integer input may be optional, and its start is {absent:g} in every element"
        )
    if "quantity" in entry and causality != "parameter":
        raise InterfaceError(
            f"only a parameter states a quantity, found one of {entry['quantity']!r} at an {causality}"
        )
    if (steps := entry.get("steps")) is not None and (
        steps not in STEPS or causality != "parameter" or shape or entry.get("unit") != "s"
    ):
        raise InterfaceError(
            f"steps: expected {' or '.join(map(repr, STEPS))} at a scalar parameter in s, found {steps!r}"
        )
    default = "continuous" if kind == "real" else "discrete"
    return Variable(
        name=name,
        causality=causality,
        type=kind,
        variability=entry["variability"] if causality == "parameter" else default,
        description=entry["description"],
        shape=shape,
        units=_units(entry, shape, len(indices)),
        display_unit=entry.get("display_unit"),
        nominals=_nominals(entry, kind, shape, len(indices)),
        frame=entry.get("frame"),
        start=start,
        min=entry.get("min"),
        max=entry.get("max"),
        items=items,
        elements=tuple(
            Element(element_name(name, index), reference + i, value)
            for i, (index, value) in enumerate(zip(indices, starts, strict=True))
        ),
        depends_on=tuple(entry.get("depends_on", ())),
        initially_depends_on=tuple(entry.get("initially_depends_on", ())),
        optional=optional,
        quantity=entry.get("quantity"),
        steps=steps,
        each=entry.get("each"),
    )


def _helpers(entries: dict[str, Any], variables: dict[str, Variable], file: str) -> dict[str, Variable]:
    helpers: dict[str, Variable] = {}
    for name, entry in entries.items():
        start: Any = 0.0
        for length in reversed(entry.get("shape", ())):
            start = [start] * length
        try:
            if name in variables:
                raise InterfaceError("a variable has this name")
            if (gives := entry.get("gives")) not in variables or variables[gives].causality != "parameter":
                raise InterfaceError(f"gives: expected a parameter, found {gives!r}")
            stated = {key: value for key, value in entry.items() if key != "gives"}
            stated |= {"causality": "parameter", "variability": "fixed", "start": start}
            variable = _variable(name, stated, 0)
            helpers[name] = replace(variable, gives=gives, description=f"{variable.description}: gives {gives}")
        except InterfaceError as error:
            raise InterfaceError(f"{file}: helpers.{name}: {error}") from None
    return helpers


def _cycles(entries: dict[str, Any], variables: dict[str, Variable], file: str) -> dict[str, Cycle]:
    cycles: dict[str, Cycle] = {}
    for name, entry in entries.items():
        ((by, periods),) = entry.items()
        items = variables[by].items if by in variables else ()
        if set(periods) != set(items):
            raise InterfaceError(f"{file}: cycles.{name}.{by}: expected the items of an enumeration, found {periods}")
        uses = frozenset(re.findall(r"[a-zA-Z]\w*", " ".join(periods.values()))) & variables.keys()
        cycles[name] = Cycle(by, periods, uses | {by})
    return cycles


def _units(entry: dict[str, Any], shape: tuple[int, ...], size: int) -> tuple[str | None, ...]:
    unit = entry.get("unit")
    if not isinstance(unit, list):
        return (unit,) * size
    if "display_unit" in entry:
        raise InterfaceError("a variable whose elements have units of their own has no display_unit")
    return tuple(_flatten(unit, shape, "unit"))


def _nominals(entry: dict[str, Any], kind: Type, shape: tuple[int, ...], size: int) -> tuple[float | None, ...]:
    nominal = entry.get("nominal")
    if nominal is None:
        return (None,) * size
    found = _flatten(nominal, shape, "nominal") if isinstance(nominal, list) else [nominal] * size
    if kind != "real" or not all(isinstance(value, float) and 0.0 < value < math.inf for value in found):
        raise InterfaceError(f"nominal: expected a real variable's size, a finite number above 0, found {nominal!r}")
    return tuple(found)


def element_name(name: str, index: tuple[int, ...]) -> str:
    """FMI's structured name of an element: `element_name("R_NB", (2, 3))` is `R_NB[2,3]`."""
    return f"{name}[{','.join(map(str, index))}]" if index else name


def _flatten(value: Any, shape: tuple[int, ...], key: str = "start") -> list[Any]:
    if not shape:
        if isinstance(value, list):
            raise InterfaceError(f"{key}: expected one value, since there is no shape, found {value!r}")
        return [value]
    if not isinstance(value, list) or len(value) != shape[0]:
        raise InterfaceError(f"{key}: expected the shape {list(shape)}, found {value!r}")
    return [leaf for item in value for leaf in _flatten(item, shape[1:], key)]


def _check_dependencies(variables: dict[str, Variable], file: str) -> None:
    for variable in variables.values():
        for key, allowed in (("depends_on", {"input"}), ("initially_depends_on", {"input", "parameter"})):
            for name in getattr(variable, key):
                base = variables.get(name.partition("[")[0])
                index = name.partition("[")[2]
                if base is not None and not _index_fits(index, base.shape, variable.shape):
                    raise InterfaceError(
                        f"{file}: variables.{variable.name}: {key}: {name!r} does not fit the shapes "
                        f"{list(base.shape)} and {list(variable.shape)}; expected [i], or [i,:] or [:,i] of a matrix"
                    )
                if base is None or base.causality not in allowed:
                    raise InterfaceError(
                        f"{file}: variables.{variable.name}: {key}: {name!r} is no {' or '.join(sorted(allowed))}"
                    )


def _index_fits(index: str, known: tuple[int, ...], output: tuple[int, ...]) -> bool:
    if index == "i]":
        return known == output
    if index in ("i,:]", ":,i]"):
        return len(known) == 2 and bool(output) and output[0] == known[0 if index == "i,:]" else 1]
    return not index


def _terminals(data: dict[str, Any], variables: dict[str, Variable], file: str) -> dict[str, tuple[str, ...]]:
    only_of_others = data["variables"].keys() - variables.keys()
    entries = {n: members for n, members in data.get("terminals", {}).items() if not only_of_others.issuperset(members)}
    for name, members in entries.items():
        causalities = {variables[member].causality if member in variables else "missing" for member in members}
        if causalities not in ({"input"}, {"output"}):
            raise InterfaceError(
                f"{file}: terminals.{name}: {', '.join(members)}: expected inputs only or outputs only"
            )
    return {name: tuple(members) for name, members in entries.items()}
