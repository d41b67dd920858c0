"""slopes.cpp: the block's C a second time, with dual numbers (shell3/dual.h) in the place of double, as C++.

What `[block]` of an interface has `derivatives = true` gives directional and adjoint derivatives as an FMU of FMI 3.0.
The structure of its state, in its header, may have numbers, Booleans, structures of the common headers with such
members, and arrays of these only.
Tests: tests/native/test_derivatives.py.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from ..interface import Interface, InterfaceError, Variable
from .generate import camel_case, members_of
from .toolchain import COMMON

_NUMBERS = ("double", "bool", "int32_t", "int")
Members = list[tuple[str, str, str]]
"""Type, name and dimensions of each member of a structure."""


def slopes(interface: Interface, native: Path) -> str:
    """The text of slopes.cpp of the block whose C stands in `native`. Raises InterfaceError."""
    members = _members(interface, native / f"{interface.code}.h", f"{camel_case(interface.code)}State")
    inner = {kind: _members(interface, _header_of(kind), kind) for kind, _, _ in members if kind not in _NUMBERS}
    plain = "".join(f"struct Plain{kind} {{\n{_fields(of)}\n}};\n\n" for kind, of in inner.items())
    copies = "".join(
        f"static void copy({kind} &to, const Plain{kind} &from)\n{{\n{_copied('to.', of)}\n}}\n\n"
        for kind, of in inner.items()
    )
    included = "\n".join(f'#include "{path.relative_to(native).as_posix()}"' for path in sorted(native.rglob("*.c")))
    return f"""\
#include "dual.h"

{plain}struct Plain {{
{_fields(members)}
}};

#define double Dual
#include "block.h"
{included}
#undef double

template <class To, class From> static void copy(To &to, const From &from)
{{
    to = from;
}}

template <class To, class From, size_t n> static void copy(To (&to)[n], const From (&from)[n])
{{
    for (size_t i = 0; i < n; ++i) {{
        copy(to[i], from[i]);
    }}
}}

{copies}static void state_from(const Plain &from, State *x)
{{
{_copied("x->", members)}
}}

static void set(Parameters *p, Inputs *u, const double v[], const double d[])
{{
{_lines(interface, interface.of("parameter"), "p", _SET)}
{_lines(interface, interface.of("input"), "u", _SET)}
}}

static void get(const Outputs *y, double d[])
{{
{_lines(interface, [v for v in interface.of("output") if v.type == "real"], "y", {"real": "    d[{i}] = {member}.d;"})}
}}

extern "C" void block_slopes(const double values[], const double seeds[], const void *state, double slopes[])
{{
    Fault f = {{"", "", NULL, 0.0}};
    Parameters p;
    Inputs u;
    Outputs y;
    Law law;
    State x;
    set(&p, &u, values, seeds);
    block_prepare(&p, &law);
    if (state == NULL) {{
        block_start(&law, &u, &x, &f);
    }} else {{
        state_from(*static_cast<const Plain *>(state), &x);
    }}
    block_outputs(&law, &x, &u, &y, &f);
    get(&y, slopes);
}}
"""


_WHOLE = "    {member} = (int32_t)v[{i}];"
_SET = {
    "real": "    {member} = Dual(v[{i}], d[{i}]);",
    "boolean": "    {member} = v[{i}] != 0.0;",
    "integer": _WHOLE,
    "enumeration": _WHOLE,
}


def _lines(interface: Interface, variables: Sequence[Variable], record: str, forms: dict[str, str]) -> str:
    return "\n".join(
        forms[variable.type].format(member=f"{record}->{member}", i=element.value_reference)
        for variable in variables
        for member, element in zip(members_of(interface, variable), variable.elements, strict=True)
    )


def _fields(members: Members) -> str:
    return "\n".join(
        f"    {kind if kind in _NUMBERS else f'Plain{kind}'} {name}{dimensions};" for kind, name, dimensions in members
    )


def _copied(to: str, members: Members) -> str:
    return "\n".join(f"    copy({to}{name}, from.{name});" for _, name, _ in members)


def _header_of(kind: str) -> Path:
    """The common header that has a structure. Raises InterfaceError."""
    for path in sorted(COMMON.glob("*.h")):
        if f"}} {kind};" in path.read_text("utf-8"):
            return path
    raise InterfaceError(
        f"derivatives: expected a number, a Boolean or a structure of fmus/native/common, found {kind}"
    )


def _members(interface: Interface, header: Path, kind: str) -> Members:
    """Those of a structure, as the header has them. Raises InterfaceError."""
    text = re.sub(r"/\*.*?\*/", "", header.read_text("utf-8"), flags=re.DOTALL)
    found = re.search(rf"typedef struct \{{([^{{}}]*)\}} {kind};", text)
    members: Members = []
    for declared in found[1].split(";")[:-1] if found else ():
        type_, _, names = " ".join(declared.split()).partition(" ")
        for name in names.split(", "):
            if (one := re.fullmatch(r"(\w+)((?:\[\w+\])*)", name)) is None:
                raise InterfaceError(
                    f"{header.name}: derivatives: expected members and arrays in {kind}, found {name!r}"
                )
            members.append((type_, one[1], one[2]))
    if not members:
        raise InterfaceError(f"{header.name}: derivatives: expected a structure {kind}, found none")
    # The sets' sizes stand before the header that has these constants.
    sizes = {f"{interface.code}_{part}s".upper(): str(count) for part, count in interface.sets.items()}
    return [(t, n, re.sub(r"\w+", lambda m: sizes.get(m[0], m[0]), d)) for t, n, d in members]
