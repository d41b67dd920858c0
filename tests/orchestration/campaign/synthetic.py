"""A campaign's folder as the engine leaves it, made of drawn numbers.

`python -m tests.orchestration.campaign.synthetic DIR RUNS` writes one, with its page.
"""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from orchestration.campaign import sums
from orchestration.campaign.file.analysis import Search, Sensitivity
from orchestration.campaign.statistics import search, sensitivity
from orchestration.campaign.statistics.verdicts import Announced, Requirement, verdicts

from .analytic import Analytic

_VARIED = [
    ("plant.h_w0", "uniform from -5 to 5 mN.m.s", "mN.m.s", ["plant.h_w0"]),
    ("rate", "normal, mean 0, standard deviation 0.01 rad/s", "rad/s", ["rate"]),
    ("plant.Q0", "uniform on SO(3)", "", [f"plant.Q0.q{i}" for i in range(4)]),
    ("inertia_error", "normal, mean 1, standard deviation 0.05, from 0.9 to 1.1", "", ["inertia_error"]),
    ("plant.density", "one of quiet, mean, storm", "", ["plant.density"]),
]


def write(
    folder: Path,
    runs: int = 1000,
    seed: int = 1,
    early: bool = False,
    analyses: bool = True,
    all_fail: bool = False,
    **more: Any,
) -> Path:
    """Writes campaign.json and runs/part-*.parquet. `more` goes into the manifest."""
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(runs, 4))
    q *= np.sign(q[:, :1]) / np.linalg.norm(q, axis=1)[:, None]
    wheel, rate, error = rng.uniform(-5, 5, runs), rng.normal(0, 0.01, runs), 1 + 0.05 * rng.normal(size=runs)
    density = rng.choice(["quiet", "mean", "storm"], runs)
    angle = 2 * np.arccos(q[:, 0])
    settle = 500 + 150 * angle + 6000 * np.abs(rate) + 3 * wheel**2 + 40 * rng.normal(size=runs)
    settle[rate > 0.031] = np.inf
    rms = 1e-3 * np.exp(0.4 * rng.normal(size=runs) + 2 * (error - 1) + 0.3 * (density == "storm"))
    share = 1 - np.abs(0.004 * rng.standard_cauchy(runs)).clip(0, 0.4)
    failed = (error > 1.1) & (rng.random(runs) < 0.3) | all_fail
    reason = np.where(
        rng.random(runs) < 0.8,
        "plant: fmi2DoStep at 812.5 s: the state is not finite",
        "controller: fmi2ExitInitializationMode in initialization: J_B is not positive definite",
    )
    met = {
        "settles": settle < 1158,
        "points": rms < 5e-3,
        "available": share > 0.98,
        "never <b>saturates</b>": wheel < 4.9,
    }
    met = {name: values & ~failed for name, values in met.items()}
    table = {
        "index": np.arange(runs),
        "status": np.where(failed, "failed", "ok"),
        "reason": pa.array(np.where(failed, reason, None), pa.string()),
        "wall": rng.uniform(0.07, 0.09, runs),
        "plant.h_w0": wheel,
        "rate": rate,
        **{f"plant.Q0.q{i}": q[:, i] for i in range(4)},
        "inertia_error": error,
        "plant.density": density,
        **{
            name: pa.array(values, mask=failed) for name, values in (("settle", settle), ("rms", rms), ("share", share))
        },
        **{f"met: {name}": pa.array(values, mask=failed) for name, values in met.items()},
        "expect: the wheel stays within its limits": pa.array(wheel < 4.99, mask=failed),
    }
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    columns = pa.table(table)
    for number, part in enumerate(np.array_split(rng.permutation(runs), 3)):
        pq.write_table(columns.take(part), folder / "runs" / f"part-{number:06d}.parquet")
    bounds = {"settles": (None, 1158.0), "points": (None, 5e-3), "available": (0.98, None)}
    requirements = [
        Requirement("settles", 0.9, 0.95),
        Requirement("points", 0.997, 0.95),
        Requirement("available", 0.9, 0.95),
    ]
    requirements.append(Requirement("never <b>saturates</b>", 0.99, 0.95))
    metric = {"settles": "settle", "points": "rms", "available": "share"}
    expected = {"settles": "< 1158 s", "points": "< 5 mrad", "available": "> 0.98"}
    expectation, counts = "the wheel stays within its limits", {name: int(m.sum()) for name, m in met.items()}
    place = 0
    varied = []
    for name, text, unit, names in _VARIED:
        count = 3 if len(names) == 4 else 1
        entry = {
            "name": name,
            "drawn": name in ("rate", "inertia_error"),
            "distribution": {},
            "text": text,
            "unit": unit,
        }
        varied.append({**entry, "columns": names, "coordinates": [place, count]})
        place += count
    manifest: dict[str, Any] = {
        "campaign": "detumble_spread",
        "description": "Detumbling from any attitude, with the wheel anywhere and an inertia known to 5%.",
        "state": "stopped early" if early else "completed",
        "fingerprint": "0" * 64,
        "parts": {},
        "announced": {"runs": runs, "early": early},
        "seed": seed,
        "sampling": "random",
        "runs": {"wanted": runs, "flown": runs, "failed": int(failed.sum())},
        "varied": varied,
        "metrics": [
            {"name": "settle", "column": "settle", "unit": "s", "signal": "judge.rate_error_B",
             "text": "time from which |judge.rate_error_B| < 0.001 rad/s for good"},
            {"name": "rms", "column": "rms", "unit": "rad", "signal": "judge.attitude_error",
             "text": "rms of judge.attitude_error after 2 orbits"},
            {"name": "share", "column": "share", "unit": "", "signal": "judge.attitude_error",
             "text": "share of time with judge.attitude_error < 5 mrad"},
        ],
        "requirements": [
            {"name": c.name, **({"metric": metric[c.name]} if c.name in metric else {"expectation": expectation}),
             "column": f"met: {c.name}", "expected": expected.get(c.name, "met"),
             "low": bounds.get(c.name, (None, None))[0], "high": bounds.get(c.name, (None, None))[1],
             "probability": c.probability, "confidence": c.confidence}
            for c in requirements
        ],
        "expectations": [{"name": expectation, "column": f"expect: {expectation}"}],
        "verdicts": [asdict(v) for v in verdicts(requirements, counts, runs, Announced(runs, early))],
        "early": early,
        "scenario_file": "scenarios/paper_no_singularity.yaml",
        "campaign_file": "detumble_spread.yaml",
        "scenario": "paper_no_singularity",
        "fmus": {
            name: {"file": f"{name}.fmu", "sha256": 32 * sha} for name, sha in (("plant", "ab"), ("controller", "cd"))
        },
        "versions": {"attitude-cosim": "0.2.0"},
        "platform": "Linux",
        "started": "2026-11-22T01:00:00+00:00",
        "finished": "2026-11-22T01:01:00+00:00",
        "wall_time": 60.0,
        "kept": [3],
    }  # fmt: skip
    if analyses:
        manifest |= _analyses()
    files = {path.name: sums.digest(path) for path in (folder / "runs").iterdir()}
    sums.write(folder, {**manifest, "files": files, "withdrawn": [], **more})
    return folder


def _analyses() -> dict[str, Any]:
    runs = Analytic(lambda u: 500 + 400 * u[:, 2] ** 2 + 200 * np.abs(u[:, 1] - 0.5) * (1 + u[:, 0]) + 60 * u[:, 0], [])
    runs.entries = [(name, i, 1) for i, (name, *_) in enumerate(_VARIED)]
    runs.dimension, runs.bounded, runs.metrics = 5, [True] * 5, {"settle": "s"}
    runs.coordinates = [v[0] for v in _VARIED]
    asked = runs.fly
    runs.fly = lambda unit: {"settle": asked(unit)["y"]}
    return {
        "sensitivity": sensitivity.run(Sensitivity(points=256), runs, 1),
        "search": search.run(Search(metric="settle", runs=200), runs, 1),
    }


if __name__ == "__main__":
    from orchestration.campaign.report import page as report

    print(report.write(write(Path(sys.argv[1]), int(sys.argv[2]))))
