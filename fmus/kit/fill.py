"""Fills the templates beside this file from an interface.

What a team fills in afterwards (block.h, block.c, block.py) compiles and runs as it is, and gives zeros.
Tests: tests/fmus/kit/test_kit.py.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from pathlib import Path

from .. import places
from ..interface import Interface, Variable, citations, optional_text
from ..native.generate import camel_case


def filled(template: str, interface: Interface, **more: str) -> str:
    """The text of a file beside this one, with each @key@ replaced by what it stands for."""
    text = Path(__file__).with_name(template).read_text("utf-8")
    cited = textwrap.wrap(citations(interface), 110)
    values = {
        "name": interface.name,
        "NAME": interface.name.upper(),
        "title": camel_case(interface.name),
        "description": interface.description,
        "cited": "".join(f"\n{line}" for line in cited) + "\n" * bool(cited),
        "cited_c": "".join(f" * {line}\n" for line in cited),
        "fmus": places.NAME,
        "members": "\n".join(f"     *   y->{v.name}{_index(v)}{_unit(v)}" for v in interface.of("output")),
        "parameters": _fields(interface.of("parameter")),
        "inputs": _fields(interface.of("input")),
        "outputs": _fields(interface.of("output")),
        "zeros": _zeros(interface.of("output")),
        "python_zeros": "\n".join(
            f"        {v.name!r}: {_nested_zero(v, 0)},{_comment(v)}" for v in interface.of("output")
        ),
        **more,
    }
    for key, value in values.items():
        text = text.replace(f"@{key}@", value)
    return text


def _index(variable: Variable) -> str:
    return "".join(f"[0..{n - 1}]" for n in variable.shape)


def _unit(variable: Variable) -> str:
    text = ", ".join(part for part in (variable.unit, _frame(variable)) if part)
    return f"   {text}" if text else ""


def _frame(variable: Variable) -> str:
    return f"frame {variable.frame}" if variable.frame else ""


def _fields(variables: list[Variable]) -> str:
    """The fields of a Python dataclass, each with its shape, unit and frame."""
    return "\n".join(f"    {v.name}: {_python_type(v)}{_comment(v)}" for v in variables)


def _python_type(variable: Variable) -> str:
    if variable.shape:
        return "Array"
    return {"real": "float", "integer": "int", "boolean": "bool"}.get(variable.type, "str")


def _comment(variable: Variable) -> str:
    shape, items = str(variable.shape) if variable.shape else "", " or ".join(variable.items)
    parts = (shape, variable.unit, _frame(variable), items, optional_text(variable) if variable.optional else "")
    text = ", ".join(part for part in parts if part)
    return f"  # {text}" if text else ""


def _zeros(variables: list[Variable]) -> str:
    text = f"return Outputs({', '.join(f'{v.name}={_zero(v)}' for v in variables)})"
    return textwrap.fill(text, 116, initial_indent="    ", subsequent_indent="        ", break_long_words=False)


def by_default(interface: Interface, left_out: Mapping[str, float | str]) -> str:
    """The text of the values, by names of outputs, that a law may leave out: an input, or a number."""
    items = [
        f'"{v.name}": ' + (f"u.{value}" if isinstance(value, str) else f"np.full({v.shape}, {value!r})" if v.shape
                           else repr(value))
        for v in interface.of("output")
        if (value := left_out.get(v.name)) is not None
    ]  # fmt: skip
    return "".join(f"        {item},\n" for item in items)


def _zero(variable: Variable) -> str:
    if variable.shape:
        shape = variable.shape[0] if len(variable.shape) == 1 else variable.shape
        return f"np.zeros({shape})"
    return {"real": "0.0", "integer": "0", "boolean": "False"}.get(
        variable.type, repr(variable.items[0] if variable.items else "")
    )


def _nested_zero(variable: Variable, axis: int) -> str:
    """Zero as lists, without NumPy; an enumeration's is the number of its first item."""
    if axis < len(variable.shape):
        inner = _nested_zero(variable, axis + 1)
        return f"[{', '.join([inner] * variable.shape[axis])}]"
    return {"real": "0.0", "boolean": "False", "enumeration": "1"}.get(variable.type, "0")
