"""What is made of a campaign once its runs are flown: the folders of runs whose signals are kept, and the report page."""

from __future__ import annotations

import json
from pathlib import Path

import pyarrow.dataset as ds

from ..errors import InputError
from ..expectations.metrics import MetricError
from .engine import Finished
from .load import Case
from .record import MANIFEST, write
from .replay import replay


def keep(case: Case, folder: Path, finished: Finished) -> Path | None:
    """Flies the runs that are kept again, into `folder/kept/INDEX`, and writes the report page; None where none is written."""
    if not finished.interrupted and (indices := chosen(case, folder)):
        for index in indices:
            place = folder / "kept" / str(index)
            if not (place / "manifest.json").exists():
                try:
                    replay(case, index, place).result.save(place)
                except (InputError, MetricError):
                    continue  # its row has the reason
        path = folder / MANIFEST
        write(path, {**json.loads(path.read_text("utf-8")), "kept": indices})
    return None


def chosen(case: Case, folder: Path) -> list[int]:
    """The indices of the runs that the campaign keeps, of those that have been flown."""
    wanted = case.campaign.keep
    found: list[int] = []
    if not (wanted.runs or wanted.failed or wanted.not_met) or not (folder / "runs").is_dir():
        return found
    rows = ds.dataset(folder / "runs", format="parquet")
    if wanted.runs:
        table = rows.to_table(["index"], filter=ds.field("index").isin(wanted.runs))
        found += table.column("index").to_pylist()
    kinds = [(wanted.failed, ds.field("status") == "failed")]
    for claim in case.job.claims:
        kinds.append((wanted.not_met, ds.field(f"met: {claim.name}") == False))  # noqa: E712
    for count, which in kinds:
        if count:
            found += sorted(rows.to_table(["index"], filter=which).column("index").to_pylist())[:count]
    return sorted(set(found))
