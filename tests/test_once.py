"""What the tests make once: a failure to make it is that of one test, and the next one tries again."""

from __future__ import annotations

from pathlib import Path

import pytest

from .once import once


def test_a_folder_whose_making_failed_is_made_anew_by_the_next_that_asks(tmp_path_factory) -> None:
    calls: list[Path] = []

    def make(folder: Path) -> None:
        calls.append(folder)
        (folder / "part").write_text("half")
        if len(calls) == 1:
            raise OSError("the machine is busy")

    with pytest.raises(OSError, match="busy"):
        once(tmp_path_factory, "kept-anew", make)
    assert once(tmp_path_factory, "kept-anew", make) == once(tmp_path_factory, "kept-anew", make)
    assert len(calls) == 2
