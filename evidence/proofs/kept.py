"""Results of analyses, kept in out/proofs while neither the C nor the way it is analysed changes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

from fmus.native import generated_sources

from ..paper import ROOT
from .analysis import FLAGS, Alarm, Result
from .contracts import BY_WP
from .harness import harness
from .subjects import HERE, Subject, reached

FOLDER = ROOT / "out" / "proofs"


def result_of(subject: Subject) -> Result:
    """Returns the result of an analysis with these sources, now or before. Raises InputError."""
    folder = FOLDER / subject.title.replace(", ", "-")
    path, digest = folder / "result.json", _digest(subject)
    if path.exists():
        kept = json.loads(path.read_text("utf-8"))
        if kept.pop("digest") == digest:
            alarms = tuple(Alarm(**a) for a in kept.pop("alarms"))
            kept |= {name: tuple(kept[name]) for name in ("statements", "functions")}
            kept["rounds"] = tuple((loop, holds) for loop, holds in kept["rounds"])
            return Result(alarms, **kept)
    result = subject.prove(folder)
    path.write_text(json.dumps({"digest": digest, **asdict(result)}, indent=1), "utf-8")
    return result


def _digest(subject: Subject) -> str:
    how = f"{subject.span} {subject.definitions()} {subject.words()} {FLAGS} {sorted(BY_WP)}"
    digest = hashlib.sha256(f"{how} {reached().get(subject.title)}".encode())
    if (block := subject.block) is not None:
        digest.update(str(sorted(generated_sources(block.interface, block.folder).items())).encode())
        if subject.span:
            digest.update(harness(block.interface, subject.span).encode())
    own = ("prelude.h", "loops.yaml", "rounds.py", "analysis.py", "subjects.py")
    program = () if subject.span else (f"{subject.name}.c",)
    for path in [*_sources(subject), *(HERE / name for name in (*own, *program))]:
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _sources(subject: Subject) -> Iterable[Path]:
    folders = [*subject.folders(), ROOT / "fmus" / "native" / "common", ROOT / "fmus" / "native" / "freestanding"]
    return sorted(path for folder in folders for path in folder.rglob("*") if path.suffix in (".c", ".h"))
