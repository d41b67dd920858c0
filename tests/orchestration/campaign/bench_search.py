"""How often a search finds a worse case than as many random runs:
`python -m tests.orchestration.campaign.bench_search`.

Functions of the unit cube, 8 seeds each, and SciPy's differential evolution beside it. Half a minute.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import differential_evolution

from orchestration.campaign.file.analysis import Search
from orchestration.campaign.statistics import search

from .analytic import Analytic, Floats, ackley, edge, peaks, separate


def evolved(function: Analytic, runs: int, seed: int) -> float:
    """The largest value that differential evolution finds in so many runs."""
    d = function.dimension
    count = max(5, min(5 * d, runs // 8))

    def least(points: Floats) -> Floats:
        return -function.function(points.T)

    generations = runs // count - 1
    options = {"popsize": -(-count // d), "maxiter": generations, "polish": False, "updating": "deferred", "tol": 0.0}
    return -float(differential_evolution(least, [(0, 1)] * d, vectorized=True, rng=seed, **options).fun)


def main() -> None:
    """Prints a table."""
    print("function  d  runs  search  differential evolution")
    totals = np.zeros(2)
    for function in (ackley, edge, peaks):
        for d in (3, 6):
            for runs in (100, 300, 1000):
                wins = np.zeros(2)
                for seed in range(8):
                    asked = Analytic(function, separate(d))
                    drawn = function(np.random.default_rng(seed).random((runs, d))).max()
                    wins += (
                        search.run(Search(metric="y", runs=runs), asked, seed)["value"] > drawn,
                        evolved(asked, runs, seed) > drawn,
                    )
                totals += wins
                print(f"{function.__name__:8} {d:2} {runs:5} {wins[0] / 8:7.0%} {wins[1] / 8:7.0%}")
    print("all {:.0%} {:.0%}".format(*(totals / (18 * 8))))


if __name__ == "__main__":
    main()
