"""Fields of docs/evidence/reproduction.md: the bound, the latched hold, convergence, robustness, an orbit of hold."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .. import markdown
from ..paper import LIMITS, Array
from . import sweep
from .bounds import NODES
from .claims import CLAIMS, HOLDS, all_hold, hold_outcome
from .convergence import RATE_MAX


def bound(done: dict[str, Any]) -> dict[str, Any]:
    rows = []
    for which in CLAIMS:
        limit, claimed = LIMITS[which]
        for dipole in (limit, 25.0):
            times = done[f"{which}: bound {dipole:g} A m2"]
            gaps = [x.gap for x in times.at_claim]
            short = [gap for gap in gaps if gap > 0.0]
            rows.append(
                [
                    which,
                    f"{dipole:g}",
                    f"{claimed:.0f}",
                    f"{len(short)} of {len(gaps)}"
                    + (f", short by {min(short):.3f} to {max(short):.3f}" if short else ""),
                    _spread(times.least),
                ]
            )
    return {
        "bound": rows,
        "bound_nodes": len(NODES),
        "mass_vb": _spread(done["V.B: bound per mass"].least),
        "mass_vc": _spread(done["V.C: bound per mass"].least),
    }


def _spread(values: Array) -> str:
    known = values[np.isfinite(values)]
    more = f", beyond 1500 at {int(np.isnan(values).sum())}" if np.isnan(values).any() else ""
    return f"{known.min():.0f} to {known.max():.0f}{more}" if len(known) else "beyond 1500"


def _ranges(mask: Array) -> str:
    """Stretches of a circle of 360 flags: `165 to 302°`."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(int), [0])))).reshape(-1, 2)
    return ", ".join(f"{a}" if b - a == 1 else f"{a} to {b - 1}" for a, b in edges) + "°" if len(edges) else "none"


def latch(done: dict[str, Any]) -> dict[str, Any]:
    seen = done["latch 0.65 0.9"]
    code = hold_outcome(seen)
    stuck = np.isin(code, (3, 4))
    return {
        "outcomes": "; ".join(f"{name}: {int((code == i).sum())}" for i, name in enumerate(HOLDS)),
        "latched_at": _ranges(stuck),
        "stuck_wheel": int(np.isfinite(seen.wheel_at_limit_since[stuck]).sum()),
        "stuck_angle": f"{math.degrees(float(seen.attitude_error[stuck].min())):.0f}°",
    }


def convergence(done: dict[str, Any]) -> dict[str, Any]:
    c, e, edge = (done[k] for k in ("random starts, constant", "random starts, error", "starts at the edge"))
    rose = e.steps_up > 0
    return {
        "rate_max": f"{RATE_MAX:g}",
        "converge_constant": markdown.finite(c.converged),
        "rises_constant": int((c.steps_up > 0).sum()),
        "last_constant": f"{np.nanmax(c.converged):.0f}",
        "last_error": f"{np.nanmax(e.converged):.0f}",
        "rises_error": f"{int(rose.sum())} ({100 * rose.mean():.0f}%)",
        "largest_rise": f"{100 * e.largest_rise.max():.1f}%",
        "rate_error": f"{c.rate_error:.0e}",
        "edge": markdown.finite(edge.converged),
        "edge_last": f"{np.nanmax(edge.converged):.0f}",
    }


def robustness(done: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, list[str]] = {"modelled": [], "stated": [], "settle": [], "claims_met": []}
    own = int(np.abs(sweep.DRAG_FACTORS - 1.0).argmin())
    for which in CLAIMS:
        drag, wrong = done[f"{which}: drag"], done[f"{which}: wrong inertia"]
        moments = sweep.drag_moments(which)
        at = float(np.interp(math.log(1e-5), np.log(moments), np.degrees(drag.attitude_error)))
        found["modelled"].append(f"{math.degrees(float(drag.attitude_error[own])):.2g}°")
        found["stated"].append(f"{at:.2g}°" if moments[0] <= 1e-5 <= moments[-1] else "not reached")
        found["settle"].append(markdown.finite(wrong.settled))
        found["claims_met"].append(f"{100 * all_hold(which, wrong).mean():.0f}%")
    return {name: " and ".join(each) for name, each in found.items()}


def orbit(done: dict[str, Any]) -> dict[str, Any]:
    b = done["hold over an orbit"].signals["b_wheel"]
    runs = ("hold over an orbit", "with drag")
    most, most_drag = (markdown.degrees(math.degrees(done[name].signals["attitude_error"].max())) for name in runs)
    return {
        "orbit_error": most,
        "orbit_error_drag": most_drag,
        "orbit_crossings": int((np.sign(b[1:]) * np.sign(b[:-1]) < 0).sum()),
        "orbit_share": f"{100 * (np.abs(b) < 0.1).mean():.0f}%",
    }
