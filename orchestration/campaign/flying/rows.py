"""The runs of a campaign as they stand in its folder: one column at a time, in the order of their index."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.dataset as ds
from numpy.typing import NDArray

from ..sums import parts, read

Floats = NDArray[np.float64]


class Rows:
    """The runs of a campaign, read from its folder when they are asked for."""

    def __init__(self, folder: Path) -> None:
        """Raises InputError where the manifest or a part is damaged, missing or none of the campaign."""
        self.folder = folder
        self.manifest: dict[str, Any] = read(folder)
        files = list(map(str, parts(folder, self.manifest["files"], self.manifest["withdrawn"])))
        self._dataset: Any = ds.dataset(files, format="parquet") if files else None

    def __len__(self) -> int:
        return len(self.index) if self._dataset is not None else 0

    @cached_property
    def _order(self) -> NDArray[np.intp]:
        return np.argsort(self._column("index").to_numpy(), kind="stable")

    @cached_property
    def index(self) -> NDArray[np.int64]:
        """Returns the indices of the runs, ascending."""
        return self._column("index").to_numpy()[self._order]

    @cached_property
    def failed(self) -> NDArray[np.bool_]:
        """Returns whether each run failed."""
        return pc.equal(self._column("status"), "failed").to_numpy(zero_copy_only=False)[self._order]

    def numbers(self, name: str) -> Floats:
        """Returns a column of numbers; nan where a run has none."""
        return self._column(name).to_numpy(zero_copy_only=False).astype(np.float64)[self._order]

    def true(self, name: str) -> NDArray[np.bool_]:
        """Returns a column of booleans; false where a run failed."""
        return pc.fill_null(self._column(name), False).to_numpy(zero_copy_only=False)[self._order]

    def values(self, name: str) -> tuple[Floats, list[str] | None]:
        """Returns a column of what varies: numbers; or of texts their places among the texts in order, and these."""
        column = self._column(name)
        if not pa.types.is_primitive(column.type):  # text
            texts, places = np.unique(column.to_numpy(zero_copy_only=False).astype(str), return_inverse=True)
            return places.astype(np.float64)[self._order], texts.tolist()
        return self.numbers(name), None

    def reasons(self) -> dict[int, str]:
        """Returns why each run failed that did, by its index, ascending."""
        table = self._dataset.to_table(columns=["index", "reason"], filter=ds.field("status") == "failed")
        pairs = zip(table["index"].to_pylist(), table["reason"].to_pylist(), strict=True)
        return {index: reason or "no reason given" for index, reason in sorted(pairs)}

    def _column(self, name: str) -> Any:
        return self._dataset.to_table(columns=[name])[name].combine_chunks()
