"""Runs that a campaign keeps. Its analyses: test_through_fmus.py."""

from __future__ import annotations

import json
from pathlib import Path

from .toy import changed, fly, rows


def test_runs_are_kept_with_their_signals(toy):
    changed(toy, ("runs: 60", "runs: 20\nkeep: {runs: [3], not_met: 2}"))
    fly(toy)
    missed = [row["index"] for row in rows() if not row["met: at rest"]][:2]
    kept = sorted({3, *missed})
    assert json.loads(Path("out/campaign.json").read_text("utf-8"))["kept"] == kept
    for index in kept:
        signals = Path(f"out/kept/{index}/signals.csv").read_text("utf-8").splitlines()
        assert len(signals) == 22
        assert float(signals[-1].split(",")[1]) == rows()[index]["final"]


def test_so_many_of_the_first_runs_that_failed_are_kept(toy):
    Path("mine.py").write_text(
        "def f(time, signals):\n"
        "    if signals['motor.speed'][0] < 1.7:\n        raise ValueError('slow')\n    return 1.0\n"
    )
    metric = "metrics:\n  - {name: own, python: 'mine:f', signals: [motor.speed]}"
    changed(toy, ("runs: 60", "runs: 20\nkeep: {failed: 3}"), ("metrics:", metric))
    fly(toy)
    failed = [row["index"] for row in rows() if row["status"] == "failed"]
    assert 3 < len(failed) < 20
    assert json.loads(Path("out/campaign.json").read_text("utf-8"))["kept"] == failed[:3]
