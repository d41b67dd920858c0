"""Icons: an SVG of rectangles, circles and polygons in a square of 100 by 100, and the same as a PNG.

FMI wants the PNG; no renderer is asked of whoever builds an FMU, and the same SVG gives the same bytes everywhere.
Tests: tests/fmus/contents/test_contents.py.
"""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ET
import zlib
from collections.abc import Callable

_SAMPLES = 3
"""Samples per pixel in each direction, which smooth the edges."""

Inside = Callable[[float, float], bool]
_Shape = tuple[Inside, tuple[int, int, int]]


def png(svg: bytes, size: int = 64) -> bytes:
    """The picture as a square PNG with a transparent background."""
    shapes = [_shape(element) for element in ET.fromstring(svg)]
    shapes.reverse()  # the last one drawn lies on top
    pixels = {(x, y): _pixel(shapes, x, y, 100.0 / size) for y in range(size) for x in range(size)}
    rows = b"".join(b"\0" + b"".join(bytes(pixels[x, y]) for x in range(size)) for y in range(size))
    header = struct.pack(">IIBBBBB", size, size, 8, 6, 0, 0, 0)
    # Stored, not deflated: the bytes then do not depend on the zlib that is at hand. The archive deflates them.
    return (
        b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) + _chunk(b"IDAT", zlib.compress(rows, 0)) + _chunk(b"IEND", b"")
    )


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _pixel(shapes: list[_Shape], x: int, y: int, scale: float) -> tuple[int, int, int, int]:
    """The mean colour of the points in a pixel, and how many of them lie on a shape."""
    found = []
    for j in range(_SAMPLES):
        for i in range(_SAMPLES):
            u, v = (x + (i + 0.5) / _SAMPLES) * scale, (y + (j + 0.5) / _SAMPLES) * scale
            colour = next((colour for inside, colour in shapes if inside(u, v)), None)
            if colour is not None:
                found.append(colour)
    if not found:
        return 0, 0, 0, 0
    red, green, blue = (sum(channel) // len(found) for channel in zip(*found, strict=True))
    return red, green, blue, 255 * len(found) // _SAMPLES**2


def _shape(element: ET.Element) -> _Shape:
    kind = element.tag.rpartition("}")[2]
    number = {key: float(element.get(key, "0")) for key in ("x", "y", "width", "height", "cx", "cy", "r")}
    fill = element.get("fill", "")
    colour = int(fill[1:3], 16), int(fill[3:5], 16), int(fill[5:7], 16)
    if kind == "rect":
        x, y, right, below = number["x"], number["y"], number["x"] + number["width"], number["y"] + number["height"]
        return lambda u, v: x <= u < right and y <= v < below, colour
    if kind == "circle":
        cx, cy, r = number["cx"], number["cy"], number["r"]
        return lambda u, v: (u - cx) ** 2 + (v - cy) ** 2 < r * r, colour
    if kind == "polygon":
        points = [tuple(map(float, point.split(","))) for point in element.get("points", "").split()]
        sides = list(zip(points, points[1:] + points[:1], strict=True))
        return lambda u, v: _crossings(sides, u, v) % 2 == 1, colour
    raise ValueError(f"an icon holds rect, circle and polygon only, found {kind}")


def _crossings(sides: list[tuple[tuple[float, ...], tuple[float, ...]]], u: float, v: float) -> int:
    """Returns how many sides a ray from the point to the right crosses."""
    return sum((y1 > v) != (y2 > v) and u < x1 + (v - y1) / (y2 - y1) * (x2 - x1) for (x1, y1), (x2, y2) in sides)
