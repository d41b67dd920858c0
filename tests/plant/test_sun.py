"""The Sun and the Earth's shadow against Meeus' example, closed forms, integrals and rays. astropy:
tests/authorities/sun.py."""

from __future__ import annotations

import itertools
import math
from datetime import UTC, datetime

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import plant
from plant import sun
from plant.time_scales import days_since_j2000
from tests.native.driver import Instance
from tests.plant.motion import checked, command

EQUATOR, POLE = 6378137.0, 6356752.314245
"""Semi-axes of WGS 84, m (NIMA TR8350.2)."""


def test_the_sun_stands_where_meeus_has_it_on_1992_october_13():
    """Astronomical Algorithms (1998), example 25.b: apparent place by the full VSOP87, 0h TD."""
    right_ascension = math.radians(15.0 * (13.0 + 13.0 / 60.0 + 30.749 / 3600.0))
    declination = -math.radians(7.0 + 47.0 / 60.0 + 1.74 / 3600.0)
    equinoxes = math.radians(15.908 * math.cos(math.radians(23.4401)) / 3600.0)  # nutation of the date, ch. 22
    alpha = right_ascension - equinoxes
    c = math.cos(declination)
    expected = np.array([c * math.cos(alpha), c * math.sin(alpha), math.sin(declination)])
    x = np.array(sun.position(days_since_j2000(datetime(1992, 10, 13, tzinfo=UTC)) / 36525.0))
    assert math.degrees(np.linalg.norm(np.cross(x / np.linalg.norm(x), expected))) < 0.002
    assert np.linalg.norm(x) / sun.AU == pytest.approx(0.99760775, abs=1e-4)


def test_between_its_nodes_the_sun_is_where_it_is():
    path = sun.Sun(4000.25)
    for t in (-700.0, -1.0, 0.0, 299.0, 599.999, 600.0, 5000.0):
        exact = np.array(sun.position((4000.25 + (t + sun.TT_UTC) / 86400.0) / 36525.0))
        assert np.linalg.norm(np.array(path.at(t)) - exact) / sun.AU < 3e-9


def overlap(a: float, b: float, c: float) -> float:
    """Area that two discs share, by an integral of the shorter half chord."""

    def chord(x: float) -> float:
        return 2.0 * math.sqrt(max(min(a * a - x * x, b * b - (x - c) ** 2), 0.0))

    low, high = max(-a, c - b), min(a, c + b)
    middle = 0.5 * (c * c + a * a - b * b) / c
    return quad(chord, low, high, points=[middle], limit=200, epsabs=1e-13)[0] if high > low else 0.0


@pytest.mark.parametrize(("a", "b"), [(0.00465, 1.14), (0.3, 0.5), (0.5, 0.3), (0.4, 0.4)])
@pytest.mark.parametrize("share", [0.001, 0.2, 0.5, 0.8, 0.999])
def test_what_is_left_of_a_disc_is_the_integral_s(a, b, share):
    c = abs(b - a) + share * (a + b - abs(b - a))
    assert sun.disc_left(a, b, c) == pytest.approx(1.0 - overlap(a, b, c) / (math.pi * a * a), abs=2e-8)


def test_a_disc_is_left_whole_hidden_or_as_a_ring_where_the_limbs_do_not_cross():
    assert sun.disc_left(0.1, 0.5, 0.6) == 1.0
    assert sun.disc_left(0.1, 0.5, 0.4) == 0.0
    assert sun.disc_left(0.5, 0.1, 0.2) == pytest.approx(1.0 - 0.04)


def rays(r_N: np.ndarray, S_N: np.ndarray, rings: int = 60) -> float:
    """The part of the Sun's disc from which a straight ray reaches r_N beside the ellipsoid."""
    towards = S_N - r_N
    distance = np.linalg.norm(towards)
    towards = towards / distance
    u = np.cross(towards, [0.3, 0.5, 0.8])
    u /= np.linalg.norm(u)
    v = np.cross(towards, u)
    free = total = 0
    for ring in range(rings):  # rings of equal width, rays in proportion to their area
        rho = (ring + 0.5) / rings * 695.7e6
        angle = np.linspace(0.0, 2.0 * np.pi, 12 * (2 * ring + 1), endpoint=False)
        ends = S_N + rho * (np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * v)
        d = (ends - r_N) * [1.0 / EQUATOR, 1.0 / EQUATOR, 1.0 / POLE]
        o = r_N * [1.0 / EQUATOR, 1.0 / EQUATOR, 1.0 / POLE]
        od, dd = d @ o, (d * d).sum(axis=1)
        hit = (od < 0.0) & (od * od - dd * (o @ o - 1.0) > 0.0)
        free += int((~hit).sum())
        total += len(angle)
    return free / total


@pytest.mark.parametrize("declination", [0.0, 0.4])
@pytest.mark.parametrize("limb", [0.0, 0.7, math.pi / 2])  # from the equator to a pole
def test_the_penumbra_is_that_of_rays_past_the_ellipsoid(declination, limb):
    """Across the shadow's edge 7000 km from the Earth's centre, where a sphere would be off by up to 21 km."""
    S_N = sun.AU * np.array([math.cos(declination), 0.0, math.sin(declination)])
    along = S_N / np.linalg.norm(S_N)
    across = math.cos(limb) * np.array([0.0, 1.0, 0.0]) + math.sin(limb) * np.cross(along, [0.0, 1.0, 0.0])

    def light(offset: float) -> float:
        return sun.seen_from(-3e6 * along + offset * across, tuple(S_N))[1]

    middle = brentq(lambda x: light(x) - 0.5, 6.2e6, 6.5e6)
    seen = 0
    for offset in middle + np.linspace(-14e3, 14e3, 9):
        expected = rays(-3e6 * along + offset * across, S_N)
        assert light(offset) == pytest.approx(expected, abs=5e-3)
        seen += 0.0 < expected < 1.0
    assert seen >= 5


def test_by_day_there_is_full_light_and_behind_the_earth_none():
    S_N = (sun.AU, 0.0, 0.0)
    for r, expected in (
        ([7e6, 0.0, 0.0], 1.0),
        ([0.0, 7e6, 0.0], 1.0),
        ([-7e6, 0.0, 1e3], 0.0),
        ([-3e9, 0.0, 0.0], None),
    ):
        sun_N, sunlight = sun.seen_from(np.array(r), S_N)
        assert sun_N @ sun_N == pytest.approx(1.0, abs=1e-15)
        ring = 1.0 - ((EQUATOR / 3e9) / (sun.SUN_RADIUS / (sun.AU + 3e9))) ** 2  # beyond the tip of the umbra
        assert sunlight == pytest.approx(ring if expected is None else expected, abs=1e-5)


def test_both_flavours_agree_in_the_penumbra():
    p = checked(epoch="2026-03-01T00:00:00Z")
    found = []
    u = command()

    def light(angle: float) -> float:
        q = checked(epoch="2026-03-01T00:00:00Z", node_longitude=0.3, argument_of_latitude=angle)
        return plant.outputs(plant.start(q, u), u, q).sunlight

    grid = np.linspace(0.0, 2.0 * np.pi, 91)
    edges = [(a, b) for a, b in itertools.pairwise(grid) if (light(a) - 0.5) * (light(b) - 0.5) < 0.0]
    assert len(edges) == 2, p
    for a, b in edges:
        middle = brentq(lambda x: light(x) - 0.5, a, b, xtol=1e-5)
        for angle in middle + np.array([-0.004, -0.001, 0.0, 0.001, 0.004]):
            q = checked(epoch="2026-03-01T00:00:00Z", node_longitude=0.3, argument_of_latitude=angle)
            y = plant.outputs(plant.start(q, u), u, q)
            with Instance("plant") as native:
                native.set_all(q)
                native.initialize()
                both = native.outputs()
            found.append(y.sunlight)
            assert both["sunlight"] == pytest.approx(y.sunlight, abs=1e-9)
            assert np.abs(np.asarray(both["sun_N"]) - y.sun_N).max() < 1e-12
    assert sum(0.0 < x < 1.0 for x in found) >= 6
