"""`campaign.json` says what a campaign was made of, and what came of it."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fmus.versions import version_of

from ..errors import InputError
from ..quantities import shown
from .case import Case
from .statistics.verdicts import Announced, Verdict
from .sums import MANIFEST, RUNS, read

if TYPE_CHECKING:
    from .flying.dataset import Dataset

_PACKAGES = ("attitude-cosim", "fmpy", "numpy", "scipy", "pyarrow", "distributed")


def manifest(
    case: Case,
    state: str,
    data: Dataset,
    verdicts: Sequence[Verdict],
    wall: float,
    earlier: Mapping[str, Any],
    announced: Announced,
) -> dict[str, Any]:
    """Returns the manifest, ready for JSON.

    `earlier` is that of an earlier start, whose begin and wall time count, too.
    """
    campaign, job = case.campaign, case.job
    written = campaign.model_dump(mode="json", exclude_none=True, by_alias=True)
    now = datetime.now(UTC).isoformat(timespec="seconds")
    before = float(earlier.get("wall_time") or 0.0)
    return {
        "campaign": campaign.name,
        "description": campaign.description,
        "campaign_file": case.source.file,
        "state": state,
        "fingerprint": case.fingerprint,
        "parts": case.parts,
        "seed": campaign.seed,
        "sampling": campaign.sampling,
        "announced": asdict(announced),
        "early": announced.early or int(data.done.sum()) != announced.runs,
        "runs": {"wanted": case.runs, "flown": int(data.done.sum()), "failed": int(data.failed.sum())},
        "varied": [
            {
                "name": draw.name,
                "drawn": draw.helper,
                "distribution": written["draw" if draw.helper else "vary"][draw.name],
                "text": draw.text,
                "unit": draw.shown,
                "columns": list(draw.columns),
                "coordinates": [draw.first, draw.count],
            }
            for draw in job.draws.draws
        ],
        "metrics": [
            {
                "name": measure.metric.name,
                "column": measure.metric.name,
                "unit": shown(measure.unit),
                "text": measure.text,
                "signal": measure.metric.signal,
            }
            for measure in job.measures
        ],
        "requirements": [
            {
                "name": one.name,
                "metric": None if one.metric is None else job.measures[one.metric].metric.name,
                "expectation": one.expectation,
                "column": f"met: {one.name}",
                "expected": one.expected,
                "low": one.ends[0],
                "high": one.ends[1],
                "probability": one.probability,
                "confidence": one.confidence,
            }
            for one in job.requirements
        ],
        "expectations": [{"name": name, "column": f"expect: {name}"} for name in job.expectations],
        "verdicts": [asdict(verdict) for verdict in verdicts],
        "notes": case.notes,
        "files": data.files,
        "withdrawn": data.withdrawn,
        "scenario": case.scenario.name,
        "scenario_file": case.scenario.source.file,
        "fmus": {name: {"file": str(fmu.path), "sha256": fmu.sha256} for name, fmu in job.opened.fmus.items()},
        "versions": {"python": platform.python_version(), **{name: version_of(name) for name in _PACKAGES}},
        "platform": {"system": sys.platform, "machine": platform.machine(), "release": platform.release()},
        "started": earlier.get("started") or now,
        "finished": None if state == "running" else now,
        "wall_time": before + (wall if state != "running" else 0.0),
    }


def announced_first(case: Case, earlier: Mapping[str, Any]) -> Announced:
    """Returns what was said of the campaign before its first run: now, or as its folder says at an earlier start."""
    if earlier:
        return Announced(**earlier["announced"])
    return Announced(case.runs, case.campaign.stop == "decided")


def earlier_start(case: Case, folder: Path) -> dict[str, Any]:
    """Returns the manifest that an earlier start of this campaign left, empty where there is none.

    Raises InputError where it is damaged, or the folder holds another campaign.
    """
    if not os.path.lexists(folder / MANIFEST):
        if (folder / RUNS).exists():
            raise InputError(f"{folder / RUNS} stands without {MANIFEST}; remedy: another folder (--out)")
        return {}
    left = read(folder)
    if left["fingerprint"] != case.fingerprint:
        differ = [name for name, value in case.parts.items() if left["parts"].get(name) != value]
        if "sampling" in differ and left["sampling"] == case.campaign.sampling:
            runs = f"the number of runs ({left['runs']['wanted']} there, {case.runs} here)"
            differ[differ.index("sampling")] = f"{runs}, on which the points of {case.campaign.sampling} depend"
        raise InputError(
            f"{folder} holds the campaign {str(left['campaign'])!r}, which differs in "
            f"{', '.join(differ) or 'its parts'}; "
            "remedy: another folder (--out), or remove it"
        )
    return left
