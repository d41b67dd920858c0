"""What stands between a block in single precision and a shell or a link, whose numbers are doubles."""

from __future__ import annotations

import re
from pathlib import Path

from fmus.interface import Interface
from fmus.native.generate import camel_case

HERE = Path(__file__).parent
_CALLS = ("check", "prepare", "start", "outputs", "step")
_RECORDS = ("parameter", "input", "output")
CLOCKS = {"estimator": ("now.t",), "controller_planned_wheels": ("t", "planned.t")}
"""Where a block's state has its time; in the others `t`."""
_OUTER = """
#include "conversion.h"

bool outer_check(const Parameters *p, Fault *f);
void outer_prepare(const Parameters *p, Law *law);
bool outer_start(Law *law, const Inputs *u, State *x, Fault *f);
bool outer_outputs(Law *law, const State *x, const Inputs *u, Outputs *y, Fault *f);
bool outer_step(Law *law, State *x, const Inputs *u, double h, Outputs *y, Fault *f);
"""


def block_header(interface: Interface, text: str) -> str:
    """block.h of the shell or of the link: state and law are bytes, enough for floats since enough for doubles.

    Before the state stands the time in double precision.
    """
    title, code = camel_case(interface.code), interface.code
    for kind in ("State", "Law"):
        time = "    double time;\n" if kind == "State" else ""
        opaque = f"typedef struct {{\n{time}    _Alignas(8) unsigned char bytes[sizeof({title}{kind})];\n}} {kind};"
        text = text.replace(f"typedef {title}{kind} {kind};", opaque)
    for call in _CALLS:
        text = re.sub(rf"#define block_{call} {code}_{call}$", f"#define block_{call} outer_{call}", text, flags=re.M)
    end = text.rfind("#endif") if text.startswith("#ifndef BLOCK_H") else len(text)
    used = "\n#undef block_state_used\n#define block_state_used(x) sizeof(State)\n"
    return f"{text[:end]}{used}{_OUTER}{text[end:]}"


def wide(interface: Interface) -> str:
    """wide.c: where each variable stands in the structures with doubles."""
    tables = "\n".join(_table(interface, r, f"const Field wide_{r}s[]") for r in _RECORDS)
    return f'#include "block.h"\n\n{tables}'


def inner_header(interface: Interface) -> str:
    """inner.h: the block's own structures and functions, and where each variable stands in them."""
    title, code = camel_case(interface.code), interface.code
    types = "".join(f"typedef {title}{kind} {kind};\n" for kind in ("Parameters", "Inputs", "Outputs", "State"))
    calls = "".join(f"#define block_{call} {code}_{call}\n" for call in _CALLS)
    times = " = ".join(f"(x)->{member}" for member in CLOCKS.get(interface.name, ("t",)))
    calls += f"#define SET_TIME(x, time) ({times} = (time))\n"
    sizes = ", ".join(f"{r.upper()}S = {len(interface.of(r))}" for r in _RECORDS)  # type: ignore[arg-type]
    tables = "\n".join(_table(interface, r, f"static const Field own_{r}s[]") for r in _RECORDS)
    return f'#include "{code}.h"\n\n#include "conversion.h"\n\n{types}{calls}\nenum {{ {sizes} }};\n\n{tables}'


def _table(interface: Interface, record: str, declared: str) -> str:
    rows = []
    for v in interface.of(record):  # type: ignore[arg-type]
        member = f"(({record.title()}s *)0)->{v.name}"
        count = str(len(v.elements)) if v.type == "real" else f"sizeof({member})"
        kind = "REAL" if v.type == "real" else "OTHER"
        rows.append(f"    {{offsetof({record.title()}s, {v.name}), {count}, FIELD_{kind}}},\n")
    return f"{declared} = {{\n{''.join(rows)}}};\n"
