"""resources/container.bin: the tables that container.h describes, in little-endian numbers."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from fractions import Fraction

from ..system import System
from .description import exposed
from .inside import Inside

MAGIC = b"CNTNR1"
_NO_BLOCK = 0xFFFFFFFF


def table(system: System, inside: Sequence[Inside], guid: str) -> bytes:
    """Returns the file that belongs to a modelDescription.xml of this GUID, whose variables are those of `exposed`."""
    text = bytearray(b"\0")

    def put(words: str) -> int:
        text.extend(words.encode() + b"\0")
        return len(text) - len(words.encode()) - 1

    by_name = {each.name: each for each in inside}

    def end(at: tuple[str, str]) -> tuple[int, int, int]:
        return by_name[at[0]].end(at[1])

    blocks = [(put(i.name), put(i.root.get("guid", "")), put(i.folder), put(i.identifier)) for i in inside]
    variables = [
        (0, _NO_BLOCK, 0, 0) if v.of is None else (*v.of.end(v.inner), int(v.settable)) for v in exposed(system, inside)
    ]
    starts = []
    for each in inside:
        for value in each.component.values:
            words = put(str(value.value)) if isinstance(value.value, str) else 0
            number = 0.0 if isinstance(value.value, str) else float(value.value)
            starts.append((*each.end(value.name), words, number))

    def by_end(at: tuple[str, str]) -> tuple[int, int, int]:
        kind, block, reference = end(at)
        return block, kind, reference

    sources = sorted({wire.source for wire in system.wires}, key=by_end)
    place = {source: i for i, source in enumerate(sources)}
    outputs = [(*end(source), put(source[1])) for source in sources]
    wires = sorted(system.wires, key=lambda wire: by_end(wire.target))
    inputs = [(*end(wire.target), place[wire.source], wire.factor, wire.offset) for wire in wires]
    initial = [(wires.index(wire),) for wire in system.initial]
    step = Fraction(repr(system.scenario.step))
    rows = (
        ("IIII", blocks),
        ("IIII", variables),
        ("IIIId", starts),
        ("IIIIdd", inputs),
        ("IIII", outputs),
        ("I", initial),
    )
    parallel = system.scenario.exchange != "sequential"
    counts = (*(len(each) for _, each in rows), len(text), parallel)
    head = struct.pack("<8s40s8Idd", MAGIC, guid.encode(), *counts, float(step.numerator), float(step.denominator))
    return head + b"".join(struct.pack(f"<{form}", *row) for form, each in rows for row in each) + bytes(text)
