"""A C compiler that keeps its objects: of many files in which one has changed it compiles that one, by the system's
compiler. `python tests/objects.py FOLDER COMPILER OPTION...`; an object in FOLDER is found by what it is made of.

`python -m tests.areas` uses it, where a library is linked anew for each change.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from hashlib import sha256
from pathlib import Path


def main(folder: Path, compiler: str, options: Sequence[str]) -> int:
    """Runs the compiler, of which an object takes the place of each C file; returns its exit status."""
    sources = [each for each in options if each.endswith(".c")]
    if "-c" in options or not sources:
        return subprocess.call([compiler, *options])
    at = options.index("-o")
    others = [each for i, each in enumerate(options) if each not in sources and i not in (at, at + 1)]
    flags = [each for each in others if each not in ("-shared", "-s") and not each.startswith(("-l", "-Wl"))]
    headers = _headers(Path(each[2:]) for each in flags if each.startswith("-I"))
    same = "\0".join(each for each in flags if not each.startswith("-I")).encode() + headers
    objects = []
    for source in map(Path, sources):
        made_of = same + _headers([source.parent]) + source.read_bytes()
        made = folder / f"{source.stem}-{sha256(made_of).hexdigest()[:24]}.o"
        if not made.exists():
            descriptor, name = tempfile.mkstemp(".o", dir=folder)
            os.close(descriptor)
            if status := subprocess.call([compiler, *flags, "-c", str(source), "-o", name]):
                return status
            os.replace(name, made)
        objects.append(str(made))
    return subprocess.call([compiler, *others, *objects, "-o", options[at + 1], "-lm"])


def _headers(folders: Iterable[Path]) -> bytes:
    """Returns names and contents of all headers in some folders, as a digest."""
    digest = sha256()
    for path in (path for folder in folders for path in sorted(folder.rglob("*.h"))):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.digest()


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2], sys.argv[3:]))
