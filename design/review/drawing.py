"""A drawing of the satellite as SVG: body, axes, rods and wheels, seen from the direction (2, -3, 1.6)."""

from __future__ import annotations

import math
from html import escape

import numpy as np

from plant import Parameters
from plant.drag import AXES
from plant.so3 import Array

SIZE = 420.0
"""Points of the drawing."""
COLOURS = {"axis": "#777777", "rod": "#0072b2", "wheel": "#d55e00"}


def drawing(p: Parameters) -> str:
    """Returns the SVG of a satellite's body with its actuators."""
    view = np.array([2.0, -3.0, 1.6])
    view /= np.linalg.norm(view)
    right = np.cross(np.array([0.0, 0.0, 1.0]), view)
    right /= np.linalg.norm(right)
    up = np.cross(view, right)
    largest = max(p.body_width, p.body_length)
    scale = 0.42 * SIZE / largest

    def at(point: Array) -> tuple[float, float]:
        return 0.5 * SIZE + scale * float(point @ right), 0.5 * SIZE - scale * float(point @ up)

    parts: list[str] = []

    def line(a: Array, b: Array, colour: str, width: float, label: str = "", ends: str = "") -> None:
        (x1, y1), (x2, y2) = at(a), at(b)
        parts.append(
            f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" stroke-width="{width}"'
            f"{ends}/>"
        )
        if label:
            dx, dy = x2 - x1, y2 - y1
            far = 11.0 / max(math.hypot(dx, dy), 1e-9)
            parts.append(
                f'<text x="{x2 + far * dx:.1f}" y="{y2 + far * dy + 4:.1f}" fill="{colour}" '
                f'text-anchor="middle">{escape(label)}</text>'
            )

    for ring in (prism := _prism(p)):
        for i in range(len(ring)):
            line(ring[i], ring[(i + 1) % len(ring)], "#999999", 1.0)
    for a, b in zip(*prism, strict=True):
        line(a, b, "#999999", 1.0)
    reach = 0.72 * largest
    for i, name in enumerate(AXES):
        line(np.zeros(3), reach * np.eye(3)[i], COLOURS["axis"], 1.2, name, ' stroke-dasharray="5 4"')
    for i, axis in enumerate(p.rods_to_body.T, start=1):
        line(-0.24 * largest * axis, 0.24 * largest * axis, COLOURS["rod"], 4.0, f"u{i}")
    shown = [w for w in zip(p.wheel_list, p.wheel_axes, strict=True) if w[0].momentum_max > 1e-8]
    for i, (_, axis) in enumerate(shown, start=1):
        place = 0.45 * largest * axis
        across = np.cross(axis, view) if abs(axis @ view) < 0.99 else np.cross(axis, up)
        across /= np.linalg.norm(across)
        other = np.cross(axis, across)
        turn = np.linspace(0.0, 2.0 * math.pi, 25)
        ring = place + 0.07 * largest * (np.outer(np.cos(turn), across) + np.outer(np.sin(turn), other))
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(at, ring))
        parts.append(
            f'<polygon points="{points}" fill="{COLOURS["wheel"]}" fill-opacity="0.35" stroke="{COLOURS["wheel"]}"/>'
        )
        line(place, place + 0.1 * largest * axis, COLOURS["wheel"], 2.0, f"w{i}")
    x, y = at(p.center_of_mass_B)
    shown_axes = [reach * axis for axis in np.eye(3)] + [0.64 * largest * axis for _, axis in shown]
    ends = np.array([at(q) for q in (*shown_axes, *(q for ring in prism for q in ring))])
    low, high = ends.min(axis=0) - 30.0, ends.max(axis=0) + 30.0
    box = " ".join(f"{v:.1f}" for v in (*low, *(high - low)))
    parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="#333333"/>')
    return (
        f'<svg viewBox="{box}" width="{SIZE:g}" role="img" aria-label="Body with its actuators" '
        f'style="max-width:100%;font:13px sans-serif;background:#fff">{"".join(parts)}</svg>'
    )


def _prism(p: Parameters) -> tuple[Array, Array]:
    """Returns both ends (8, 3) m of the octagonal cylinder, four of whose sides face along the other axes."""
    along = AXES.index(p.body_axis)
    others = [i for i in range(3) if i != along]
    angles = math.pi / 8 + math.pi / 4 * np.arange(8)
    ring = np.zeros((8, 3))
    ring[:, others[0]] = 0.5 * p.body_width / math.cos(math.pi / 8) * np.cos(angles)
    ring[:, others[1]] = 0.5 * p.body_width / math.cos(math.pi / 8) * np.sin(angles)
    half = np.zeros(3)
    half[along] = 0.5 * p.body_length
    return ring - half, ring + half
