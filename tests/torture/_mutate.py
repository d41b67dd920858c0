"""Bytes and XML changed at random."""

from __future__ import annotations

import io
import re
import zipfile
from random import Random

HOSTILE = (
    *("", "-1", "0", "1e999", "NaN", "INF", "nan", "maybe", "x" * 5000, "\x9b2J", "&#10;", "../x", "/etc/passwd"),
    *("%00", "电", "[1]", "2147483648", "none"),
)


def text(random: Random, xml: str) -> str:
    """XML with one to three changes: an attribute's value, an attribute or an element left out or doubled, bytes."""
    for _ in range(random.randint(1, 3)):
        kind = random.randrange(6)
        values = list(re.finditer(r'="([^"]*)"', xml))
        elements = list(re.finditer(r"<\w[^<>]*?/>|<(\w[\w:]*)[^<>]*>[^<>]*</\1>", xml))
        if kind <= 1 and values:
            found = random.choice(values)
            other = random.choice([*HOSTILE, random.choice(values)[1]])
            xml = xml[: found.start(1)] + other + xml[found.end(1) :]
        elif kind == 2 and values:
            found = random.choice(list(re.finditer(r'\s[\w:]+="[^"]*"', xml)) or values)
            xml = xml[: found.start()] + xml[found.end() :]
        elif kind == 3 and elements:
            found = random.choice(elements)
            xml = xml[: found.start()] + found[0] * random.choice((0, 2)) + xml[found.end() :]
        elif kind == 4 and len(elements) > 1:
            found, other_element = random.sample(elements, 2)
            xml = xml[: found.start()] + other_element[0] + xml[found.end() :]
        else:
            at = random.randrange(len(xml))
            xml = xml[:at] + random.choice(("<", ">", '"', "&", "\x85", "<!--", "</")) + xml[at + 1 :]
    return xml


def encoded(random: Random, xml: str) -> bytes:
    """Mostly UTF-8; at times what the XML says or does not say."""
    if random.random() < 0.9:
        return xml.encode("utf-8", "replace")
    encoding = random.choice(("utf-16", "gbk", "latin-1", "utf-32", "cp037"))
    says = random.choice((encoding, "UTF-8", "EBCDIC-XY"))
    return xml.replace("UTF-8", says, 1).encode(encoding, "replace")


def archive(random: Random, data: bytes) -> bytes:
    """A zip archive with bytes changed, cut, doubled, or with an entry that means harm."""
    kind = random.randrange(4)
    if kind == 0:
        return data[: random.randrange(len(data))]
    if kind == 1:
        changed = io.BytesIO(data)
        with zipfile.ZipFile(changed, "a") as file:
            names = file.namelist()
            below = random.choice(names) + "/x"
            hostile = "../x", "/x", "a\\b", "C:/x", below, "é" * 300, "a" * 300, "\x1b[2J", " ", "binaries/x"
            name = random.choice(hostile)
            info = zipfile.ZipInfo(name)
            info.external_attr = random.choice((0o100644, 0o120777, 0o020666, 0)) << 16
            file.writestr(info, b"x")
        return changed.getvalue()
    mutable = bytearray(data)
    places = [m.start() for m in re.finditer(b"PK[\x01-\x06][\x02-\x07]", data)]
    for _ in range(random.choice((1, 1, 3, 20))):
        near = random.choice(places) + random.randrange(60) if kind == 2 else random.randrange(len(data))
        mutable[min(near, len(data) - 1)] = random.choice((0, 1, 0x7F, 0xFF, random.randrange(256)))
    return bytes(mutable)
