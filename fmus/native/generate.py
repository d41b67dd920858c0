"""C from an interface: the structures that the laws see, and the table of ports that the shell reads.

Every build writes them anew into a folder of its own. `python -m fmus.native FOLDER` writes those that flight software
and editors need. Tests: tests/native/test_linking.py.
"""

from __future__ import annotations

import itertools
import textwrap

from ..contents.description3 import parts
from ..interface import ABSENT_MIN, Element, Interface, InterfaceError, Variable, citations, optional_text
from ..variables import Causality

TEXT_SIZE = 128
"""Bytes of a string's buffer, its ending zero included."""

_RECORDS: dict[Causality, tuple[str, str]] = {
    "parameter": ("Parameters", "p"),
    "input": ("Inputs", "u"),
    "output": ("Outputs", "y"),
}
_C_TYPES = {"real": "double", "integer": "int32_t", "enumeration": "int32_t", "boolean": "bool", "string": "char"}


def camel_case(block: str) -> str:
    """A block's name as its C types begin: `AllocatorBounded`."""
    return block.title().replace("_", "")


def ports_header(interface: Interface, source: str | None = None) -> dict[str, str]:
    """Returns the header with the block's parameters, inputs and outputs as structures and its enumerations, by its
    file's name. It names its source: by default the file in fmus/interfaces."""
    name = interface.code
    source = source or f"fmus/interfaces/{name}.toml"
    optional = [v for v in interface.of("input") if v.optional]
    cited = "".join(f" * {line}\n" for line in textwrap.wrap(citations(interface), 110))
    math_h = "#include <math.h>\n" if optional else ""
    parts = [
        f"/* {interface.description}.\n{cited} * Generated from {source}; do not edit. */",
        f"#ifndef {name.upper()}_PORTS_H\n#define {name.upper()}_PORTS_H\n",
        f"{math_h}#include <stdbool.h>\n#include <stdint.h>\n",
    ]
    for part, count in interface.sets.items():
        parts.append(f"/* The most {part}s that there can be. */\n#define {_count(interface, part)} {count}\n")
    parts += [_enumeration(name, v) for v in interface.variables.values() if v.type == "enumeration"]
    for causality, (record, _) in _RECORDS.items():
        members = "\n".join(_member(interface, v) for v in interface.of(causality))
        parts.append(f"typedef struct {{\n{members}\n}} {camel_case(name)}{record};\n")
    if optional:
        limit = f"{name.upper()}_ABSENT_MIN"
        parts.append(
            f"/* An optional input is not connected where an element is this large. */\n#define {limit} "
            f"{ABSENT_MIN!r}\n"
        )
        parts += [_connected(interface, v, limit) for v in optional]
    return {f"{name}_ports.h": "\n".join(parts) + "\n#endif\n"}


def _enumeration(block: str, variable: Variable) -> str:
    prefix = f"{block}_{variable.name}_".upper()
    items = ",\n".join(f"    {prefix}{item.upper()} = {i}" for i, item in enumerate(variable.items, start=1))
    return f"enum {{\n{items}\n}};\n"


def _count(interface: Interface, part: str) -> str:
    """The constant that says of how many parts the block's structures have place: PLANT_WHEELS."""
    return f"{interface.code}_{part}s".upper()


def shape_in_c(interface: Interface, variable: Variable) -> tuple[int, ...]:
    """Returns the shape of its member in the structure. That of one part, too, stands in an array, so that the C has
    one form.
    """
    return (1, *variable.shape) if interface.sets.get(variable.each or "") == 1 else variable.shape


def members_of(interface: Interface, variable: Variable) -> list[str]:
    """A variable's elements in the structure."""
    indices = itertools.product(*(range(n) for n in shape_in_c(interface, variable)))
    return [variable.name + "".join(f"[{i}]" for i in index) for index in indices]


def _connected(interface: Interface, variable: Variable, limit: str) -> str:
    """Returns whether an optional input is connected; NaN is, so that the block refuses it as it does in any other
    input.
    """
    block = interface.code
    members = [f"u->{member}" for member in members_of(interface, variable)]
    is_absent = "{} < 0" if variable.type == "integer" else f"fabs({{}}) >= {limit}"
    absent = " ||\n             ".join(map(is_absent.format, members))
    head = f"static inline bool {block}_has_{variable.name}(const {camel_case(block)}Inputs *u)"
    return f"{head}\n{{\n    return !({absent});\n}}\n"


def _member(interface: Interface, variable: Variable) -> str:
    shape: list[int | str] = list(variable.shape)
    if variable.each is not None:
        shape[: interface.sets[variable.each] > 1] = [_count(interface, variable.each)]
    dimensions = "".join(f"[{n}]" for n in shape)
    if variable.type == "string":
        dimensions += f"[{TEXT_SIZE}]"
    about = [variable.unit or "", f"frame {variable.frame}" if variable.frame else "", variable.description]
    about += [optional_text(variable)] if variable.optional else []
    comment = "/* " + "; ".join(part for part in about if part) + " */"
    lines = textwrap.wrap(comment, 110, initial_indent="    ", subsequent_indent="     * ", break_long_words=False)
    return "\n".join([*lines, f"    {_C_TYPES[variable.type]} {variable.name}{dimensions};"])


def block_header(interface: Interface, guid: str, version: int = 2) -> str:
    """block.h: the block's structures and functions by the names that the shell uses.

    A block that calls its guard itself says NAME_GUARDED; the shell calls it of any other.
    A block whose state has room at its end that is rarely in use says by NAME_STATE_USED how much is.
    """
    name, title = interface.code, camel_case(interface.code)
    types = "\n".join(f"typedef {title}{t} {t};" for t in ("Parameters", "Inputs", "Outputs", "State", "Law"))
    calls = "\n".join(f"#define block_{f} {name}_{f}" for f in ("check", "prepare", "start", "outputs", "step"))
    used = f"{name.upper()}_STATE_USED"
    guard = f"#define block_guard(y, f) true\n#else\n#define block_guard {name}_guard\n#endif"
    calls += f"\n#ifdef {name.upper()}_GUARDED\n{guard}"
    calls += (
        f"\n#ifdef {used}\n#define block_state_used {used}\n#else\n#define block_state_used(x) sizeof(State)\n#endif"
    )
    included = f'#include "{name}.h"\n\n#include "{name}_guard.h"'
    return f"{included}\n\n{identity(interface, guid, version)}\n\n{types}\n\n{calls}\n"


def identity(interface: Interface, guid: str, version: int = 2) -> str:
    """The part of block.h that says which FMU it is, of which version of FMI, and how long its tables are."""
    head = f'#define BLOCK_GUID "{guid}"\n#define BLOCK_FMI {version}\n'
    head += f"#define BLOCK_DERIVATIVES {int(version == 3 and interface.derivatives)}\n"
    return head + f"#define BLOCK_VARIABLES {len(interface.elements)}u"


def table(interface: Interface) -> str:
    """table.c: all scalar variables in the order of their value references."""
    scalars = [(v, position, e) for v in interface.variables.values() for position, e in enumerate(v.elements)]
    followers = _followers(interface)
    rows = "\n".join(_row(interface, *scalar, f) for scalar, f in zip(scalars, followers, strict=True))
    return f"""\
#include "instance.h"

#include <float.h>

#define ROW(name, member, kind, causality, variability, start, min, max, text, followers) \\
    {{name, text, start, min, max, (uint32_t)offsetof(Ports, member), kind, causality, variability, followers}},

const Variable variables[BLOCK_VARIABLES] = {{
{rows}
}};
"""


def arrays(interface: Interface) -> str:
    """arrays.c: the variables as FMI 3.0 has them, at the places of their first elements."""
    rows: list[tuple[int, str]] = []
    for variable in interface.variables.values():
        for elements in parts(variable):
            rows += [(len(elements), _ARRAYS[variable.type]), *[(0, "NONE")] * (len(elements) - 1)]
    listed = textwrap.fill(", ".join(f"{{{size}, ARRAY_{kind}}}" for size, kind in rows), 110)
    return f'#include "fmi3.h"\n\nconst Array arrays[BLOCK_VARIABLES] = {{\n{listed}}};\n'


_ARRAYS = {"real": "FLOAT64", "integer": "INT32", "enumeration": "INT64", "boolean": "BOOLEAN", "string": "STRING"}


def _followers(interface: Interface) -> list[int]:
    """Returns for each scalar variable how many after it are alike: they lie side by side in the structures and
    one check suits all."""
    alike = [_alike(v) for v in interface.variables.values() for _ in v.elements]
    return [i for _, group in itertools.groupby(alike) for i in reversed(range(len(list(group))))]


def _alike(variable: Variable) -> tuple[str, ...]:
    kind = {"enumeration": "integer"}.get(variable.type, variable.type).upper()
    low, high = variable.bounds
    variability = {"fixed": "FIXED", "tunable": "TUNABLE"}.get(variable.variability, "MOVING")
    limits = ("-DBL_MAX" if low is None else repr(float(low)), "DBL_MAX" if high is None else repr(float(high)))
    return f"KIND_{kind}", f"CAUSALITY_{variable.causality.upper()}", variability, *limits, _place(variable)


def _place(variable: Variable) -> str:
    """The member of Ports in which it is."""
    return "sampling" if variable.of_shell else _RECORDS[variable.causality][1]


def _row(interface: Interface, variable: Variable, position: int, element: Element, followers: int) -> str:
    kind, causality, variability, low, high, place = _alike(variable)
    member = f"{place}.{members_of(interface, variable)[position]}"
    start, text = element.start or 0, "NULL"
    if isinstance(start, str):
        if len(start.encode()) >= TEXT_SIZE:
            raise InterfaceError(f"{element.name}: start {start!r} has more than {TEXT_SIZE - 1} bytes")
        text, start = quoted(start), 0
    return (
        f"    ROW({quoted(element.name)}, {member}, {kind}, {causality}, {variability}, "
        f"{float(start)!r}, {low}, {high}, {text}, {followers})"
    )


def quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
