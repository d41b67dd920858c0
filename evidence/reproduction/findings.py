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
    rows = []
    for key, of in (("latch 0.65 0.9", "0.65, 0.9 (the scenario's)"), ("latch 0.4 1", "0.40, 1.0")):
        code = hold_outcome(done[key])
        counts = [f"{int((code == i).sum())}" for i in range(len(HOLDS))]
        rows.append([of, *counts, _ranges(np.isin(code, (3, 4)))])
    seen = done["latch 0.65 0.9"]
    code = hold_outcome(seen)
    stuck, released = np.isin(code, (3, 4)), np.isin(code, (1, 2))
    longest = seen.hold_longest[released]
    return {
        "latch": rows,
        "latch_header": "|".join(["K₀, L₀ scale", *HOLDS, "latched at"]),
        "stuck": int(stuck.sum()),
        "stuck_wheel": int(np.isfinite(seen.wheel_at_limit_since[stuck]).sum()),
        "stuck_angle": f"{math.degrees(float(seen.attitude_error[stuck].min())):.0f}°",
        "released": f"{longest.min():.1f} to {longest.max():.1f}",
        "latched_text": done["latched run"].hold,
    }


def convergence(done: dict[str, Any]) -> dict[str, Any]:
    c, e, edge = (done[k] for k in ("random starts, constant", "random starts, error", "starts at the edge"))
    rose = e.steps_up > 0
    rises = f"{100 * e.largest_rise.max():.1f}% (median of those {100 * np.median(e.largest_rise[rose]):.2g}%)"
    of_v = (
        (f"{int((c.steps_up > 0).sum())}", "none", f"{c.rate_error:.0e}"),
        (f"{int(rose.sum())} ({100 * rose.mean():.0f}%)", rises, "does not apply"),
    )
    rows = [
        [gains, markdown.finite(f.converged), f"{np.nanmedian(f.converged):.0f}, {np.nanmax(f.converged):.0f}", *v]
        for gains, f, v in zip(("constant", "[10], following the errors"), (c, e), of_v, strict=True)
    ]
    return {
        "rate_max": f"{RATE_MAX:g}",
        "convergence": rows,
        "edge": markdown.finite(edge.converged),
        "edge_last": f"{np.nanmax(edge.converged):.0f}",
    }


def robustness(done: dict[str, Any]) -> dict[str, Any]:
    rows = []
    own = int(np.abs(sweep.DRAG_FACTORS - 1.0).argmin())
    for which in CLAIMS:
        drag, wrong = done[f"{which}: drag"], done[f"{which}: wrong inertia"]
        moments = sweep.drag_moments(which)
        at = float(np.interp(math.log(1e-5), np.log(moments), np.degrees(drag.attitude_error)))
        rows.append(
            [
                which,
                f"{moments[own]:.1e}",
                f"{math.degrees(float(drag.attitude_error[own])):.2g}°",
                f"{at:.2g}°" if moments[0] <= 1e-5 <= moments[-1] else "not reached",
                markdown.finite(wrong.settled),
                f"{np.nanmin(wrong.settled):.0f} to {np.nanmax(wrong.settled):.0f}",
                f"{100 * all_hold(which, wrong).mean():.0f}%",
            ]
        )
    return {"robustness": rows, "wrong_settle": markdown.finite(done["random starts, wrong inertia"].converged)}


def orbit(done: dict[str, Any]) -> dict[str, Any]:
    b = done["hold over an orbit"].signals["b_wheel"]
    rows = [
        [
            drag,
            markdown.degrees(math.degrees(x.signals["attitude_error"].max())),
            f"{x.signals['demand_fraction'].max():.2g}",
            f"{1e3 * np.abs(x.signals['h_w']).max():.2g}",
            x.hold,
        ]
        for drag, x in (("as modelled", done["hold over an orbit"]), ("10⁻⁵ N m (SI)", done["with drag"]))
    ]
    return {
        "orbit": rows,
        "orbit_crossings": int((np.sign(b[1:]) * np.sign(b[:-1]) < 0).sum()),
        "orbit_share": f"{100 * (np.abs(b) < 0.1).mean():.0f}%",
    }
