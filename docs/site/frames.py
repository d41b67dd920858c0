"""Draws fmus/contents/frames.svg, the frames and axes: `python -m docs.site.frames`. Tests: tests/docs/test_site.py."""

from __future__ import annotations

from html import escape
from math import cos, pi, radians, sin
from pathlib import Path

import numpy as np

TARGET = Path(__file__).parents[2] / "fmus" / "contents" / "frames.svg"
BLUE, RED, GREEN, GREY, INK = "#0072b2", "#d55e00", "#007a5a", "#888888", "#222222"
Point = tuple[float, float]


class View:
    """A parallel projection of right-handed axes with Z up, seen from an azimuth and an elevation, deg."""

    def __init__(self, centre: Point, scale: float, azimuth: float, elevation: float) -> None:
        a, e = radians(azimuth), radians(elevation)
        self.centre, self.scale = centre, scale
        self.right = np.array([-sin(a), cos(a), 0.0])
        self.up = np.array([-sin(e) * cos(a), -sin(e) * sin(a), cos(e)])
        self.towards = np.array([cos(e) * cos(a), cos(e) * sin(a), sin(e)])

    def at(self, point: np.ndarray) -> Point:
        x, y = self.centre
        return (x + self.scale * float(self.right @ point), y - self.scale * float(self.up @ point))


def _path(points: list[Point], colour: str, more: str = "") -> str:
    d = "M" + " L".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<path d="{d}" fill="none" stroke="{colour}" stroke-width="1.5" {more}/>'


def _text(point: Point, words: str, colour: str = INK, size: int = 13, anchor: str = "middle") -> str:
    x, y = point
    drawn = f'fill="{colour}" font-size="{size}" text-anchor="{anchor}"'
    return f'<text x="{x:.1f}" y="{y:.1f}" {drawn}>{escape(words)}</text>'


def _arrow(start: Point, end: Point, colour: str, label: str, dashed: bool = False) -> list[str]:
    along = np.subtract(end, start) / np.hypot(*np.subtract(end, start))
    across = np.array([-along[1], along[0]])
    tip = [tuple(end), tuple(end - 9 * along + 4 * across), tuple(end - 9 * along - 4 * across)]
    head = "M" + " L".join(f"{x:.1f},{y:.1f}" for x, y in tip) + "Z"
    x, y = end + 10.0 * along
    more = 'stroke-dasharray="5 3"' if dashed else ""
    return [
        _path([start, tuple(end - 7 * along)], colour, f'{more} style="stroke-width:2.2"'),
        f'<path d="{head}" fill="{colour}"/>',
        _text((x, y + 4), label, colour, anchor="start" if along[0] > 0.5 else "end" if along[0] < -0.5 else "middle"),
    ]


def _circle(view: View, first: np.ndarray, second: np.ndarray, hidden_by: float) -> list[str]:
    """The circle first cos t + second sin t: pale where it lies behind a sphere of the radius `hidden_by`."""
    points = [first * cos(t) + second * sin(t) for t in np.linspace(0.0, 2 * pi, 91)]
    behind = [bool(view.towards @ p < 0 and np.hypot(view.right @ p, view.up @ p) < hidden_by * 1.001) for p in points]
    parts, start = [], 0
    for i in range(1, len(points)):
        if i == len(points) - 1 or behind[i] != behind[start]:
            run = [view.at(p) for p in points[start : i + 1]]
            parts.append(_path(run, GREY, 'opacity=".35"' if behind[start] else ""))
            start = i
    return parts


def earth() -> list[str]:
    view = View((200.0, 240.0), 82.0, 25.0, 22.0)
    e = np.eye(3)
    x, y = view.centre
    parts = [f'<circle cx="{x}" cy="{y}" r="{view.scale}" fill="#e8f0f6" stroke="{GREY}"/>']
    parts += _circle(view, e[0], e[1], 1.0)
    node = np.array([cos(radians(95.0)), sin(radians(95.0)), 0.0])
    i = radians(98.0)
    along = np.array([-cos(i) * node[1], cos(i) * node[0], sin(i)])
    parts += _circle(view, 2.0 * node, 2.0 * along, 1.0)
    for axis, name in zip(e, ("X_N", "Y_N", "Z_N"), strict=True):
        parts += _arrow(view.at(np.zeros(3)), view.at(1.4 * axis), BLUE, name)
    u = radians(32.0)
    r, v = node * cos(u) + along * sin(u), -node * sin(u) + along * cos(u)
    for axis, name in ((v, "X_L"), (-np.cross(r, v), "Y_L"), (-r, "Z_L")):
        parts += _arrow(view.at(2.0 * r), view.at(2.0 * r + 0.7 * axis), RED, name)
    parts += [
        _text((215.0, 30.0), "Frame N (inertial) and LVLH (L)", size=16),
        _text((215.0, 405.0), "X_N: mean equinox of date; Z_N: axis of the Earth", BLUE, 12),
        _text((215.0, 423.0), "X_L: along the velocity; Y_L: against r × v; Z_L: to nadir", RED, 12),
    ]
    return parts


def body() -> list[str]:
    view = View((640.0, 235.0), 120.0, 35.0, 22.0)
    angles = [pi / 8 + k * pi / 4 for k in range(9)]
    radius = 0.325 / cos(pi / 8)
    ends = [[np.array([x, radius * cos(a), radius * sin(a)]) for a in angles] for x in (-0.4, 0.4)]
    parts = []
    for k, end in enumerate(ends):
        face = "M" + " L".join("{:.1f},{:.1f}".format(*view.at(p)) for p in end) + "Z"
        fill = "#eeeeee" if k else "none"
        parts.append(f'<path d="{face}" fill="{fill}" stroke="{GREY}"/>')
    parts += [_path([view.at(p), view.at(q)], GREY, 'opacity=".6"') for p, q in zip(*ends, strict=True)]
    e, s = np.eye(3), 1.0 / 3.0**0.5
    names = ("X_B = e1", "Y_B", "Z_B")
    for axis, name in zip(e, names, strict=True):
        parts += _arrow(view.at(np.zeros(3)), view.at(1.15 * axis), BLUE, name)
    rods = {"u1": np.array([s, s, -s]), "u2": np.array([s, -s, s]), "u3 = Z_B": np.array([0.0, 0.0, 1.0])}
    for name, axis in rods.items():
        parts += _arrow(view.at(np.zeros(3)), view.at(0.85 * axis), GREEN, "" if "=" in name else name, dashed=True)
    parts.append(_text(np.add(view.at(0.8 * e[2]), (10.0, 0.0)), "u3", GREEN, anchor="start"))  # type: ignore[arg-type]
    parts += [
        _text((640.0, 30.0), "Frame B (body), wheel axis, rod axes", size=16),
        _text((640.0, 405.0), "X_B: default wheel axis, and axis of the octagonal cylinder", BLUE, 12),
        _text((640.0, 423.0), "u1, u2, u3: default axes of the rods; u3 is along Z_B", GREEN, 12),
    ]
    return parts


def drawing() -> str:
    """The SVG."""
    lines = "\n".join([*earth(), *body()])
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 860 440" font-family="sans-serif" role="img" '
        'aria-label="Frames N, LVLH and B, with the axes of wheel and rods">\n'
        f'<rect width="860" height="440" fill="#ffffff"/>\n{lines}\n</svg>\n'
    )


if __name__ == "__main__":
    TARGET.write_text(drawing(), "utf-8")
