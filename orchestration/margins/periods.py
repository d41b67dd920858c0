"""Follows the answers to pulses over whole periods, for loops whose state no output shows.

A controller that plans and identifies has far more states than its outputs show, and a fit from piece to piece misses
the slow ones. Here flights with random pulses in the first pieces fly on undisturbed, and the answer in one period is
compared with that in the next. Their ratio needs no model and no coordinates of the hidden state. Where a linear map
takes each answer of a period to that of the next, the loop repeats, and the eigenvalues of the map are its Floquet
multipliers; where none does, it does not repeat, and has only the ratio.

Each pulse is flown with a and -a/2: the difference of the two answers is the error, as in `measure`. The size is the
one of several whose error is least.

Tests: tests/orchestration/margins/test_periods.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..fmu.model import Floats
from .analysis import Complex
from .floquet import UNSEEN, Coordinates, observed
from .inject import Altered, Rig
from .measure import LIMIT
from .search import Starts

PULSES = 4
"""Answers that are followed."""
LEAD = 6
"""Pieces with pulses before the first that counts."""
SIZES = (1e-2, 1e-3, 1e-4, 1e-5)
"""Sizes of pulses that are tried, beside the largest value of their port so far."""


@dataclass(frozen=True)
class Followed:
    """The answers to pulses over some periods."""

    labels: list[str]
    step: float
    """Seconds of a piece."""
    pieces: int
    """Of a period."""
    answers: Floats
    """(pulses, instants, coordinates), each port in units of its mean square over all of it."""
    errors: Floats
    """The same of the difference between pulses of a and -a/2."""
    size: float
    """Of the pulses, beside the largest value of their port."""
    tried: tuple[tuple[float, float], ...]
    """Sizes that were tried, each with its error."""

    @property
    def left(self) -> float:
        """The size in the last period, beside that in the first."""
        n = self.pieces
        return float(np.linalg.norm(self.answers[:, -n:]) / np.linalg.norm(self.answers[:, :n]))

    @property
    def error(self) -> float:
        """The largest error of two periods one after the other."""
        return max(one.error for one in self.windows)

    def window(self, first: int = 0) -> Window:
        """Returns two periods that begin so many pieces after the pulses."""
        count, n = len(self.answers), self.pieces
        then, now = (self.answers[:, first + k * n : first + (k + 1) * n].reshape(count, -1) for k in (0, 1))
        wrong = self.errors[:, first : first + 2 * n].reshape(count, -1)
        size = max(float(np.hypot(np.linalg.norm(then), np.linalg.norm(now))), 1e-300)
        return Window(then, now, float(np.linalg.norm(wrong)) / size)

    @cached_property
    def windows(self) -> list[Window]:
        """Each period with the next."""
        return [self.window(k * self.pieces) for k in range(self.answers.shape[1] // self.pieces - 1)]

    @property
    def decay(self) -> float:
        """Part of a disturbance that is left after the last period: the largest multiplier where the loop repeats, else
        the ratio. NaN where there is no number."""
        if self.refused:
            return math.nan
        last = self.windows[-1]
        return float(abs(last.multipliers[0])) if self.repeats else last.ratio

    @property
    def repeats(self) -> bool:
        """Returns whether a linear map takes the last period but one to the last."""
        return self.windows[-1].rest <= UNSEEN

    @property
    def refused(self) -> str:
        """Reason for which there is no number, or nothing."""
        if self.error > LIMIT:
            sizes = [size for size, _ in self.tried]
            return (
                f"the loop is not linear here: with pulses of {min(sizes):g} to {max(sizes):g} of the signal, the "
                f"answers to a pulse and to its half with the other sign differ by {100 * self.error:.2g} % at least"
            )
        if not self.answers[:, : self.pieces].any():
            return "nothing comes of what is injected"
        return ""

    def lines(self) -> list[str]:
        """Returns what is told of it."""
        if self.refused:
            return [self.refused]
        said = [
            f"period {k + 2} beside period {k + 1}: {one.ratio:.4g}; of the pulses {one.least:.4g} to {one.most:.4g} "
            f"(error {100 * one.error:.2g} %)"
            for k, one in enumerate(self.windows)
        ]
        last = self.windows[-1]
        if not self.repeats:
            return [*said, f"no multipliers: {100 * last.rest:.2g} % of a period does not follow from the one before"]
        return [*said, "|multipliers|: " + ", ".join(f"{abs(value):.4g}" for value in last.multipliers)]


@dataclass(frozen=True)
class Window:
    """The answers in two periods one after the other, (pulses, samples)."""

    then: Floats
    now: Floats
    error: float
    """Of the answers, beside their size."""

    @property
    def ratio(self) -> float:
        """The size of the second, beside the first: the factor by which a disturbance is left after a period."""
        return float(np.linalg.norm(self.now) / np.linalg.norm(self.then))

    @property
    def most(self) -> float:
        """The same of the pulse with the largest."""
        return float((np.linalg.norm(self.now, axis=1) / np.linalg.norm(self.then, axis=1)).max())

    @property
    def least(self) -> float:
        """The same of the pulse with the least."""
        return float((np.linalg.norm(self.now, axis=1) / np.linalg.norm(self.then, axis=1)).min())

    @property
    def multipliers(self) -> Complex:
        """The eigenvalues of the map from period to period, the largest first. No result where `rest` is large."""
        return self._map[0]

    @property
    def rest(self) -> float:
        """Part of the second period that the map leaves, over its size: small where the loop repeats."""
        return self._map[1]

    @cached_property
    def _map(self) -> tuple[Complex, float]:
        U, s, V = np.linalg.svd(self.then.T, full_matrices=False)
        rank = max(int((s > max(10.0 * self.error, 1e-9) * s[0]).sum()), 1)
        F = U[:, :rank].T @ self.now.T @ V[:rank].T / s[:rank]
        left = self.now.T - U[:, :rank] @ F @ (U[:, :rank].T @ self.then.T)
        values = np.linalg.eigvals(F).astype(complex)
        return values[np.argsort(-np.abs(values))], float(np.linalg.norm(left) / np.linalg.norm(self.now))


def follow(
    rig: Rig,
    seen: Coordinates,
    period: int,
    periods: int,
    piece: int,
    altered: Altered = Altered(),  # noqa: B008  (it is frozen)
    starts: Starts = None,
    pulses: int = PULSES,
    sizes: Sequence[float] = SIZES,
    moved: int | None = None,
) -> Followed:
    """Returns the answers over so many periods, each of `period` samples, in pieces of `piece` samples.

    They begin LEAD pieces after the rig's instant. Of the channels the first `moved` get pulses, or all. Raises
    BlockError where a block fails."""
    pieces, channels = max(round(period / piece), 1), len(rig.site.channels)
    at = rig if starts is None else Rig(rig.session, rig.site, rig.first, starts)
    instants = LEAD + periods * pieces
    rng = np.random.default_rng(1)
    shape = pulses, LEAD, channels
    given = rng.uniform(0.3, 1.0, shape) * rng.choice([-1.0, 1.0], shape)
    given[..., channels if moved is None else moved :] = 0.0

    def flown(pulse: Floats) -> Floats:
        injected = np.zeros((instants * piece + 1, channels))
        injected[: LEAD * piece : piece] = pulse * at.scales
        return observed(at, seen, injected, piece, altered)[LEAD : LEAD + periods * pieces]

    still = flown(np.zeros(shape[1:]))

    def answered(pulse: Floats, size: float) -> tuple[Floats, Floats]:
        whole, half = (seen.difference(still, flown(part * size * pulse)) / part / size for part in (1.0, -0.5))
        return 0.5 * (whole + half), whole - half

    def made(found: list[tuple[Floats, Floats]], size: float) -> Followed:
        answers, errors = (np.array([one[k] for one in found]) for k in (0, 1))
        ports = np.repeat(
            np.arange(len(seen.variables)), [3 if v.shape == (3, 3) else v.size for _, v in seen.variables]
        )
        mean = np.array([np.sqrt((answers[..., ports == port] ** 2).mean()) for port in ports])
        scale = np.maximum(mean, 1e-300)
        return Followed(seen.labels, piece * rig.period, pieces, answers / scale, errors / scale, size, ())

    tries = [(size, answered(given[0], size)) for size in sizes]
    errors = [made([answer], size).error for size, answer in tries]
    size, first = tries[int(np.argmin(errors))]
    done = made([first, *(answered(pulse, size) for pulse in given[1:])], size)
    return replace(done, tried=tuple((tried, error) for (tried, _), error in zip(tries, errors, strict=True)))
