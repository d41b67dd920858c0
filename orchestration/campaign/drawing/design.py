"""The points of the unit cube at which a campaign's runs are flown.

With `random`, point i is drawn by a generator of its own, made of the seed and i alone. Latin hypercubes and Sobol's
sequence are designs of all runs together, made of the seed, their number and the number of coordinates. A grid goes
through its points in turn, the last entry first, and draws its other coordinates as `random` does.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...fmu.model import Floats
from ..file.distributions import Steps
from .draws import Draws
from .samplers import Pick

_NUMBERS_MAX = 10**9
"""Of a design that is made as a whole: 8 GB."""


@dataclass
class Design:
    """Choice of points; `points` gives them by the indices of the runs."""

    sampling: str
    seed: int
    runs: int
    dimension: int
    axes: tuple[tuple[int, int], ...] = ()
    """Of a grid: the coordinates that it goes through, and how many values each has."""
    _whole: Floats | None = field(default=None, repr=False, compare=False)

    @property
    def early(self) -> bool:
        """Returns whether points are made all together, before the first run."""
        return self.sampling in ("latin hypercube", "sobol")

    def points(self, indices: Sequence[int] | NDArray[np.int64]) -> Floats:
        """Returns the points (n, dimension) of these runs, each coordinate in [0, 1)."""
        if self.early:
            if self._whole is None:
                self._whole = self._make()
            return self._whole[np.asarray(indices, np.int64)]
        return np.array([self._drawn(int(i)) for i in indices]).reshape(len(indices), self.dimension)

    def _drawn(self, index: int) -> Floats:
        generator = np.random.Generator(np.random.PCG64(np.random.SeedSequence(self.seed, spawn_key=(index,))))
        point = generator.random(self.dimension)
        for coordinate, count in reversed(self.axes):
            index, place = divmod(index, count)
            point[coordinate] = (place + 0.5) / count
        return point

    def _make(self) -> Floats:
        from scipy.stats import qmc  # 0.4 s, and only for these two  # noqa: PLC0415

        generator = np.random.Generator(np.random.PCG64(np.random.SeedSequence(self.seed)))
        if self.dimension == 0:
            return np.zeros((self.runs, 0))
        engine = qmc.Sobol if self.sampling == "sobol" else qmc.LatinHypercube
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # a number of runs that is no power of 2: `notes` says so
            return np.asarray(engine(self.dimension, rng=generator).random(self.runs), float)


def design(sampling: str, seed: int, runs: int | None, draws: Draws) -> Design:
    """Returns the design of a campaign. Raises InputError."""
    axes: tuple[tuple[int, int], ...] = ()
    if sampling == "grid":
        axes = tuple(
            (draw.first, len(draw.sampler.values))
            for draw in draws.draws
            if isinstance(draw.sampler, Pick) and draw.sampler.axis
        )
        points = math.prod(count for _, count in axes)
        if runs is not None and runs % points:
            raise InputError(f"runs: the grid has {points} points; expected a multiple of them, found {runs}")
        runs = runs or points
    runs = runs or 1000
    if sampling in ("latin hypercube", "sobol") and runs * draws.dimension > _NUMBERS_MAX:
        message = f"sampling: {sampling} makes all {runs} points of {draws.dimension} coordinates at once"
        raise InputError(f"{message}; remedy: sampling: random")
    return Design(sampling, seed, runs, draws.dimension, axes)


def samples(draws: Draws) -> Iterator[list[float]]:
    """Yields the centre of the unit cube, and the points beside it that have each value of each choice and grid; of
    steps the two ends.
    """
    centre = [0.5] * draws.dimension
    yield centre
    for draw in draws.draws:
        if isinstance(draw.sampler, Pick):
            middles = [0.5 * (low + high) for low, high in pairwise((0.0, *draw.sampler.ends)) if low < high]
            for u in (middles[0], middles[-1]) if isinstance(draw.entry.grid, Steps) else middles:
                yield [*centre[: draw.first], u, *centre[draw.first + 1 :]]


def notes(design: Design) -> list[str]:
    """Returns remarks on a design."""
    if design.sampling == "sobol" and design.runs & (design.runs - 1):
        near = 1 << design.runs.bit_length()
        return [
            f"{design.runs} points of Sobol's sequence are balanced less well than a power of 2, such as "
            f"{near // 2} or {near}"
        ]
    return []
