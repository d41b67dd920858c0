"""Reads files that an FMU carries under `extra/`, and says the file and the line of what is wrong.

Tests: tests/orchestration/acceptance/test_references.py.
"""

from __future__ import annotations

import hashlib
import math
import posixpath
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from lxml import etree

from ..errors import InputError
from ..fmu.zipped import shown

SIZE_MAX = 64_000_000
"""Bytes of a file."""
_KINDS = {"SHA3-256": "sha3_256", "SHA3-224": "sha3_224", "SHA3-384": "sha3_384", "SHA3-512": "sha3_512"}
_KINDS |= {"SHA-224": "sha224", "SHA-256": "sha256", "SHA-384": "sha384", "SHA-512": "sha512"}


class Missing(ValueError):
    """Raised where what the experiment needs is not there, or cannot be played."""


@dataclass
class Carried:
    """The files of an FMU whose archive is open. All methods raise InputError."""

    path: Path
    archive: zipfile.ZipFile

    def file(self, where: str, entry: Any, source: str) -> str:
        """Returns the name in the archive of a file at a relative URI; its checksum is held against it."""
        uri = urlsplit(source)
        if uri.scheme or uri.netloc or source.startswith("/"):
            raise Missing(f"{source} stands outside the FMU")
        name = posixpath.normpath(posixpath.join(posixpath.dirname(where), unquote(uri.path)))
        if name.startswith("../"):
            raise self.wrong(where, entry, f"{source!r} leads out of the FMU")
        if name not in self.archive.namelist():
            raise Missing(f"the FMU does not hold {name}")
        if (checksum := entry.get("checksum")) is not None:
            kind = entry.get("checksumType", "SHA3-256")
            if kind not in _KINDS:
                raise self.wrong(where, entry, f"checksumType {kind!r}; expected one of {', '.join(_KINDS)}")
            if hashlib.new(_KINDS[kind], self.data(name)).hexdigest() != checksum.lower():
                raise self.wrong(where, entry, f"{name} was changed: its {kind} is not the checksum")
        return name

    def data(self, name: str) -> bytes:
        if self.archive.getinfo(name).file_size > SIZE_MAX:
            raise self.located(name, None, f"expected at most {SIZE_MAX / 1e6:.3g} MB")
        return self.archive.read(name)

    def root(self, name: str) -> Any:
        parser = etree.XMLParser(
            resolve_entities=False, no_network=True, load_dtd=False, remove_comments=True, remove_pis=True
        )
        try:
            root = etree.fromstring(self.data(name), parser, base_url=posixpath.basename(name))
        except (etree.XMLSyntaxError, LookupError, ValueError) as error:
            raise self.located(name, getattr(error, "lineno", None), " ".join(str(error).split())) from None
        if root.getroottree().docinfo.doctype:
            raise self.located(name, None, "it has a DOCTYPE, which it does not need and which can do harm")
        return root

    def required(self, where: str, entry: Any, key: str) -> str:
        value = entry.get(key)
        if value is None:
            raise self.wrong(where, entry, f"{entry.tag} has no attribute {key}")
        return str(value)

    def number(self, where: str, entry: Any, key: str) -> float:
        text = self.required(where, entry, key)
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or value < 0.0:
            raise self.wrong(where, entry, f"{key}: expected a finite number, 0 or more, found {text!r}")
        return value

    def wrong(self, where: str, entry: Any, text: str) -> InputError:
        return self.located(where, entry.sourceline, text)

    def located(self, where: str, line: int | None, text: str) -> InputError:
        at = f":{line}" if line else ""
        return InputError(f"{shown(self.path)}: {where}{at}: {text}")
