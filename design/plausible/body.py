"""Whether inertia, size and mass fit each other.

Tests: tests/design/test_plausible.py.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from plant.drag import AXES

from .finding import Finding, size_text, unit_meant
from .satellite import Satellite

DENSITY = (10.0, 6000.0)
"""kg/m3, of a homogeneous body with this inertia: an empty hull, and near that of steel."""
LONG, LONGEST, LEVER = 1.5, 20.0, 0.25
"""Length over width of a long body, and the most of any; offset of the centre of mass over the size."""


def of_inertia(s: Satellite) -> Iterator[Finding]:
    """Yields what is found of the moments of inertia beside the triangle inequality, the body's size and its mass."""
    moments = np.linalg.eigvalsh(s.J)
    shown = ", ".join(f"{m:.4g}" for m in np.linalg.eigvalsh(s.p.J_B))
    if moments[2] > moments[0] + moments[1]:
        yield Finding(
            f"J_B has the principal moments {shown} kg.m2; the largest is {moments[2] / (moments[0] + moments[1]):.3g} "
            "times the sum of the two others",
            "at most 1, as of any body",
            "check the signs of the products and the units",
        )
        return
    across = (s.size @ s.size - s.size**2).tolist()  # a2 + b2 about each axis
    least, most = DENSITY
    if s.mass is None:
        density = s.heavy / float(s.size.prod())
        if not least <= density <= most:
            yield Finding(
                f"J_B of {shown} kg.m2 in a body of {size_text(s.size)} is that of {s.heavy:.3g} kg, "
                f"{density:.3g} kg/m3",
                f"{least:g} to {most:g} kg/m3",
                f"check the units ({unit_meant(density, least, most)}), or body_width and body_length; "
                "deployed parts may be meant",
            )
        return
    density = s.mass / float(s.size.prod())
    if not least <= density <= most:
        grams = least <= 1e-3 * density <= most
        yield Finding(
            f"{s.mass:g} kg in a body of {size_text(s.size)} is {density:.3g} kg/m3",
            f"{least:g} to {most:g} kg/m3",
            f"check the units{' (in g it would fit)' if grams else ''}, or body_width and body_length",
        )
    for name, moment, square in zip("xyz", np.diag(s.J).tolist(), across, strict=True):
        bound = s.mass * square / 4.0  # all of it in the farthest edges
        if not 0.02 * bound <= moment <= bound:
            yield Finding(
                f"the moment of inertia about {name} is {moment:.4g} kg.m2",
                f"{0.02 * bound:.3g} to {bound:.3g} kg.m2 of {s.mass:g} kg within {size_text(s.size)}",
                f"check the units ({unit_meant(moment, 0.02 * bound, bound)}); deployed parts may be meant",
            )


def of_body(s: Satellite) -> Iterator[Finding]:
    """Yields what is found of the long axis, the centre of mass and the first rate."""
    p, moments = s.p, np.diag(s.p.J_B)
    along = AXES.index(p.body_axis)
    ratio = p.body_length / p.body_width
    others = np.delete(moments, along)
    if (ratio > LONG and moments[along] > others.min()) or (ratio < 1.0 / LONG and moments[along] < others.max()):
        kind = "long" if ratio > LONG else "flat"
        best = AXES[int(moments.argmin() if ratio > LONG else moments.argmax())]
        yield Finding(
            f"body_axis {p.body_axis} of a {kind} body, {size_text(s.size)}, has the moment of inertia "
            f"{moments[along]:.4g} kg.m2, "
            f"the others {others[0]:.4g} and {others[1]:.4g}",
            f"the {'least' if kind == 'long' else 'largest'} about it",
            f"body_axis: {best}?",
        )
    if not 1.0 / LONGEST <= ratio <= LONGEST:
        yield Finding(
            f"the body, {size_text(s.size)}, is {max(ratio, 1.0 / ratio):.3g} times as large along one axis",
            f"at most {LONGEST:g} times",
            "check the units of body_width and body_length; they count for drag and sunlight",
        )
    share = np.abs(p.center_of_mass_B) / s.size
    if share.max() > LEVER:
        worst = int(share.argmax())
        yield Finding(
            f"center_of_mass_B is {1e3 * p.center_of_mass_B[worst]:.3g} mm off the middle along {AXES[worst]}, "
            "where the body is "
            f"{1e3 * s.size[worst]:.3g} mm long",
            f"at most {LEVER:g} of it",
            "it counts from the middle, in m",
        )
    if (rate := float(np.degrees(np.linalg.norm(p.omega_B0)))) > 60.0:
        yield Finding(f"omega_B0 is {rate:.3g} deg/s", "at most 60 deg/s", "numbers without a unit are rad/s")
