"""Gains for law [8] in SI units with the bounded allocator: a random search on tumbles that nothing else flies."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from ..crew import Crew, crew
from ..paper import ORBIT
from .cases import LONG, SEEDS, tumbles
from .make import FOLDER
from .schemes import tuned

SEED = 4000
CANDIDATES, TUMBLES, FINALISTS = 60, 16, 6


def gains(k: float, l: float, kappa: float, lam: float, schedule: str) -> dict[str, Any]:  # noqa: E741
    """K = k diag(0.9, 1, 1.1), L = l I; `schedule` "error" has k and l follow the errors with kappa0 and lambda0 [10]."""
    return {
        "K0": [0.9 * k, k, 1.1 * k],
        "L0": (l * np.eye(3)).tolist(),
        "gain_schedule": schedule,
        "kappa0": kappa,
        "lambda0": lam,
    }


def score(hands: Crew, candidate: dict[str, Any], runs: int) -> tuple[int, float]:
    """How many tumbles settle below 5 deg in three orbits, and the mean time with three orbits for those that do not, orbits."""
    usual = tumbles("tune", SEEDS["tune"], runs)
    rows = hands.fly(replace(usual, scenario=tuned(usual.scenario, candidate)).case, FOLDER / "tune")
    times = np.maximum(rows.numbers("angle_5"), rows.numbers("rate"))
    return int(np.isfinite(times).sum()), float(np.where(np.isfinite(times), times, LONG).mean()) / ORBIT


def search(jobs: int = 2) -> Iterator[str]:
    """Lines that tell the best; random candidates on a few tumbles, then the first of them on more."""
    rng = np.random.default_rng(SEED)
    log = lambda low, high: math.exp(rng.uniform(math.log(low), math.log(high)))  # noqa: E731
    candidates = []
    for i in range(CANDIDATES):
        schedule = "constant" if i % 2 else "error"
        kappa, lam = (1.0, 1.0) if i % 2 else (0.098, 1.47)
        candidates.append(gains(log(1e-4, 3e-2), log(3e-3, 1.0), kappa, lam, schedule))
    yield f"seeds: {SEED} for the candidates, {SEEDS['tune']} for the tumbles"
    with crew(jobs) as hands:
        for count, keep in ((TUMBLES, FINALISTS), (5 * TUMBLES, 1)):
            scores = [score(hands, candidate, count) for candidate in candidates]
            order = sorted(range(len(candidates)), key=lambda i: (-scores[i][0], scores[i][1]))
            for i in order[:FINALISTS]:
                g = candidates[i]
                yield f"{scores[i][0]} of {count} settle, mean {scores[i][1]:.2f} orbits: K0 {g['K0'][1]:.3g}, L0 {g['L0'][0][0]:.3g}, {g['gain_schedule']}"
            candidates = [candidates[i] for i in order[:keep]]
    yield f"best: {candidates[0]}"
