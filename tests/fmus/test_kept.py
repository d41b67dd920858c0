"""What is kept on disk between processes."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus import places
from fmus.kept import kept, seen


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(places, "work", lambda: tmp_path)
    return tmp_path / "kept"


def never() -> str:
    raise AssertionError("it was kept")


def test_the_same_is_made_once_and_what_is_made_of_something_else_anew() -> None:
    assert kept(str, ("a", 1), lambda: "first") == "first"
    assert kept(str, ("a", 1), never) == "first"
    assert kept(str, ("a", 2), lambda: "second") == "second"


@pytest.mark.parametrize("spoilt", [b"", b"no pickle", b"\x80\x04K\x01."])
def test_a_damaged_file_or_one_of_another_type_is_made_anew(folder: Path, spoilt: bytes) -> None:
    kept(str, "a", lambda: "first")
    (file,) = folder.iterdir()
    file.write_bytes(spoilt)
    assert kept(str, "a", lambda: "again") == "again"
    assert kept(str, "a", never) == "again"


def test_a_folder_that_cannot_be_written_keeps_nothing(folder: Path) -> None:
    folder.write_text("a file in its place")
    assert kept(str, "a", lambda: "first") == "first"
    assert kept(str, "a", lambda: "again") == "again"


def test_a_failure_is_not_kept(folder: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        kept(float, "a", lambda: 1 / 0)
    assert kept(float, "a", lambda: 1.0) == 1.0


def test_the_latest_files_stay(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fmus.kept._FILES_MAX", 3)
    for number in range(5):
        kept(int, number, lambda number=number: number)
    assert len(list(folder.iterdir())) == 3


def test_a_changed_file_is_seen(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "b.txt").write_text("1")
    before = list(seen(tmp_path))
    (tmp_path / "a" / "b.txt").write_text("22")
    assert list(seen(tmp_path)) != before
