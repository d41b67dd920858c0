"""`campaign.json`: what a campaign was made of, and what came of it."""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fmus.versions import version_of

from ..errors import InputError, ResultsError, reason
from ..results.data import json_text
from ..results.place import put
from .case import Case
from .statistics.verdicts import Verdict

if TYPE_CHECKING:
    from .flying.dataset import Dataset

MANIFEST = "campaign.json"
_PACKAGES = ("attitude-cosim", "fmpy", "numpy", "scipy", "pyarrow", "distributed")


def manifest(
    case: Case, state: str, data: Dataset, verdicts: Sequence[Verdict], wall: float, earlier: Mapping[str, Any]
) -> dict[str, Any]:
    """The manifest, ready for JSON. `earlier` is that of an earlier start, whose begin and wall time count, too."""
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
        "early": campaign.stop == "decided",
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
                "unit": "" if str(measure.unit) == "1" else str(measure.unit),
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
        "scenario": case.scenario.name,
        "scenario_file": case.scenario.source.file,
        "fmus": {name: {"file": str(fmu.path), "sha256": fmu.sha256} for name, fmu in job.opened.fmus.items()},
        "versions": {"python": platform.python_version(), **{name: version_of(name) for name in _PACKAGES}},
        "platform": {"system": sys.platform, "machine": platform.machine(), "release": platform.release()},
        "started": earlier.get("started") or now,
        "finished": None if state == "running" else now,
        "wall_time": before + (wall if state != "running" else 0.0),
    }


def write(path: Path, record: Mapping[str, Any]) -> None:
    """Writes the manifest, whole or not at all. Raises ResultsError."""
    try:
        put(path, json_text(record) + "\n")
    except OSError as error:
        raise ResultsError(f"the campaign's manifest cannot be written: {path}: {reason(error)}") from None


def _is_sound(earlier: Mapping[str, Any]) -> bool:
    """Whether what is taken over from a manifest has its types."""
    runs = earlier.get("runs", {})
    counts = list(runs.values()) if isinstance(runs, dict) else [None]
    texts = all(isinstance(earlier.get(key, ""), str) for key in ("started", "state"))
    return texts and all(type(n) is int for n in counts) and type(earlier.get("wall_time", 0.0)) in (int, float)


def earlier_start(case: Case, folder: Path) -> dict[str, Any]:
    """The manifest that an earlier start of this campaign left, empty where there is none.

    Raises InputError where the folder holds another campaign.
    """
    path = folder / MANIFEST
    if not path.exists():
        if (folder / "runs").exists():
            raise InputError(f"{folder / 'runs'} stands without {MANIFEST}; remedy: another folder (--out)")
        return {}
    left: dict[str, Any] = {}
    with suppress(OSError, ValueError):
        left = json.loads(path.read_text("utf-8"))
    parts = left.get("parts") if isinstance(left, dict) else None
    if not isinstance(parts, dict) or not _is_sound(left):
        raise InputError(f"{path} is no manifest of a campaign; remedy: another folder (--out)")
    if left.get("fingerprint") != case.fingerprint:
        differ = [name for name, value in case.parts.items() if parts.get(name) != value]
        if "sampling" in differ and left.get("sampling") == case.campaign.sampling:
            wanted = left.get("runs", {}).get("wanted")
            runs = f"the number of runs ({wanted} there, {case.runs} here), on which the points of {case.campaign.sampling} depend"
            differ[differ.index("sampling")] = runs
        raise InputError(
            f"{folder} holds the campaign {str(left.get('campaign'))!r}, which differs in {', '.join(differ) or 'its parts'}; "
            "remedy: another folder (--out), or remove it"
        )
    return left
