"""The link of a block whose C has another block's names: a set of wheels."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

from fmus import link
from fmus.block import Block
from fmus.kit.linked import lay_out


def test_a_set_is_linked_and_laid_out_for_a_device_by_the_names_of_its_c(tmp_path: Path) -> None:
    block = Block.named("allocator_bounded_wheels")
    with zipfile.ZipFile(io.BytesIO(link.package(block.interface, "host"))) as archive:
        assert any(name.startswith("binaries/") for name in archive.namelist())
    lay_out(block.interface, block.folder, tmp_path)
    text = (tmp_path / "block.h").read_text()
    assert '#include "allocator_bounded.h"' in text
    assert "typedef AllocatorBoundedState State;" in text
