"""A zip archive from elsewhere, an FMU or an SSP archive: opened and unpacked within bounds only.

Bounded are the file, the number of its entries and what they unpack to. zipfile reads of an entry no more than the
size that its directory declares, so the declared sizes bound what is unpacked.
"""

from __future__ import annotations

import errno
import lzma
import stat
import struct
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import InputError, NoRoom, Problem, reason

ARCHIVE_MAX, UNPACKED_MAX = 10**9, 2 * 10**9
"""Bytes of the file, and of what it unpacks to."""
ENTRIES_MAX, _DIRECTORY_MAX = 20_000, 16 * 10**6
"""Entries, and bytes of the directory that lists them."""
_DAMAGED = (
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error, EOFError),
    *(NotImplementedError, RuntimeError, ValueError, OverflowError),
)
"""What zipfile raises for a damaged archive, or one that it cannot read."""


def shown(path: Path) -> Path:
    """The path as the user knows it: relative to the current folder where it lies in it."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


@contextmanager
def reading(path: Path, what: str) -> Iterator[zipfile.ZipFile]:
    """The archive, its directory checked; `what` is "FMU" or "SSP archive".

    Raises InputError, also for damage that shows while it is read.
    """
    try:
        _check_file(path, what)
        with zipfile.ZipFile(path) as archive:
            _check_entries(path, archive.infolist())
            yield archive
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{shown(path)} cannot be read: {reason(error)}") from None
    except _DAMAGED as error:
        raise InputError(Problem(f"{shown(path)} is a damaged zip archive: {error}", kind="damaged")) from None


def names(path: Path, what: str) -> set[str]:
    """The names of its entries. Raises InputError."""
    with reading(path, what) as archive:
        return set(archive.namelist())


def unpack(path: Path, folder: Path, what: str, names: Iterable[str] | None = None) -> None:
    """Unpacks it, or these of its entries, into an empty folder. Raises InputError."""
    with reading(path, what) as archive:
        try:
            archive.extractall(folder, names)
        except OSError as error:
            if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES):
                raise NoRoom(f"{shown(path)} cannot be unpacked", folder, error) from None
            # Also what bz2 raises for damaged data, which has no number.
            raise InputError(f"{shown(path)} cannot be unpacked: {reason(error)}") from None


def _check_file(path: Path, what: str) -> None:
    """Refuses what is no file, too large or no zip archive, before zipfile reads its directory into memory."""
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise InputError(f"{shown(path)} is a folder; expected a file")
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"{shown(path)} is a device, a pipe or a socket; expected a regular file")
    if status.st_size > ARCHIVE_MAX:
        raise InputError(f"{shown(path)} holds {size_text(status.st_size)}; expected at most {size_text(ARCHIVE_MAX)}")
    with path.open("rb") as file:
        begins = file.read(2)
        file.seek(max(0, status.st_size - 2**16 - 200))
        directory = _directory_size(file.read())
    if directory is None:
        if begins == b"PK":
            raise InputError(Problem(f"{shown(path)} is a damaged or truncated zip archive", kind="damaged"))
        raise InputError(f"{shown(path)} is no {what}: {_a(what)} is a zip archive")
    if directory > _DIRECTORY_MAX:
        raise InputError(
            f"{shown(path)} lists its entries in {size_text(directory)}; expected at most {size_text(_DIRECTORY_MAX)}"
        )


def _directory_size(end: bytes) -> int | None:
    """Bytes of a zip archive's directory, from its end record or that of zip64; None where there is no such record."""
    at = end.rfind(b"PK\x05\x06")
    if at < 0 or len(end) < at + 22:
        return None
    (size,) = struct.unpack_from("<I", end, at + 12)
    large = at - 20 - 56  # the record of zip64 and its locator stand before, where there are any
    if large >= 0 and end[at - 20 : at - 16] == b"PK\x06\x07" and end[large : large + 4] == b"PK\x06\x06":
        (size,) = struct.unpack_from("<Q", end, large + 40)
    return int(size)


def _check_entries(path: Path, entries: list[zipfile.ZipInfo]) -> None:
    if len(entries) > ENTRIES_MAX:
        raise InputError(f"{shown(path)} holds {len(entries)} entries; expected at most {ENTRIES_MAX}")
    size = sum(entry.file_size for entry in entries)
    if size > UNPACKED_MAX:
        raise InputError(f"{shown(path)} would unpack to {size_text(size)}; expected at most {size_text(UNPACKED_MAX)}")
    for entry in entries:
        if not (name := entry.filename):
            raise InputError(Problem(f"{shown(path)} holds an entry without a name", kind="damaged"))
        if name.startswith("/") or "\\" in name or ":" in name or ".." in name.split("/"):
            raise InputError(f"{shown(path)} would unpack to a place outside its folder: {name}")
        if stat.S_ISLNK(entry.external_attr >> 16):
            raise InputError(f"{shown(path)} holds a symbolic link, {name}; expected files only")
        if entry.flag_bits & 1:
            raise InputError(f"{shown(path)} is encrypted: {name}; expected an archive that opens without a password")
    (name, count), *_ = Counter(entry.filename for entry in entries if not entry.is_dir()).most_common(1) or [("", 0)]
    if count > 1:
        raise InputError(f"{shown(path)} holds {name} {count} times; expected each name once")


def xml_root(data: bytes, name: str) -> Any:
    """Returns the root of an XML document from an archive. Raises InputError.

    Refused is a DOCTYPE: its entities can grow without bound and can read files, and neither FMI nor SSP has a use for
    it.
    """
    from lxml import etree  # here, since it takes 12 ms and what is kept needs none of it  # noqa: PLC0415

    safe = {"resolve_entities": False, "no_network": True, "load_dtd": False}
    parser = etree.XMLParser(remove_comments=True, remove_pis=True, **safe)
    wrong = ""
    try:
        root = etree.fromstring(data, parser, base_url=name)
        doctype = bool(root.getroottree().docinfo.doctype)
    except (etree.XMLSyntaxError, LookupError, ValueError) as error:
        wrong = f"{name} cannot be read: {line(error)}"
        doctype = b"<!DOCTYPE" in data.replace(b"\0", b"")  # in any encoding: its entities may be what cannot be read
    if doctype:
        raise InputError(f"{name} has a DOCTYPE, which it does not need and which can do harm")
    if wrong:
        raise InputError(wrong)
    return root


def line(error: Exception) -> str:
    """Returns the text of an error in one line."""
    return " ".join(str(error).split()) or type(error).__name__


def _a(what: str) -> str:
    return f"{'an' if what[0] in 'FS' else 'a'} {what}"


def size_text(size: int) -> str:
    """So many bytes, for a message."""
    return f"{size / 1e9:.3g} GB" if size >= 1e9 else f"{size / 1e6:.3g} MB"
