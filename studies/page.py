"""The text of docs/reproduction.md, every number in it from the results that it is given."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from . import convergence, sweep
from .claims import CLAIMS, HOLDS, OUTCOMES, READINGS, ROOT, SCENARIOS, Claim, all_hold, hold_outcome, outcome
from .reproduction import BOUND_NODES, PAPER_LIMITS, Run, Times
from .setup import read
from .vectors import Array
from .watch import Seen


def text(done: dict[str, Any]) -> str:
    """The page."""
    parts = (_head, _claims, _open, _bound, _latch, _convergence, _robustness, _orbit, _made)
    return "\n\n".join(part(done).strip() for part in parts) + "\n"


def _table(header: list[str], rows: list[list[str]]) -> str:
    cells = [[cell.replace("|", "\\|") for cell in row] for row in [header, ["---"] * len(header), *rows]]
    lines = ["| " + " | ".join(row) + " |" for row in cells]
    return "\n".join(lines)


def _picture(name: str, alt: str) -> str:
    return f"![{alt}](figures/repro-{name}.png)"


def _head(done: dict[str, Any]) -> str:
    a = {w: bool(all_hold(w, done[f"{w}: run a"].seen)[0]) for w in CLAIMS}
    verdict = "every claim of both manoeuvres holds" if all(a.values()) else "not every claim holds"
    code = hold_outcome(done["latch 0.65 0.9"])
    nodes = int(all_hold("V.C", done["latch 0.65 0.9"]).sum())
    limit, time = PAPER_LIMITS["V.B"]
    times: Times = done["V.B: bound 15 A m2"]
    short = [v.gap for v in times.at_claim]
    excluded = sum(gap > 0.0 for gap in short)
    e = done["random starts, error"]
    c = done["random starts, constant"]
    return f"""
<!-- Written by `make reproduction` (python -m studies reproduction); do not edit. -->
# The paper, reproduced and examined

Sanyal and Lee-Ho, “Attitude Tracking Control of a Small Satellite in Low Earth Orbit”, AIAA 2009-5902, flies two manoeuvres:
V.B, without, and V.C, with a passage through the singularity of its wheel law. This page sets every claim made of them beside
what our loop does, says what the claims depend on, and what the paper does not say. Numbers in brackets are its equations.

- **Per unit of mass, {verdict}.** Inertia, K₀, L₀ and drag are divided by the satellite's 50 kg. This reading is ours, not the
  paper's words, and it is fragile: with our gains V.C keeps all claims at {nodes} of 360 longitudes of the node ([below](#what-the-paper-leaves-open)).
- **In SI units they cannot hold.** V.B asks more momentum of the rods than the geomagnetic field lets them give within {time:.0f} s at
  {limit:g} A m² a rod, by {min(short):.2f} to {max(short):.2f} N m s, at {excluded} of {len(short)} longitudes tried ([proof](#the-balance-of-momentum)).
  With the real limits the hold never lets go.
- **The hold can latch** even in the reading that works: at {int(np.isin(code, (3, 4)).sum())} of 360 longitudes it is never released,
  the held wheel torque runs the wheel to its limit, and the satellite stays tumbling. The paper does not say so.
- **The law itself is sound.** With exact torque {int(np.isfinite(e.converged).sum())} of {len(e.converged)} random starts converge, V never
  rises in any of {len(c.converged)} with constant gains, and the three other equilibria are unstable.
"""


def _cell(claim: Claim, seen: Seen, letter: str) -> str:
    if letter == "b" and claim.of_limits:
        return "no meaning"
    value, margin = float(claim.value(seen)[0]), float(claim.margin(seen)[0])
    word = "met" if margin > 0.0 else "**not met**"
    shown = claim.show(value)
    unit = f" {claim.unit}" if claim.unit and math.isfinite(value) else ""
    if shown in ("yes", "no"):
        return f"{word}: {shown}"
    return f"{word}: {shown}{unit}" + (f" (margin {margin:.3g})" if claim.graded and math.isfinite(margin) else "")


def _degrees(angle: float) -> str:
    degrees = math.degrees(angle)
    return f"{degrees:.0f}°" if degrees >= 10.0 else f"{degrees:.2g}°"


def _claims(done: dict[str, Any]) -> str:
    tables = []
    for which, claims in CLAIMS.items():
        rows = []
        for claim in claims:
            said = claim.paper + (" (implied)" if claim.implied else "")
            rows.append(
                [claim.text, said] + [_cell(claim, done[f"{which}: run {r.letter}"].seen, r.letter) for r in READINGS]
            )
        rows.append(["what became of the hold", ""] + [done[f"{which}: run {r.letter}"].hold for r in READINGS])
        end = [_degrees(done[f"{which}: run {r.letter}"].seen.attitude_error[0]) for r in READINGS]
        torque = [f"{1e3 * done[f'{which}: run {r.letter}'].seen.torque[0]:.3g} mN m" for r in READINGS]
        rows += [["attitude error at the end", "", *end], ["largest torque demanded", "", *torque]]
        tables.append(f"**{which}**\n\n" + _table(["claim", "the paper", "(a)", "(b)", "(c)"], rows))
    readings = "; ".join(f"({r.letter}) {r.text}" for r in READINGS)
    si = [done[f"{w}: SI for an orbit"] for w in CLAIMS]
    settled = sum(int(np.isfinite(s.settled).sum()) for s in si)
    rods = float(done["V.B: run b"].seen.dipole[0])
    vc = done["V.C: run a"].seen
    t, flown = done["V.B: run a"].time, done["V.B: run a"].signals
    L = flown["gain_l"] * sweep.constants()["controller.L0"][0][0]
    expected = float(L[1] * (flown["rate_error_B"][1] ** 2).sum())
    ratio = -float(np.gradient(flown["lyapunov"], t)[1]) / expected
    c, e = done["random starts, constant"], done["random starts, error"]
    drag = done["with drag"]
    further = [
        [
            "robust to drag that the law does not know",
            f"met: {_degrees(done['V.B: drag'].attitude_error[-1])} with {sweep.drag_moments('V.B')[-1]:.0e} N m ({sweep.drag_moments('V.B')[-1] / 1e-5:.0f} times the paper's moment; [robustness](#robustness))",
        ],
        [
            "convergence is almost global",
            f"met: {int(np.isfinite(c.converged).sum() + np.isfinite(e.converged).sum())} of {len(c.converged) + len(e.converged)} random starts, with exact torque ([convergence](#almost-global-convergence))",
        ],
        [
            "a wheel on the roll axis keeps the satellite controllable round its orbit",
            f"met for holding LVLH: below {_degrees(drag.signals['attitude_error'].max())} with the paper's drag; not at each instant ([round the orbit](#round-the-orbit))",
        ],
    ]
    return f"""
## Every claim

Each verdict is from a run of the three FMUs over 1/15 orbit at a step of 0.1 s: {readings}. Settled means an attitude error below 2° and a
rate error below 10⁻³ rad/s from then to the end of the run. “Never near zero” is read as |b₁| above 0.1, “a short while” as 30 s. “Implied” is what the paper does not say in words.

{tables[0]}

{tables[1]}

{_table(["further claim", "found"], further)}

In (a) the demand in V.C's hold does not stop at 80%: as b₁ passes zero it grows to {vc.hold_by_rod[0]:.0f} times the limit, and the hold bridges that. In (b) times and angles are those of (a), as they must be: without limits, dividing
inertia, gains and moments by one number changes nothing but the size of the torques. The rods would have to give {rods / 15.0:.0f} times their 15 A m², and the wheel's share grows without bound as b₁ passes zero.
In (c) the demand lies above 80% from the start, so zero is held; what V.C meets there it meets because nothing is commanded, and in V.B the tumble lowers the demand now and then until the command it catches is kept for good. Over a whole orbit in (c), from 24 longitudes of the node for each manoeuvre, {settled} of
{sum(len(s.settled) for s in si)} runs have settled at the end.

{_picture("lyapunov", "V, dV/dt and the share of the demand that is met, for V.B and V.C")}

The paper's own figures, drawn by `make figures`: V.B [2](figures/vb-errors.png), [3](figures/vb-actuators.png), [4](figures/vb-demand.png) and
V.C [5](figures/vc-errors.png), [6](figures/vc-actuators.png), [7](figures/vc-demand.png). dV/dt starts at {ratio:.2f} times −ω·Lω, since the gains [10] fall with the errors, which [11] does not count.
"""


def _number(value: float, constant: sweep.Constant) -> str:
    if constant.name in ("bend of Φ", "factor on drag"):
        return f"{value:.2g}"
    return f"{value:g}"


def _range(constant: sweep.Constant, which: str, seen: Seen) -> tuple[str, str]:
    found = sweep.interval(constant, which, seen)
    if found is None:
        return "none", "claims fail at the value taken"
    low, high, below, above = found
    unit = f" {constant.unit}" if constant.unit and constant.unit != "°" else constant.unit
    reasons = [f"{side}: {reason}" for side, reason in (("below", below), ("above", above)) if reason]
    share = f"{_number(low, constant)} to {_number(high, constant)}{unit}"
    return share, "; ".join(reasons) or "none within what was tried"


def _open(done: dict[str, Any]) -> str:
    rows = []
    for i, constant in enumerate(sweep.ONE_BY_ONE):
        tried = f"{_number(float(constant.values[0]), constant)} to {_number(float(constant.values[-1]), constant)}"
        cells = [_range(constant, which, done[f"{which}: one by one"][i]) for which in CLAIMS]
        rows.append([constant.name, constant.taken, tried, cells[0][0], cells[0][1], cells[1][0], cells[1][1]])
    header = [
        "constant",
        "taken",
        "tried",
        "V.B: all claims hold",
        "what fails beyond",
        "V.C: all claims hold",
        "what fails beyond",
    ]
    shares = []
    for key, said in (("node and K0", "node longitude and K₀'s scale"), ("K0 and L0", "K₀'s and L₀'s scale")):
        b, c = (all_hold(w, done[f"{w}: {key}"]) for w in CLAIMS)
        shares.append(
            f"over {said}, V.B keeps all its claims in {_percent(b)}, V.C in {_percent(c)}, both in {_percent(b & c)}"
        )
    at = int(np.flatnonzero(np.isclose(sweep.NODES, 160.0))[0])
    step_words = []
    for which in CLAIMS:
        kept = [f"{s:g} s" for s in sweep.STEPS if all_hold(which, done[f"{which}: step {s:g} s"])[at]]
        step_words.append(f"{which} at {', '.join(kept) or 'none'}")
    return f"""
## What the paper leaves open

The paper gives neither K₀, L₀ and Φ nor the date, the longitude of the node, the control step or the shape of the body. What we took, and between which
values all claims still hold when one alone is changed (mass-normalised reading, step 0.1 s):

{_table(header, rows)}

{_picture("nodes", "maps over node longitude and K0 for V.B and V.C, and where both keep every claim")}

{_picture("gains", "maps over K0 and L0")}

{_picture("steps", "maps over node longitude and control step")}

Of the cells shown, {shares[0]}; {shares[1]}. With the node at 160° every claim holds for the steps {"; ".join(step_words)}. The cross marks the values taken.
So **the reading is fragile**: the gains must lie in a narrow band, narrow enough that they were fitted rather than found, and V.C also needs the node within a few
degrees. What V.C shows, a running command that is held and then released, depends on where the field stands in the first second.
That both manoeuvres keep all claims somewhere makes the reading plausible; it does not prove it. The sweeps fly the blocks' loop written for many cases at once, with the variational integrator
of order 2; tests hold it to the blocks' own functions to nine digits.
"""


def _percent(mask: Array) -> str:
    return f"{100.0 * mask.mean():.1f}%"


def _bound(done: dict[str, Any]) -> str:
    rows = []
    for which in CLAIMS:
        limit, claimed = PAPER_LIMITS[which]
        at = int(np.flatnonzero(BOUND_NODES == 160.0)[0])
        for dipole in (limit, 25.0):
            times: Times = done[f"{which}: bound {dipole:g} A m2"]
            v = times.at_claim
            short = [x.gap for x in v]
            rows.append(
                [
                    which,
                    f"{dipole:g}",
                    f"{claimed:.0f}",
                    f"{v[at].needed:.3f}",
                    f"{v[at].impulse:.3f}",
                    f"{v[at].slack:.3f}",
                    _least(v[at].gap),
                    f"{sum(s > 0 for s in short)} of {len(short)}"
                    + (
                        f", short by {min(s for s in short if s > 0):.3f} to {max(short):.3f}" if max(short) > 0 else ""
                    ),
                    _spread(times.least),
                    _spread(times.simple),
                ]
            )
    per_mass = [done[f"{w}: bound per mass"].least for w in CLAIMS]
    header = "manoeuvre|A m² a rod|the paper's time, s|needed, N m s|rods' most|slack|short|excluded at|least time, s|the same along ΔH only".split(
        "|"
    )
    return f"""
## The balance of momentum

How long must a manoeuvre take, whatever law flies it? Let H = R(JΩ + l_w e₁) be the momentum of body and wheel in inertial axes.

1. The wheel's torque is internal, so dH/dt = m × B + d: only the rods' dipole m in the field B, and disturbances d, change H.
2. The rods give a dipole in a polytope that turns with the body. Its farthest corner is at 2.4446 μ_max for the paper's axes (computed from them), so
   m lies in the ball |m| ≤ ρ = 2.4446 μ_max whatever the attitude. The attitude on the way drops out, and with it all that is not convex.
3. At the end R = R_d, Ω = Ω_d, and the wheel keeps some l with |l| ≤ l_max: H(T) = R_d(JΩ_d + l e₁).
   With D = R_d JΩ_d − H(0) and a = R_d e₁ the rods and d must have given D + l a.
4. For any vector p, p·(m × B) = m·(B × p) ≤ ρ|B × p|. So **T is impossible if some unit p has**
   g(p) = p·D − l_max |p·a| − ρ ∫₀ᵀ |B × p| dt − s(T) > 0.
   The slack s(T) bounds ∫|d| (gravity gradient by 3/2 μ/r³ (J₃ − J₁), drag by all plates facing the flow at twice the largest pressure) and what an end within 2° and 10⁻³ rad/s may add.
5. Reachable and required momenta are convex and compact, so by separation such a p exists whenever they are disjoint: nothing is lost after step 2. g is concave; its
   maximum over the unit ball is a convex problem (SLSQP, with |p·a| as two linear constraints). The p found proves the claim by itself, however it was found.
6. The integral is bounded from above: |B × p| is convex in B, so trapezoids on the chords of B over 1 s overestimate it, and B is within h²/8 max|B″| of its chords.
7. As T grows, g falls no faster than c = |Ω_d|(|JΩ_d| + l_max) + ρ max|B| + max|d|, so g(T) > 0 excludes [T, T + g/c) as a whole. Marching so from T = 0 excludes **every** time before the
   one at which it stops. It is tight for dipoles in the ball: at 1.15 times the bound a linear program (in the tests) finds such a history.

In SI units, with the field of the scenario; the figures in the middle at 160° E, “excluded at” and the ranges over {len(BOUND_NODES)} longitudes:

{_table(header, rows)}

{_picture("momentum", "least times against node longitude")}

{_verdict(done)} Taking p along D alone,
as one would by hand, never gives more than the convex bound and often much less. Per unit of mass the bound is {_spread(per_mass[0])} s for V.B and {_spread(per_mass[1])} s for V.C: no obstacle.

    python -m studies momentum-bound scenarios/paper_no_singularity.yaml --set "plant.J_B=[[2.13,0,0],[0,3.04,0],[0,0,3.09]]" --time "193 s" --dipole-max 15

answers for any scenario of the three blocks, with exit status 1 where the time is impossible.
"""


def _verdict(done: dict[str, Any]) -> str:
    words = []
    for which in CLAIMS:
        limit, claimed = PAPER_LIMITS[which]
        for dipole in (limit, 25.0):
            gaps = [v.gap for v in done[f"{which}: bound {dipole:g} A m2"].at_claim]
            count = sum(gap > 0.0 for gap in gaps)
            where = (
                "at every longitude"
                if count == len(gaps)
                else "at none"
                if count == 0
                else f"at {count} longitudes of {len(gaps)}"
            )
            words.append(f"{which}'s {claimed:.0f} s at {dipole:g} A m² {where}")
    return f"The balance excludes {', '.join(words)}; what it does not exclude the law may still not do."


def _least(gap: float) -> str:
    return f"{gap:.3f}" if gap > 0.0 else "not excluded"


def _spread(values: Array) -> str:
    found = values[np.isfinite(values)]
    more = f", beyond 1500 at {int(np.isnan(values).sum())}" if np.isnan(values).any() else ""
    return f"{found.min():.0f} to {found.max():.0f}{more}" if len(found) else "beyond 1500"


def _ranges(mask: Array) -> str:
    """ "165 to 302" of a circle of 360 flags."""
    found: list[str] = []
    at = 0
    while at < len(mask):
        if mask[at]:
            end = at
            while end + 1 < len(mask) and mask[end + 1]:
                end += 1
            found.append(f"{at}" if end == at else f"{at} to {end}")
            at = end
        at += 1
    return ", ".join(found) + "°" if found else "none"


def _latch(done: dict[str, Any]) -> str:
    rows = []
    for key, said in (("latch 0.65 0.9", "0.65, 0.9 (the scenario's)"), ("latch 0.4 1", "0.40, 1.0")):
        code = hold_outcome(done[key])
        rows.append(
            [said] + [f"{int((code == i).sum())}" for i in range(len(HOLDS))] + [_ranges(np.isin(code, (3, 4)))]
        )
    latched: Run = done["latched run"]
    seen = done["latch 0.65 0.9"]
    code = hold_outcome(seen)
    stuck = np.isin(code, (3, 4))
    wheel = np.isfinite(seen.wheel_at_limit_since[stuck])
    released = (code == 1) | (code == 2)
    return f"""
## The hold that never lets go

While a demand is at 80% of its limit the paper's scheme keeps all inputs at their last values. Held, the wheel torque stays what it was, so the wheel
runs up; the rate that the held torque builds raises the demand, and nothing brings it down. Every run of a scenario with a `holds` section names what became of it: never
held, held at zero from the start, held and released, or latched with the time and the limits that stand. V.C by the longitude of its node, 1° apart:

{_table(["K₀, L₀ scale", *HOLDS, "latched at"], rows)}

{_picture("latch", "outcome of the hold by node longitude, and a run that latches")}

Of the {int(stuck.sum())} runs that latch with the scenario's gains, {int(wheel.sum())} end with the wheel at its 30 mN m s, and none is within {math.degrees(float(seen.attitude_error[stuck].min())):.0f}° of its goal.
Where the hold is released, that takes {np.min(seen.hold_longest[released]):.1f} to {np.max(seen.hold_longest[released]):.1f} s. At 200° E

    orchestrate scenarios/paper_singularity.yaml --set plant.node_longitude="200 deg"

ends with status 1 and the line

> commands: {latched.hold}
"""


def _complex(value: complex) -> str:
    if abs(value.imag) < 1e-12:
        return f"{value.real:+.5f}"
    return f"{value.real:+.5f} ± {abs(value.imag):.5f}i"


def _convergence(done: dict[str, Any]) -> str:
    c, e, edge = (done[k] for k in ("random starts, constant", "random starts, error", "starts at the edge"))
    law = convergence.at_rest(read(ROOT / SCENARIOS["V.B"]).loop.controller)
    K, L = law.kappa0 * law.K0, law.lambda0 * law.L0
    rows = []
    for which, name in enumerate(convergence.EQUILIBRIA):
        expected = convergence.analytic_eigenvalues(law.J_B, K, L, which)
        measured = convergence.measured_eigenvalues(law, which)
        shown = list(dict.fromkeys(_complex(v) for v in expected))
        unstable = int((expected.real > 0.0).sum())
        rows.append([name, f"{unstable}", ", ".join(shown), f"{np.abs(expected - measured).max():.0e}"])
    rose = e.steps_up > 0
    return f"""
## Almost-global convergence

600 attitudes uniform on SO(3) with rates uniform in a ball of {
        convergence.RATE_MAX:g} rad/s (seed 1), exact torque, gravity gradient acting, LVLH hold for 600 s, RK4 at 0.1 s:

{
        _table(
            [
                "gains",
                "converge",
                "settled, s (median, last)",
                "V rises in",
                "largest rise over V(0)",
                "dV/dt + ω·Lω over its size",
            ],
            [
                [
                    "constant",
                    f"{int(np.isfinite(c.converged).sum())} of {len(c.converged)}",
                    f"{np.nanmedian(c.converged):.0f}, {np.nanmax(c.converged):.0f}",
                    f"{int((c.steps_up > 0).sum())}",
                    "none",
                    f"{c.rate_error:.0e}",
                ],
                [
                    "[10], following the errors",
                    f"{int(np.isfinite(e.converged).sum())} of {len(e.converged)}",
                    f"{np.nanmedian(e.converged):.0f}, {np.nanmax(e.converged):.0f}",
                    f"{int(rose.sum())} ({100 * rose.mean():.0f}%)",
                    f"{100 * e.largest_rise.max():.1f}% (median of those {100 * np.median(e.largest_rise[rose]):.2g}%)",
                    "does not apply",
                ],
            ],
        )
    }

{_picture("convergence", "settling times and rises of V of random starts")}

So the paper's theorem holds as stated, for constant gains. With its gains [10] the argument has a gap: K and L change with the state, which [11] does not count, and V can rise. All starts converge nonetheless.
Convergence cannot be global: the law also rests at the half turns about the axes. With the k and l that [10] has at rest after a start from there, the eigenvalues (1/s) of the loop there, analytic from
Jω̇ = J(ω × W) − ω × JW − W × Jω − Lω − Hη, η̇ = ω, W = QᵢᵀΩ_d, H = diag(tr(KQᵢ) − (KQᵢ)ⱼⱼ), and by central differences of the controller's own functions:

{_table(["equilibrium", "unstable", "eigenvalues", "largest difference"], rows)}

{int(np.isfinite(edge.converged).sum())} of {
        len(edge.converged)
    } starts at rest 10⁻⁶ rad from the three unstable ones leave them and settle, the last at {
        np.nanmax(edge.converged):.0f} s.
"""


def _robustness(done: dict[str, Any]) -> str:
    rows = []
    for which in CLAIMS:
        drag, wrong = done[f"{which}: drag"], done[f"{which}: wrong inertia"]
        moments = sweep.drag_moments(which)
        at = float(np.interp(math.log(1e-5), np.log(moments), np.degrees(drag.attitude_error)))
        own = float(moments[np.abs(sweep.DRAG_FACTORS - 1.0).argmin()])
        rows.append(
            [
                which,
                f"{own:.1e}",
                f"{math.degrees(float(drag.attitude_error[np.abs(sweep.DRAG_FACTORS - 1.0).argmin()])):.2g}°",
                f"{at:.2g}°" if moments[0] <= 1e-5 <= moments[-1] else "not reached",
                f"{int(np.isfinite(wrong.settled).sum())} of {len(wrong.settled)}",
                f"{np.nanmin(wrong.settled):.0f} to {np.nanmax(wrong.settled):.0f}",
                f"{100 * all_hold(which, wrong).mean():.0f}%",
            ]
        )
    w = done["random starts, wrong inertia"]
    header = "manoeuvre|drag moment as modelled (SI), N m|error at the end|error with the paper's 10⁻⁵ N m|inertia off: settle|settled, s|keep every claim".split(
        "|"
    )
    return f"""
## Robustness

Drag that the law does not know, and a body whose inertia is off by up to 10% (J' = S(1 + 0.1E)S, S² = J, E with random axes and eigenvalues in [−1, 1], 200 cases, seed 2), with actuators and hold in the loop,
mass-normalised:

{_table(header, rows)}

{_picture("robustness", "offset by drag, and settling with wrong inertia")}

The law has no integral action, so drag leaves an offset in proportion to it (below 10⁻⁶ N m the figure shows what is left of the transient); “robust” is fair at the moment that the atmosphere gives and at the paper's. Wrong inertia changes when it settles, not whether: with exact torque and gains [10],
{int(np.isfinite(w.converged).sum())} of {len(w.converged)} random starts settle on bodies 10% off. Where a claim is lost it is the settling time.
"""


def _orbit(done: dict[str, Any]) -> str:
    r, d = done["hold over an orbit"], done["with drag"]
    b = r.signals["b_wheel"]
    crossings = int((np.sign(b[1:]) * np.sign(b[:-1]) < 0).sum())
    rows = [
        [
            said,
            _degrees(x.signals["attitude_error"].max()),
            f"{x.signals['demand_fraction'].max():.2g}",
            f"{1e3 * np.abs(x.signals['h_w']).max():.2g}",
            x.hold,
        ]
        for said, x in (("as modelled", r), ("10⁻⁵ N m (SI)", d))
    ]
    return f"""
## Round the orbit

“A wheel on the roll axis keeps the satellite controllable round its sun-synchronous orbit.” In LVLH the field's part along the wheel changes its sign {crossings} times in the orbit shown, where the
field is normal to the velocity, and is below a tenth of the field during {100 * (np.abs(b) < 0.1).mean():.0f}% of it. At those instants wheel and rods together give torques in a plane only; over the orbit they give all. An orbit of LVLH hold
from rest, mass-normalised:

{_table(["drag", "largest error", "largest demand over its limit", "wheel, mN m s", "commands"], rows)}

{_picture("orbit", "b1, error and demand over an orbit of LVLH hold")}

So the claim is fair for holding. It is not for a manoeuvre that meets a crossing at large demand, as V.C shows.
"""


def _made(done: dict[str, Any]) -> str:
    outcomes = "; ".join(OUTCOMES)
    counts = np.bincount(outcome("V.C", done["latch 0.65 0.9"]), minlength=len(OUTCOMES)).tolist()
    return f"""
## How this page is made

`make reproduction` computes everything anew (about five minutes on two cores) and writes this page and its figures; seeds are fixed, so the numbers return. The claims' table and the hold over an orbit come from the FMUs through `orchestration`,
the maps from `studies/loops.py`, the bound from `studies/momentum_bound.py`, convergence from `studies/convergence.py`. The maps' outcomes are: {outcomes}
(V.C at 360 longitudes with the scenario's gains: {", ".join(map(str, counts))}). Not reproduced: the shape of the paper's curves, of which no data are published.
"""
