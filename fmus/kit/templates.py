"""The files that a team fills in, made from an interface: they compile and run as they are, and give zeros."""

from __future__ import annotations

import textwrap

from ..interface import OPTIONAL, Interface, Variable
from ..native.generate import camel_case


def block_h(interface: Interface) -> str:
    """The block's header: what it remembers, and its five functions."""
    name, title = interface.name, camel_case(interface.name)
    return f"""\
/* {interface.description}.
 * Yours to fill in. Ports and parameters stand in generated/ports.h, with units and frames. */
#ifndef {name.upper()}_H
#define {name.upper()}_H

#include "fault.h"
#include "ports.h"

/* All that the block remembers from step to step. Plain data only: it is copied, saved and restored as bytes. */
typedef struct {{
    double t; /* s */
}} {title}State;

/* The parameters and what follows from them alone. */
typedef struct {{
    {title}Parameters p;
}} {title}Law;

/* Whether the parameters fit each other; false after `fault(f, name, value, "what is expected")`. */
bool {name}_check(const {title}Parameters *p, Fault *f);

/* Once before the first step, and again after a change of parameters; p has passed the check. */
void {name}_prepare(const {title}Parameters *p, {title}Law *law);

/* The state at t = 0 for these inputs. */
bool {name}_start(const {title}Law *law, const {title}Inputs *u, {title}State *x, Fault *f);

/* The outputs of this state and these inputs. Remembers nothing. */
bool {name}_outputs(const {title}Law *law, const {title}State *x, const {title}Inputs *u, {title}Outputs *y, Fault *f);

/* From t to t + h, and the outputs there. */
bool {name}_step(const {title}Law *law, {title}State *x, const {title}Inputs *u, double h, {title}Outputs *y, Fault *f);

#endif
"""


def block_c(interface: Interface) -> str:
    """The block's source."""
    name, title = interface.name, camel_case(interface.name)
    outputs = "\n".join(f"     *   y->{v.name}{_index(v)}{_unit(v)}" for v in interface.of("output"))
    return f"""\
#include "{name}.h"

bool {name}_check(const {title}Parameters *p, Fault *f)
{{
    (void)p, (void)f; /* limits of single values are checked before: they stand in interface.toml */
    return true;
}}

void {name}_prepare(const {title}Parameters *p, {title}Law *law)
{{
    law->p = *p;
}}

bool {name}_start(const {title}Law *law, const {title}Inputs *u, {title}State *x, Fault *f)
{{
    (void)law, (void)u, (void)f;
    x->t = 0.0;
    return true;
}}

bool {name}_outputs(const {title}Law *law, const {title}State *x, const {title}Inputs *u, {title}Outputs *y, Fault *f)
{{
    (void)law, (void)x, (void)u, (void)f;
    *y = ({title}Outputs){{0}};
    /* To be set here:
{outputs}
     */
    return true;
}}

bool {name}_step(const {title}Law *law, {title}State *x, const {title}Inputs *u, double h, {title}Outputs *y, Fault *f)
{{
    if (!{name}_outputs(law, x, u, y, f)) {{
        return false;
    }}
    x->t += h;
    return true;
}}
"""


def _index(variable: Variable) -> str:
    return "".join(f"[0..{n - 1}]" for n in variable.shape)


def _unit(variable: Variable) -> str:
    about = [variable.unit or "", f"frame {variable.frame}" if variable.frame else ""]
    told = ", ".join(part for part in about if part)
    return f"   {told}" if told else ""


def package_py(interface: Interface) -> str:
    """The package's __init__.py."""
    return f'''"""{interface.description}."""

from .block import Inputs, Outputs, Parameters, State, check, outputs, start, step

__all__ = ["Inputs", "Outputs", "Parameters", "State", "check", "outputs", "start", "step"]
'''


def python_block(interface: Interface) -> str:
    """block.py: the dataclasses and the four functions."""
    zeros = ", ".join(f"{v.name}={_zero(v)}" for v in interface.of("output"))
    returned = textwrap.fill(
        f"return Outputs({zeros})", 116, initial_indent="    ", subsequent_indent="        ", break_long_words=False
    )
    parts = [
        f'"""{interface.description}.\n\nYours to fill in. The classes are those of interface.toml, name by name; functions change nothing but what\nthey return.\n"""',
        "from __future__ import annotations\n\nfrom dataclasses import dataclass, replace\n\nimport numpy as np\n\nArray = np.ndarray",
        _record("Parameters", "Fixed before the first step, but for the tunable ones.", interface.of("parameter")),
        _record("Inputs", "", interface.of("input")),
        '@dataclass(frozen=True)\nclass State:\n    """All that the block remembers: floats, whole numbers, booleans and arrays."""\n\n    t: float  # s',
        _record("Outputs", "", interface.of("output")),
        'def check(p: Parameters) -> None:\n    """Raises ValueError, with name and value, where the parameters do not fit each other."""',
        'def start(p: Parameters, u: Inputs) -> State:\n    """The state at t = 0 for these inputs."""\n    return State(t=0.0)',
        f'def outputs(x: State, u: Inputs, p: Parameters) -> Outputs:\n    """The outputs of this state and these inputs."""\n{returned}',
        'def step(x: State, u: Inputs, p: Parameters, h: float) -> tuple[State, Outputs]:\n    """From t to t + h, and the outputs there."""\n    after = replace(x, t=x.t + h)\n    return after, outputs(after, u, p)',
    ]
    return "\n\n\n".join(parts) + "\n"


def _record(name: str, about: str, variables: list[Variable]) -> str:
    lines = [f"@dataclass(frozen=True)\nclass {name}:"]
    if about:
        lines.append(f'    """{about}"""\n')
    lines += [f"    {v.name}: {_python_type(v)}{_comment(v)}" for v in variables]
    return "\n".join(lines)


def _python_type(variable: Variable) -> str:
    if variable.shape:
        return "Array"
    return {"real": "float", "integer": "int", "boolean": "bool"}.get(variable.type, "str")


def _comment(variable: Variable) -> str:
    told = [str(variable.shape).replace(",)", ",)") if variable.shape else "", variable.unit or ""]
    if variable.frame:
        told.append(f"frame {variable.frame}")
    if variable.items:
        told.append(" or ".join(variable.items))
    if variable.optional:
        told.append(OPTIONAL)
    text = ", ".join(part for part in told if part)
    return f"  # {text}" if text else ""


def _zero(variable: Variable) -> str:
    if variable.shape:
        shape = variable.shape[0] if len(variable.shape) == 1 else variable.shape
        return f"np.zeros({shape})"
    return {"real": "0.0", "integer": "0", "boolean": "False"}.get(
        variable.type, repr(variable.items[0] if variable.items else "")
    )
