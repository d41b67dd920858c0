"""Paths as users write them."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.commands import orchestrate


def test_a_working_folder_that_was_deleted_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    monkeypatch.chdir(folder)
    shutil.rmtree(folder)
    ended = orchestrate("validate", "a.yaml")
    assert ended.exit_code == 2
    assert ended.stderr == "the working folder has been deleted; remedy: cd to one that is there\n"
