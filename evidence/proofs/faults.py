"""Faults that are planted in the C, one at a time: the list of tests/evidence/proofs/planted.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import yaml

from orchestration import InputError

from ..paper import ROOT

FILE = ROOT / "tests" / "evidence" / "proofs" / "planted.yaml"


@dataclass(frozen=True)
class Fault:
    """A change of a file that makes an error: which proof has to find it, and as what kind of alarm."""

    subject: str
    about: str
    file: str
    old: str
    new: str
    kind: str

    def plant(self, root: Path) -> None:
        """Changes the file in `root`. Raises InputError where it has the old text not once."""
        path = root / self.file
        text = path.read_text("utf-8")
        if text.count(self.old) != 1:
            raise InputError(
                f"{FILE.name}: {self.about}: {self.file} has {self.old!r} {text.count(self.old)} times, expected once"
            )
        path.write_text(text.replace(self.old, self.new), "utf-8")


def faults() -> list[Fault]:
    """Those of the file, in its order."""
    return [Fault(**entry) for entry in yaml.safe_load(FILE.read_text("utf-8"))]
