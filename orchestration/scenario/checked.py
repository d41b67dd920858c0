"""Models that a process need not check, since an earlier one has checked the same data.

Pydantic takes 15 to 30 ms to build what checks the models, and a process that runs one scenario needs it once.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

from pydantic import BaseModel

from fmus.kept import code, kept
from fmus.versions import version_of

T = TypeVar("T", bound=BaseModel)


def checked_before(model: type[T], data: Any, check: Callable[[], T]) -> T:
    """What `check` makes of these data, from disk where an earlier process made it; what it refuses is not kept.

    Once the models are built in this process, or where the data are not those of a file, they are checked.
    """
    if model.__pydantic_complete__ or not _plain(data):
        return check()
    key = model, repr(data)
    if key in _again:
        return cast(T, pickle.loads(_again[key]))
    checked = kept(model, (data, code(Path(__file__).parents[1]), version_of("pydantic")), check, "checked")
    while len(_again) >= _AGAIN_MAX:
        del _again[next(iter(_again))]
    _again[key] = pickle.dumps(checked, pickle.HIGHEST_PROTOCOL)
    return checked


_again: dict[tuple[type[BaseModel], str], bytes] = {}
"""For later runs in this process, to which no model is common."""
_AGAIN_MAX = 20


def _plain(data: Any) -> bool:
    """Whether its repr shows all of it."""
    if isinstance(data, dict):
        return all(type(key) is str and _plain(value) for key, value in data.items())
    return all(map(_plain, data)) if type(data) is list else data is None or type(data) in (str, int, float, bool)


def dumped(value: Any) -> Any:
    """What `model_dump(exclude_none=True)` gives, for which Pydantic would build the models."""
    if isinstance(value, BaseModel):
        value = dict(value)
    if isinstance(value, dict):
        return {name: dumped(entry) for name, entry in value.items() if entry is not None}
    return [dumped(entry) for entry in value] if isinstance(value, list) else value
