"""The analyses of a campaign once its runs are flown, and the folders of runs whose signals are kept."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow.dataset as ds

from ..errors import InputError, writing
from ..expectations.metrics import MetricError
from ..results.whole import put
from .case import Case
from .flying.batches import Crew
from .metric_function import of_campaign
from .replay import replay
from .statistics import search, sensitivity

ANALYSES = ("sensitivity", "search")


def analyse(
    case: Case, folder: Path, hands: Callable[[], Crew], more: dict[str, Any], remark: Callable[[str], None]
) -> None:
    """Makes the analyses that the campaign asks for, and puts their results into `more`; those of an earlier start
    stay.

    The scenario of the worst case is written to `folder/worst.yaml`.
    """
    done: dict[str, str] = dict(more.get("analyses", {}))
    for name, module in zip(ANALYSES, (sensitivity, search), strict=True):
        section = getattr(case.campaign, name)
        if section is None:
            done.pop(name, None)
            more.pop(name, None)
            continue
        key = hashlib.sha256(f"{case.fingerprint} {section.model_dump_json()}".encode()).hexdigest()
        if done.get(name) != key or name not in more:
            remark(f"{name}: flying its runs")
            more[name] = module.run(section, of_campaign(case, hands()), case.campaign.seed)
            done[name] = key
    more["analyses"] = done
    if text := more.get("search", {}).get("scenario"):
        with writing(folder / "worst.yaml"):
            put(folder / "worst.yaml", text)


def keep(case: Case, folder: Path, remark: Callable[[str], None]) -> list[int]:
    """Flies the runs that are kept again, into `folder/kept/INDEX`, and returns their indices."""
    indices = chosen(case, folder)
    for index in indices:
        place = folder / "kept" / str(index)
        if not (place / "manifest.json").exists():
            try:
                again = replay(case, index, place, folder)
                again.result.save(place)
                if again.differs:
                    remark(f"run {index}, flown again to be kept, differs from its row: {'; '.join(again.differs)}")
            except (InputError, MetricError):
                continue  # its row has the reason
    return indices


def chosen(case: Case, folder: Path) -> list[int]:
    """Returns the indices of the runs that the campaign keeps, of those that have been flown."""
    wanted = case.campaign.keep
    indices: list[int] = []
    if not (wanted.runs or wanted.failed or wanted.not_met) or not (folder / "runs").is_dir():
        return indices
    rows = ds.dataset(folder / "runs", format="parquet")
    if planned := [index for index in wanted.runs if index < case.runs]:
        table = rows.to_table(["index"], filter=ds.field("index").isin(planned))
        indices += table.column("index").to_pylist()
    kinds = [(wanted.failed, ds.field("status") == "failed")]
    for one in case.job.requirements:
        kinds.append((wanted.not_met, ds.field(f"met: {one.name}") == False))  # noqa: E712
    for count, which in kinds:
        if count:
            indices += sorted(rows.to_table(["index"], filter=which).column("index").to_pylist())[:count]
    return sorted(set(indices))
