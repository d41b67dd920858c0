"""The guard of a block, as C: its contract is proved (evidence/proofs/contracts.py).

Requirement: FC-4. Tests: tests/native/test_calls.py.
"""

from __future__ import annotations

from ..interface import Interface
from .generate import camel_case, members_of, ports_header


def headers(interface: Interface, source: str | None = None) -> dict[str, str]:
    """Returns what each C of a block includes, by the files' names: its structures (`source`: as there), its guard."""
    return ports_header(interface, source) | guard_header(interface)


def guard_header(interface: Interface) -> dict[str, str]:
    """Returns the header, by its file's name: whether each number of the outputs is finite; an array is one run."""
    name, title = interface.code, camel_case(interface.code)
    tests, refusals, promised = [], [], []
    for v in (v for v in interface.of("output") if v.type == "real"):
        member, n = members_of(interface, v)[0], len(v.elements)
        alone = member == v.name
        test = f"is_number(y->{member})" if alone else f"run_finite(&y->{member}, {n})"
        each = f"\\is_finite((&y->{member})[any_place])"
        promise = f"\\is_finite(y->{member})" if alone else f"(0 <= any_place < {n} ==> {each})"
        tests.append(test)
        refusals.append(f'    if (!{test}) {{\n        return not_finite(&y->{member}, {n}, "{v.name}", f);\n    }}\n')
        promised.append(f" \\\n    ensures \\result ==> {promise};")
    tested = " &&\n        ".join(tests) or "true"
    text = f"""\
/* What leaves the block is finite. Generated from its interface; do not edit. Requirement: FC-4. */
#ifndef {name.upper()}_GUARD_H
#define {name.upper()}_GUARD_H

#include "{name}_ports.h"
#include "finite.h"

/* What the guard promises, for the proof: of each number that it is finite. */
#ifdef __FRAMAC__
#define {name.upper()}_FINITE{"".join(promised)}
#endif

/* Notes a number that is not finite; false. */
/*@ assigns *f;
    ensures !\\result; */
static inline bool {name}_refuse(const {title}Outputs *y, Fault *f)
{{
{"".join(refusals)}    return false;
}}

/* Whether each number is finite; else the fault names an output that has one that is not. */
/*@ requires \\separated(y, f);
    assigns *f;
    {name.upper()}_FINITE */
static inline bool {name}_guard(const {title}Outputs *y, Fault *f)
{{
    if ({tested}) {{
        return true;
    }}
    return {name}_refuse(y, f);
}}

#endif
"""
    return {f"{name}_guard.h": text}
