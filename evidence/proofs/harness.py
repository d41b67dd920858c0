"""The program that Frama-C reads of a block: any parameters, any inputs, any number of steps.

A harness calls the block as flight software may: check, prepare and start, then in a loop without end outputs and step,
and now and then check and prepare of other parameters with the state as it is.
`ANY`: each number is any bit pattern of its type, NaN and infinities included. `LIMITS`: each is within the limits of
the interface, an optional input also not connected, and each real output has to be finite.
"""

from __future__ import annotations

from typing import Literal

from fmus.interface import ABSENT_MIN, Interface, Variable
from fmus.native.generate import TEXT_SIZE, camel_case, shape_in_c

Range = Literal["any", "limits"]
REAL_MAX = 1e15
"""Of a real variable without limits of its own."""
TIME_MAX = 1e9
"""s, 31 years: how long a flight takes, where numbers have limits."""
COUNTS = (-209, 64, 209)
"""Bounds of counters in the blocks' states: where a growing number is first tried to stay. Others cost time only."""
STEP_MAX = 1000.0
"""s, the longest step, where numbers have limits."""
SCRATCH = {
    "controller_planned": ("law.workspace", "law.steering_field"),
    "controller_planned_wheels": ("law.planned.workspace", "law.planned.steering_field"),
}
"""What is zero before prepare, as in a static law."""

_TEXT = """\
/* Of {name}, with numbers of the range "{range}": written by evidence/proofs/harness.py. */
#include "{name}.h"

#include <math.h>
#include <string.h>

#include "__fc_builtin.h"

extern volatile double any_real;
extern volatile int any_integer;
extern volatile float any_single;
volatile double seen_real;
volatile int seen_integer;

static void fill_parameters({title}Parameters *p)
{{
{parameters}
}}

static void fill_inputs({title}Inputs *u)
{{
{inputs}
}}

static void read_outputs(const {title}Outputs *y)
{{
{outputs}
}}

static double any_step(void)
{{
    return {step};
}}

/* What a refusal says outlives the call. */
static void read_fault(const Fault *f)
{{
    seen_integer = f->name[0];
    seen_integer = f->expected[0];
    if (f->text != 0) {{
        seen_integer = f->text[0];
    }}
    seen_real = f->value;
}}

#if defined COMMON_ONBOARD_FIELD_H && defined PROOF_APART
/* In place of its body, which the program `field` follows: any numbers, all of them set. */
void onboard_field(const GaussModel *model, double days, int degree, const double error[3], OnboardField *field)
{{
    Frama_C_make_unknown((char *)field, sizeof *field);
    field->degree = Frama_C_interval(1, ONBOARD_DEGREE_MAX);
}}
#endif

static void look({title}Law *law, const {title}State *x)
{{
    Fault f = {{"", "", 0, 0.0}};
    {title}Inputs u;
    {title}Outputs y;
    fill_inputs(&u);
    if ({name}_outputs(law, x, &u, &y, &f)) {{
        read_outputs(&y);
    }} else {{
        read_fault(&f);
    }}
}}

/* What a refused step leaves is a state, too. */
static void move({title}Law *law, {title}State *x)
{{
    Fault f = {{"", "", 0, 0.0}};
    {title}Inputs u;
    {title}Outputs y;
    fill_inputs(&u);
    if ({name}_step(law, x, &u, any_step(), &y, &f)) {{
        read_outputs(&y);
    }} else {{
        read_fault(&f);
    }}
}}

/* What flight software may do between two steps: other parameters, with the state as it is. */
static void change({title}Law *law)
{{
    {title}Parameters p;
    Fault f = {{"", "", 0, 0.0}};
    fill_parameters(&p);
    if ({name}_check(&p, &f)) {{
    {split}    {name}_prepare(&p, law);
    }} else {{
        read_fault(&f);
    }}
}}

static void fly({title}Law *law, {title}State *x)
{{
    //@ loop widen_hints "all", {counts};
    while (any_integer != 0{while_time}) {{
        look(law, x);
        move(law, x);
        if (any_integer != 0) {{
            change(law);
        }}
    }}
}}

int main(void)
{{
    {title}Parameters p;
    {title}Inputs u;
    {title}Law law; /* not set: prepare has to */{zeros}
    {title}State x;
    Fault f = {{"", "", 0, 0.0}};
    fill_parameters(&p);
    if (!{name}_check(&p, &f)) {{
        read_fault(&f);
        return 1;
    }}
{split}    {name}_prepare(&p, &law);
    fill_inputs(&u);
    if (!{name}_start(&law, &u, &x, &f)) {{
        read_fault(&f);
        return 2;
    }}
    fly(&law, &x);
    return 0;
}}
"""


def harness(interface: Interface, span: Range) -> str:
    """The program's C."""

    def filled(letter: str, v: Variable) -> str:
        return _filled(f"{letter}->{v.name}", v, shape_in_c(interface, v), span)

    parts = {
        "parameters": "\n".join(filled("p", v) for v in interface.of("parameter")),
        "inputs": "\n".join(filled("u", v) for v in interface.of("input")),
    }
    outputs = "\n".join(_read(f"y->{v.name}", v, shape_in_c(interface, v), span) for v in interface.of("output"))
    title, has_field = camel_case(interface.code), "field_model" in interface.variables
    return _TEXT.format(
        name=interface.code,
        range=span,
        title=title,
        outputs=outputs,
        step="any_real" if span == "any" else f"Frama_C_double_interval(0x1p-20, {STEP_MAX!r})",
        while_time=f" && x->t <= {TIME_MAX!r}" if span == "limits" else "",
        counts=", ".join(map(str, COUNTS)),
        zeros="".join(f"\n    memset(&{name}, 0, sizeof {name});" for name in SCRATCH.get(interface.code, ())),
        split="    //@ split p.field_model;\n" if has_field else "",
        **parts,
    )


def _loops(name: str, shape: tuple[int, ...], body: str) -> str:
    """The statement for each element of an array; the analysis takes each element for itself."""
    body = body.replace("$", name + "".join(f"[{'ijk'[k]}]" for k in range(len(shape))))
    for level, n in reversed(list(enumerate(shape))):
        i = "ijk"[level]
        body = f"//@ loop unroll {n};\n    for (int {i} = 0; {i} < {n}; ++{i}) {{\n    {body}\n    }}"
    return "    " + body


def _filled(name: str, v: Variable, shape: tuple[int, ...], span: Range) -> str:
    if v.type == "string":
        return f"    Frama_C_make_unknown({name}, {TEXT_SIZE - 1}); {name}[{TEXT_SIZE - 1}] = 0;"
    if v.type == "boolean":
        return _loops(name, shape, "$ = any_integer != 0;")
    if v.type in ("integer", "enumeration"):
        low, high = (1, len(v.items)) if v.type == "enumeration" else (v.min, v.max)
        if span == "any" or low is None or high is None:
            return _loops(name, shape, "$ = any_integer;")
        return _loops(name, shape, f"$ = Frama_C_interval({int(low)}, {int(high)});")
    if span == "any":
        return _loops(name, shape, "$ = any_real;")
    low, high = limits_of(v)
    given = _loops(name, shape, f"$ = Frama_C_double_interval({low!r}, {high!r});")
    if not v.optional:
        return given
    absent = _loops(name, shape, "$ = 1e9;")
    return f"    if (any_integer != 0) {{\n    {given}\n    }} else {{\n    {absent}\n    }}"


def limits_of(v: Variable) -> tuple[float, float]:
    """Returns the limits of a real parameter or input; of an optional one while it is connected."""
    low, high = (-REAL_MAX if v.min is None else v.min), (REAL_MAX if v.max is None else v.max)
    return (float(low), float(high)) if not v.optional else (float(low), min(float(high), ABSENT_MIN))


def _read(name: str, v: Variable, shape: tuple[int, ...], span: Range) -> str:
    if v.type != "real":
        return _loops(name, shape, "seen_integer = $;")
    finite = "//@ assert finite: \\is_finite($);\n    " if span == "limits" else ""
    return _loops(name, shape, f"{finite}seen_real = $;")
