"""The values of an interface that go over the line, their order, and the hash by which both ends compare them."""

from __future__ import annotations

import hashlib

from ..interface import Interface, InterfaceError, Variable
from ..native.generate import TEXT_SIZE
from ..variables import Causality

HASH_SIZE, NAME_SIZE, TOKEN_SIZE = 8, 32, 8
HEADER, CHECK, GREETING, REFUSAL, TIMES = 14, 4, 2 + HASH_SIZE + NAME_SIZE + TOKEN_SIZE, 97, 16
"""Bytes of a frame's head and end, and of the payloads that no interface decides; see native/frame.h."""
RECORDS: dict[Causality, str] = {"parameter": "Parameters", "input": "Inputs", "output": "Outputs"}
SIZES = {"real": 8, "integer": 4, "enumeration": 4, "boolean": 1, "string": TEXT_SIZE}
"""Bytes of an element, a real in double precision."""


def interface_hash(interface: Interface) -> bytes:
    """The first 8 bytes of the SHA-256 of the interface's name and, of each variable that goes over the line, all that
    gives its value a meaning.
    """
    lines = [interface.name]
    for causality in RECORDS:
        for v in interface.of(causality):
            units = " ".join(unit or "1" for unit in v.units)
            shape = "x".join(map(str, v.shape)) or "1"
            lines.append(f"{causality} {v.type} {v.name} {shape} {units} {v.frame or '-'} {' '.join(v.items)}".rstrip())
    return hashlib.sha256("\n".join(lines).encode()).digest()[:HASH_SIZE]


def frame_max(interface: Interface) -> int:
    """Bytes of the longest frame. Raises InterfaceError where a frame cannot hold the interface."""
    sizes = {c: sum(SIZES[v.type] * len(v.elements) for v in interface.of(c)) for c in RECORDS}
    payload = max(GREETING, REFUSAL, sizes["parameter"], TIMES + sizes["input"], 8 + sizes["output"])
    if payload >= 1 << 16:
        raise InterfaceError(f"{interface.name}: expected at most 65535 bytes of values in a frame, found {payload}")
    return HEADER + payload + CHECK


def header(interface: Interface) -> str:
    """wire.h: name, hash and sizes of the interface on the line."""
    if len(interface.name.encode()) > NAME_SIZE:
        raise InterfaceError(f"{interface.name}: expected a name of at most {NAME_SIZE} bytes")
    digest = ", ".join(f"0x{byte:02X}" for byte in interface_hash(interface))
    return f"""\
/* The interface {interface.name} on the line. Generated from the interface; do not edit. */
#ifndef WIRE_H
#define WIRE_H

#include "frame.h"

#define LINK_INTERFACE "{interface.name}"
#define LINK_INTERFACE_HASH {{{digest}}}

enum {{ LINK_FRAME_MAX = {frame_max(interface)} }};

extern const LinkRecord link_parameter_fields, link_input_fields, link_output_fields;

#endif
"""


def source(interface: Interface) -> str:
    """wire.c: where each variable stands in the structures."""
    parts = ['/* Generated from the interface; do not edit. */\n#include "block.h"\n#include "wire.h"\n']
    for causality, record in RECORDS.items():
        rows = [_row(record, v) for v in interface.of(causality)]
        name = f"{causality}_fields"
        if rows:
            listed = ",\n".join(f"    {row}" for row in rows)
            parts.append(f"static const LinkField {name}[] = {{\n{listed},\n}};")
        parts.append(f"const LinkRecord link_{name} = {{{name if rows else 'NULL'}, {len(rows)}}};\n")
    return "\n".join(parts)


def _row(record: str, variable: Variable) -> str:
    kinds = {"real": "REAL", "boolean": "BOOLEAN", "string": "TEXT"}
    count = str(len(variable.elements) * (TEXT_SIZE if variable.type == "string" else 1))
    return f"{{offsetof({record}, {variable.name}), {count}, LINK_IS_{kinds.get(variable.type, 'INTEGER')}}}"
