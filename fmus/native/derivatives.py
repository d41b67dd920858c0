"""slopes.cpp: the block's C a second time, with dual numbers (shell3/dual.h) in the place of double, as C++.

What `[block]` of an interface has `derivatives = true` gives directional and adjoint derivatives as an FMU of FMI 3.0.
The structure of its state, in its header, may have numbers, Booleans and arrays of them only.
Tests: tests/native/test_derivatives.py.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from ..interface import Interface, InterfaceError, Variable
from .generate import camel_case, members_of

_FIELD = re.compile(r"^ *(?:double|bool|int32_t|int) (\w+)(?:\[\w+\])*; *(?:/\*.*\*/)?$", re.MULTILINE)


def slopes(interface: Interface, native: Path) -> str:
    """The text of slopes.cpp of the block whose C stands in `native`. Raises InterfaceError."""
    state = _state(interface, native)
    included = "\n".join(f'#include "{path.relative_to(native).as_posix()}"' for path in sorted(native.rglob("*.c")))
    copied = "\n".join(f"    copy(x->{name}, from.{name});" for name in _FIELD.findall(state))
    return f"""\
#include "dual.h"

struct Plain {{
{state}
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

static void state_from(const Plain &from, State *x)
{{
{copied}
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


def _state(interface: Interface, native: Path) -> str:
    """The fields of the block's state, as its header has them."""
    text = (native / f"{interface.code}.h").read_text("utf-8")
    found = re.search(rf"typedef struct \{{\n([^}}]*)\n\}} {camel_case(interface.code)}State;", text)
    if found is None or len(_FIELD.findall(found[1])) != len(found[1].splitlines()):
        raise InterfaceError(
            f"{interface.code}.h: derivatives: expected a state of numbers, Booleans and arrays of them, a line each"
        )
    fields = found[1]
    for part, count in interface.sets.items():  # they stand before the header that has these constants
        fields = fields.replace(f"{interface.code}_{part}s".upper(), str(count))
    return fields
