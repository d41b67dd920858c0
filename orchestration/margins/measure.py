"""Measures the frequency response of a loop by flights: one without injection, and two for each channel.

What is injected is d, what comes back v; the receiver takes u = v + d. Flights are compared with the one without
injection, so noise of a fixed seed cancels. With the loop's transfer matrix L, v = -L u, and dv/dd = S - I, S = (I +
L)^-1. Each channel is excited by a multisine of peak a, and by one of peak -a/2: where the loop is linear, both give
the same response. The difference is the error of the measurement, and above a limit there is no result, but a reason.

Tests: tests/orchestration/margins/test_measure.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..fmu.model import Floats
from .excitation import Complex, Multisine
from .inject import Rig

AMPLITUDES = tuple(10.0**-n for n in range(2, 7))
"""Peaks that are tried, beside the largest value of the signal so far, until one is good enough."""
GOOD = 2e-3
"""Error of a response, beside the response, with which no smaller peak is tried."""
LIMIT = 0.05
"""Error above which there is no result."""
_PROBE, LONGEST = 256, 65536
"""Samples after a pulse that are looked at: first, and at most."""
_SETTLED = 0.01
"""Share of the largest answer to a pulse below which it has died out."""
PERIODS = 2
_PERIOD = 1.25
"""A period of the multisine beside the time in which a pulse dies out."""


@dataclass
class Response:
    """What was measured at a site. Rows are frequencies; `S` (lines, channels, channels), S = (I + L)^-1."""

    labels: list[str]
    omega: Floats
    """rad/s"""
    S: Complex
    error: Floats
    """Of each channel's column, beside its size: nonlinearity, noise, and change from period to period."""
    amplitude: Floats
    """Peak of what was injected, in the unit of each channel."""
    step: float
    """Seconds from sample to sample."""
    pulse: Floats = field(default_factory=lambda: np.empty((0, 0, 0)))
    """dv/dd: what comes back of a pulse of 1, (samples, channels, channels)."""
    settling: int = 0
    """Samples in which the answer to a pulse dies out."""
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
    answer.settling = _settling(rig, answer, longest)
    if answer.settling:
        _respond(rig, answer, answer.settling)
    answer.flights = rig.flights
    return answer


def _settling(rig: Rig, answer: Response, longest: int) -> int:
    """Returns the samples in which the answer to a pulse dies out; 0, with the reason, where it does not."""
    n, count = len(rig.site.channels), min(_PROBE, longest)
    while True:
        base = rig.fly(np.zeros((count, n)))
        pulse = np.zeros((count, n))
        pulse[0] = 1e-3 * rig.scales
        size = np.abs((rig.fly(pulse) - base) / pulse[0]).max(axis=1)
        if not size.max() > 1e-9:
            answer.refused = "nothing comes back of what is injected: the loop is open here, saturated, or switches"
            return 0
        last = int(np.flatnonzero(size > _SETTLED * size.max())[-1]) + 1
        if last <= count // 2:
            return last
        if count >= longest:
            break
        count = min(4 * count, longest)
    quarters = [float(np.sqrt(np.mean(part**2))) for part in np.array_split(size, 4)]
    if quarters[3] < 0.5 * quarters[1]:
        answer.refused = f"the answer to a pulse has not died out after {count * rig.period:.4g} s; remedy: --window"
    else:
        answer.refused = (
            f"a pulse does not die out within {count * rig.period:.4g} s "
            f"(its answer is {quarters[3] / max(quarters[0], 1e-300):.3g} of that at first): "
            "the loop is unstable, in a limit cycle, or noise differs from flight to flight"
        )
    return 0


def _respond(rig: Rig, answer: Response, settling: int) -> None:
    """Measures the columns of S."""
    sine, n = Multisine(max(math.ceil(_PERIOD * settling), _PROBE // 2) // 2 * 2), len(rig.site.channels)
    signal = sine.signal(3 * settling // 2, PERIODS)
    shape = len(signal), n
    base = rig.fly(np.zeros(shape))
    scales = rig.scales
    noise = np.abs(rig.fly(np.zeros(shape)) - base).max(axis=0) / scales
    if noise.max() > 0.0:
        answer.warnings.append(
            f"two flights of the same differ by {noise.max():.2g} of the signal: a block's noise has no fixed seed"
        )
    answer.omega, columns = (
        sine.frequencies(rig.period),
        [_column(rig, sine, signal, base, j, scales[j]) for j in range(n)],
    )
    answer.pulse = sine.pulse(np.stack([column.mean for column in columns], axis=2))
    answer.S = sine.between(answer.pulse) + np.eye(n)
    answer.amplitude = scales * [column.share for column in columns]
    for j, column in enumerate(columns):
        answer.error[j] = max(column.unlike, column.change)
        if column.change > 5 * GOOD:
            answer.warnings.append(
                f"{answer.labels[j]}: the response changes by {100 * column.change:.2g} % within "
                f"{sine.samples * rig.period:.4g} s: the loop varies with time"
            )
    worst = int(np.argmax(answer.error))
    if answer.error[worst] > LIMIT:
        answer.refused = (
            f"{answer.labels[worst]}: the loop is not linear here: no peak between {AMPLITUDES[-1]:g} and "
            f"{AMPLITUDES[0]:g} of the signal gives the same response as its half with the other sign; the least "
            f"difference is {100 * answer.error[worst]:.2g} % (saturation, a switch, a quantized signal, or noise)"
        )
    elif answer.error[worst] > 5 * GOOD:
        answer.warnings.append(
            f"{answer.labels[worst]}: the response is uncertain by {100 * answer.error[worst]:.2g} %"
        )


@dataclass(frozen=True)
class _Column:
    """dv/dd of one channel (lines, channels), and how far its measurements differ, beside its size."""

    mean: Complex
    unlike: float
    """Between the two peaks."""
    change: float
    """From period to period."""
    share: float
    """The peak of the injection beside the channel's size."""


def _column(rig: Rig, sine: Multisine, signal: Floats, base: Floats, j: int, scale: float) -> _Column:
    best: _Column | None = None
    measured = PERIODS * sine.samples
    for share in AMPLITUDES:
        flown = []
        for part in (share, -0.5 * share):
            injected = np.zeros_like(base)
            injected[:, j] = part * scale * signal
            came = sine.spectrum((rig.fly(injected) - base)[-measured:])
            flown.append(came / sine.spectrum(injected[-measured:, j : j + 1]))
        found = np.array(flown)  # (peaks, periods, lines, channels)
        mean = found.mean(axis=(0, 1))
        size = np.maximum(np.abs(mean), 0.1 * np.abs(mean).max())
        unlike, change = (float((np.abs(np.diff(found, axis=axis)) / size).max()) for axis in (0, 1))
        if best is None or unlike < best.unlike:
            best = _Column(mean, unlike, change, share)
        elif unlike > 10 * best.unlike:
            break
        if unlike < GOOD:
            break
    assert best is not None
    return best
