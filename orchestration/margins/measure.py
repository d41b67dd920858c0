"""Measures the frequency response of a loop by flights: one without injection, and two for each channel.

What is injected is d, what comes back v; the receiver takes u = v + d. Flights are compared with the one without
injection, so noise of a fixed seed cancels. With the loop's transfer matrix L, v = -L u, and dv/dd = S - I, S = (I +
L)^-1. Each channel is given a pulse of size a, which has every line, and one of -a/2: where the loop is linear, both
give the same response. The difference is the error of the measurement, and above a limit there is no result, but a
reason. A last flight with pulses at a later instant tells whether the loop varies with time.

Tests: tests/orchestration/margins/test_measure.py.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..errors import BlockError
from ..fmu.model import Floats
from .analysis import Complex
from .inject import Rig

POINTS = 400
"""Frequencies of a response, by equal ratios from that of the window to half of the sampling frequency."""
AMPLITUDES = tuple(10.0**-n for n in range(2, 8))
"""Sizes of pulses that are tried, beside the largest value of the signal so far, until one is good enough."""
GOOD = 2e-3
"""Error of a response, beside the response, with which no smaller pulse is tried."""
LIMIT = 0.05
"""Error above which there is no result."""
VARIES = 0.3
"""Largest change of the response within a window above which there is no result."""
_PROBE, LONGEST = 256, 65536
"""Samples after a pulse that are looked at: first, and at most."""
_PROBE_SIZE = 1e-4
"""Pulse with which the window is sought, beside the signal."""
_SHARES = 1.0, 0.01
"""Shares of pulses in all channels: the next where an FMU refuses one."""
_GROWN = 1e3
"""Answer beside the pulse above which one that still grows is not followed further."""
_SETTLED = 1e-3
"""Share of the largest answer to a pulse below which it has died out."""
_ENOUGH = 0.02
"""Share that may be left at the end of the longest window: it is cut off, and counts as an error."""
_LATER = 0.13
"""When the pulses of the last flight begin, beside the window."""


@dataclass
class Response:
    """Response measured at a site. Rows are frequencies; `S` (lines, channels, channels), S = (I + L)^-1."""

    labels: list[str]
    omega: Floats
    """rad/s"""
    S: Complex
    error: Floats
    """Of each channel's column, beside its size: nonlinearity, noise, and what the window cuts off."""
    amplitude: Floats
    """Pulse that was injected, in the unit of each channel."""
    step: float
    """Seconds from sample to sample."""
    pulse: Floats = field(default_factory=lambda: np.empty((0, 0, 0)))
    """dv/dd: what comes back of a pulse of 1, (samples, channels, channels)."""
    change: float = 0.0
    """Of the response within the window, beside its largest size."""
    flights: int = 0
    warnings: list[str] = field(default_factory=list)
    refused: str = ""
    """Why there is no result; empty where there is."""

    @property
    def L(self) -> Complex:
        """The transfer matrix of the open loop (lines, channels, channels)."""
        return np.asarray(np.linalg.inv(self.S) - np.eye(len(self.labels)))

    @property
    def loops(self) -> Complex:
        """The open loop of each channel with the others closed (lines, channels)."""
        own = np.diagonal(self.S, axis1=1, axis2=2)
        return np.asarray((1.0 - own) / own)


def measure(rig: Rig, longest: int = LONGEST) -> Response:
    """Returns the frequency response of the loop at the rig's site. `longest`: samples of a flight's window at most.

    Raises BlockError where a block fails.
    """
    n = len(rig.site.channels)
    answer = Response(rig.site.labels, np.empty(0), np.empty((0, n, n), complex), np.zeros(n), np.zeros(n), rig.period)
    window, left = _window(rig, answer, longest)
    if window:
        _respond(rig, answer, window, left)
    answer.flights = rig.flights
    return answer


def spectrum(pulse: Floats, omega: Floats, step: float) -> Complex:
    """Returns the response (lines, ...) at omega (lines,) rad/s whose answer to a pulse this is, (samples, ...)."""
    turns = np.outer(omega * step, np.arange(len(pulse)))
    return np.asarray(np.tensordot(np.exp(-1j * turns), pulse, 1))


def _window(rig: Rig, answer: Response, longest: int) -> tuple[int, float]:
    """Returns the samples in which the answer to a pulse dies out, and what is left then beside the largest; 0, with
    the reason, where it does not."""
    n, count = len(rig.site.channels), min(_PROBE, longest)
    while True:
        base = rig.fly(np.zeros((count, n)))
        pulse = np.zeros((count, n))
        pulse[0] = _PROBE_SIZE * rig.scales
        sizes = np.abs(_answer(rig, pulse, base) / pulse[0])
        if not sizes.max() > 1e-9:
            answer.refused = "nothing comes back of what is injected: the loop is open here, saturated, or switches"
            return 0, 0.0
        size = (sizes / np.maximum(sizes.max(axis=0), 1e-9)).max(axis=1)
        first, _, third, last = (float(np.sqrt(np.mean(part**2))) for part in np.array_split(size, 4))
        left = float(size[-count // 8 :].max())
        if left < (_SETTLED if count < longest else _ENOUGH) and last < max(third, 1e-6):
            return count, left
        if count >= longest or (sizes.max() > _GROWN and last > 10 * first):
            break
        count = min(2 * count, longest)
    if last < 0.5 * first:
        answer.refused = (
            f"the answer to a pulse has not died out after {count * rig.period:.4g} s; remedy: a longer --window, or "
            "--orbit with --periods for a controller that plans or identifies"
        )
    else:
        ratio = f"its answer is {last / first:.3g} of that at first" if first > 0.0 else "its answer grows"
        answer.refused = (
            f"a pulse does not die out within {count * rig.period:.4g} s ({ratio}): the loop is unstable, in a limit "
            "cycle or slower than this, or noise differs from flight to flight"
        )
    return 0, 0.0


def _answer(rig: Rig, pulses: Floats, base: Floats) -> Floats:
    """Returns the answer to pulses, measured by smaller ones where an FMU refuses these, (samples, channels)."""
    failures = []
    for share in _SHARES:
        try:
            return (rig.fly(share * pulses) - base) / share
        except BlockError as error:
            failures.append(error)
    raise failures[-1]


def _respond(rig: Rig, answer: Response, window: int, left: float) -> None:
    """Measures the columns of S."""
    n, later = len(rig.site.channels), round(_LATER * window)
    scales, still = rig.scales, np.zeros((window + later, n))
    base = rig.fly(still)
    noise = np.abs(rig.fly(still) - base).max(axis=0) / scales
    if noise.max() > 0.0:
        answer.warnings.append(
            f"two flights of the same differ by {noise.max():.2g} of the signal: a block's noise has no fixed seed"
        )
    answer.omega = np.geomspace(np.pi / (2 * window), np.pi, POINTS) / rig.period
    columns = [_column(rig, answer.omega, base[:window], j, scales[j]) for j in range(n)]
    answer.pulse = np.stack([column.mean for column in columns], axis=2)
    answer.amplitude = scales * [column.share for column in columns]
    answer.error = np.array([max(column.unlike, left) for column in columns])
    answer.S = spectrum(answer.pulse, answer.omega, rig.period) + np.eye(n)
    still[later] = answer.amplitude
    after = _answer(rig, still, base)[later:]
    then, now = (spectrum(a, answer.omega, rig.period) for a in (after, answer.pulse @ answer.amplitude))
    answer.change = _apart(then, now, 1.0)
    worst = int(np.argmax(answer.error))
    seconds = later * rig.period
    if answer.error[worst] > LIMIT:
        answer.refused = (
            f"{answer.labels[worst]}: the loop is not linear here: no pulse between {AMPLITUDES[-1]:g} and "
            f"{AMPLITUDES[0]:g} of the signal gives the same response as its half with the other sign; the least "
            f"difference is {100 * answer.error[worst]:.2g} % (saturation, a switch, a quantized signal, or noise)"
        )
    elif answer.change > VARIES:
        answer.refused = (
            f"the response changes by {100 * answer.change:.2g} % within {seconds:.4g} s: the loop varies with time or "
            "repeats, and has no margins of a moment; remedy: multipliers by --orbit"
        )
    elif answer.error[worst] > 5 * GOOD:
        answer.warnings.append(
            f"{answer.labels[worst]}: the response is uncertain by {100 * answer.error[worst]:.2g} %"
        )
    if LIMIT < answer.change <= VARIES:
        answer.warnings.append(
            f"the response changes by {100 * answer.change:.2g} % within {seconds:.4g} s: the loop varies with time"
        )


@dataclass(frozen=True)
class _Column:
    """dv/dd of one channel, and how far its measurements differ, beside its size."""

    mean: Floats
    """Answer to a pulse of 1, (samples, channels)."""
    unlike: float
    share: float
    """The pulse beside the channel's size."""


def _column(rig: Rig, omega: Floats, base: Floats, j: int, scale: float) -> _Column:
    best: _Column | None = None
    failures = []
    for share in AMPLITUDES:
        found = []
        for part in (share * scale, -0.5 * share * scale):
            injected = np.zeros_like(base)
            injected[0, j] = part
            try:
                found.append((rig.fly(injected) - base) / part)
            except BlockError as error:  # a value that an FMU refuses
                failures.append(error)
                break
        if len(found) < 2:
            continue
        whole, half = (spectrum(one, omega, rig.period) for one in found)
        unlike = _apart(whole, half)
        if best is None or unlike < best.unlike:
            best = _Column(0.5 * (found[0] + found[1]), unlike, share)
        elif unlike > 10 * best.unlike:
            break
        if unlike < GOOD:
            break
    if best is None:
        raise failures[-1]
    return best


def _apart(a: Complex, b: Complex, least: float = 0.1) -> float:
    """Returns the largest difference of two responses (lines, channels), beside their size at this line or a share of
    the largest one of this channel."""
    size = np.maximum(np.abs(a + b) / 2, least * np.abs(b).max(axis=0))
    return float((np.abs(a - b) / np.maximum(size, 1e-300)).max())
