"""Writes docs/use/tools.md: python -m tests.tools"""

from __future__ import annotations

import tempfile
from pathlib import Path

from . import measure, page

with tempfile.TemporaryDirectory() as folder:
    measure.prepare(Path(folder))
    page.TARGET.write_text(page.text(Path(folder)), "utf-8")
print(page.TARGET)
