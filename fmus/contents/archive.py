"""The files of an FMU beside its description and its code, whatever its flavour; and its archive.
Tests: tests/fmus/contents/test_contents.py."""

from __future__ import annotations

import io
import zipfile
from functools import cache
from pathlib import Path

from ..interface import INTERFACES, Interface
from .documentation import index_html
from .icon import png
from .references import references
from .terminals import terminals_and_icons

_DATE = (1980, 1, 1, 0, 0, 0)


def common(interface: Interface, folder: Path, licence: Path | None, host: str, version: int = 2) -> dict[str, bytes]:
    """Documentation, licence, terminals, icon and reference data by their paths in the archive.

    `folder` is that of the block; `host` says what a host must have; `version` is FMI's.
    """
    found = {
        "documentation/index.html": index_html(interface, host, version),
        "terminalsAndIcons/terminalsAndIcons.xml": terminals_and_icons(interface, version),
        **references(interface, folder, version),
    }
    if licence is not None and licence.exists():
        found["documentation/licenses/license.txt"] = licence.read_bytes()
    # model.png is FMI 2.0's place for an icon, terminalsAndIcons/ that of FMI 2.0.4 and later.
    base = interface.name.partition("_")[0]  # `allocator_bounded` without an icon of its own has the allocator's
    for name, target in ((interface.name, "icon"), (base, "icon"), ("block", "icon"), ("terminal", "terminal")):
        svg = _svg(name)
        if svg is None or f"terminalsAndIcons/{target}.svg" in found:
            continue
        found[f"terminalsAndIcons/{target}.svg"] = svg
        found[f"terminalsAndIcons/{target}.png"] = _png(svg)
    if version == 2:
        found["model.png"] = found["terminalsAndIcons/icon.png"]
    found["documentation/icon.svg"] = found["terminalsAndIcons/icon.svg"]
    return found


def _svg(name: str) -> bytes | None:
    path = INTERFACES / f"{name}.svg"
    return path.read_bytes().replace(b"\r\n", b"\n") if path.is_file() else None


@cache
def _png(svg: bytes) -> bytes:
    return png(svg)


def archive(files: dict[str, bytes]) -> bytes:
    """The files as a zip archive whose bytes depend on nothing but their names and contents."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as target:
        for name in sorted(files):
            info = zipfile.ZipInfo(name, _DATE)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.create_system = 3
            info.external_attr = (0o100755 if name.startswith("binaries/") else 0o100644) << 16
            target.writestr(info, files[name])
    return buffer.getvalue()
