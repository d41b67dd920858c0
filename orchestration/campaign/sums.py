"""SHA-256 of a campaign's files: `campaign.json` ends with its own, and holds those of the parts of the dataset
`runs/`.

So a flipped bit, a part that was copied or put there, and a part of another campaign are refused by their names. A part
is listed before it takes its name: one that is listed and not there was never written, and its runs are flown again.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, Field, ValidationError

from ..errors import InputError, ResultsError, reason
from ..results import whole
from ..results.data import json_text

MANIFEST = "campaign.json"
RUNS = "runs"
_UNKNOWN = "0" * 64
_SEAL = re.compile(rb'"sha256": "([0-9a-f]{64})"(?=\s*\}\s*\Z)')
"""The last entry of the manifest, whose value is the SHA-256 of the file with zeros in its place."""
_AWAY = "remedy: another folder (--out)"
_Count = Annotated[int, Field(ge=0, le=10**12)]


class _Announced(BaseModel, strict=True):
    runs: _Count
    early: bool


class _Runs(BaseModel, strict=True):
    wanted: _Count
    flown: _Count
    failed: _Count


class _Form(BaseModel, strict=True):
    """Part of an earlier start's manifest that the next one reads."""

    campaign: str
    sampling: str
    fingerprint: str
    parts: dict[str, str]
    announced: _Announced
    runs: _Runs
    files: dict[str, str]
    withdrawn: list[str]
    fresh: bool = False
    unchecked: list[list[_Count]] = []
    wall_time: Annotated[float, Field(ge=0, allow_inf_nan=False)]


def digest(path: Path) -> str:
    """Returns the SHA-256 of a file. Raises OSError."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write(folder: Path, record: Mapping[str, Any]) -> None:
    """Writes the manifest with its SHA-256, whole or not at all. Raises ResultsError."""
    text = json_text({**record, "sha256": _UNKNOWN}) + "\n"
    value = hashlib.sha256(text.encode("utf-8", "backslashreplace")).hexdigest()
    start, _, end = text.rpartition(_UNKNOWN)
    try:
        whole.put(folder / MANIFEST, f"{start}{value}{end}")
    except OSError as error:
        raise ResultsError(f"the campaign's manifest cannot be written: {folder / MANIFEST}: {reason(error)}") from None


def read(folder: Path) -> dict[str, Any]:
    """Returns the manifest of a campaign's folder. Raises InputError where there is none, or where it was changed."""
    path = folder / MANIFEST
    if not path.is_file():
        raise InputError(f"{path} is no file; expected the manifest of a campaign; {_AWAY}")
    try:
        content = whole.content(path)
    except (OSError, ValueError) as error:
        why = reason(error) if isinstance(error, OSError) else error
        raise InputError(f"{path} cannot be read: {why}") from None
    seal = _SEAL.search(content)
    if seal is None:
        raise InputError(f"{path} is no manifest of a campaign, or one without SHA-256 of an earlier version; {_AWAY}")
    plain = content[: seal.start(1)] + _UNKNOWN.encode() + content[seal.end(1) :]
    if hashlib.sha256(plain).hexdigest() != seal[1].decode():
        raise InputError(f"{path} is damaged: it does not have the SHA-256 that it names; {_AWAY}")
    try:
        record: dict[str, Any] = json.loads(content)
        _Form.model_validate(record)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise InputError(f"{path} is no manifest of a campaign: {where}: {first['msg']}; {_AWAY}") from None
    except (ValueError, RecursionError):
        raise InputError(f"{path} is no manifest of a campaign: it is no JSON; {_AWAY}") from None
    return record


def parts(folder: Path, files: Mapping[str, str], withdrawn: Sequence[str] = (), whole: bool = True) -> list[Path]:
    """Returns the parts of the dataset in a campaign's folder; `files` are those of its manifest with their SHA-256.

    Those that are `withdrawn`, whose rows were written again, are left out.

    Raises InputError, which names the file, where one is damaged or no part of this campaign, or where one is missing
    of what should be `whole`.
    """
    there = sorted((folder / RUNS).glob("[!.]*.parquet")) if (folder / RUNS).is_dir() else []
    there = [path for path in there if path.name not in withdrawn]
    for path in there:
        if path.name not in files:
            raise InputError(f"{path} is no part of this campaign: {MANIFEST} does not list it; remedy: remove it")
        if not path.is_file():
            raise InputError(f"{path} is no regular file; remedy: remove it, and its runs are flown again")
        try:
            value = digest(path)
        except OSError as error:
            raise InputError(f"{path} cannot be read: {reason(error)}") from None
        if value != files[path.name]:
            remedy = "remedy: remove it, and its runs are flown again"
            raise InputError(f"{path} is damaged: its SHA-256 is not the one in {MANIFEST}; {remedy}")
    if whole and (lacking := sorted(set(files) - {path.name for path in there})):
        raise InputError(f"{folder / RUNS / lacking[0]} is missing; remedy: the same command flies its runs again")
    return there


def check(folder: Path) -> None:
    """Checks the manifest and the parts of a campaign's folder.

    Raises InputError, which names the file that was changed.
    """
    record = read(folder)
    parts(folder, record["files"], record["withdrawn"])
