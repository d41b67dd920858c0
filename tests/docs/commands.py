"""Finds the commands that a page shows and runs them in one shell, in the order in which a reader types them.

A fence of the language `sh` holds commands; a command may run over several lines by `\\` or by a here-document.
A fence of the language `console` holds commands after `$ ` and what they print; `...` stands for what may differ.
A comment `# exit status 1` says that a command ends so.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    path.relative_to(ROOT).as_posix()
    for pattern in ("*.md", "docs/*.md", "docs/*/*.md", "examples/*/README.md")
    for path in ROOT.glob(pattern)
)
_FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_COMMAND = re.compile(r"^[^\n]*<<'(\w+)'.*?^\1$|^(?:[^\n]*\\\n)*[^\n]+$", re.DOTALL | re.MULTILINE)
_COPIED = ("docs/scenario.schema.json", "examples", "fmus", "scenarios", "Makefile", "pyproject.toml")


@dataclass(frozen=True)
class Command:
    """A command of a page, with the exit status and the output that the page states."""

    text: str
    output: str | None = None

    @property
    def bare(self) -> str:
        """The command without its comment."""
        return self.text.split("  #")[0].strip()

    @property
    def status(self) -> int:
        stated = re.search(r"# exit status (\d+)", self.text)
        return int(stated[1]) if stated else 0


def commands(page: str) -> Iterator[Command]:
    """The commands of a page, in order."""
    for language, body in _FENCE.findall((ROOT / page).read_text("utf-8")):
        if language == "sh":
            yield from (Command(match[0]) for match in _COMMAND.finditer(body))
        elif language == "console":
            for part in re.split(r"^\$ ", body, flags=re.MULTILINE)[1:]:
                text, _, output = part.partition("\n")
                yield Command(text, output)


def workspace(folder: Path) -> dict[str, str]:
    """Copies into `folder` what a clone has and the pages' commands need; returns the environment of a reader's
    shell."""
    ignored = shutil.ignore_patterns("build", "results", "*.fmu", "__pycache__")
    for name in _COPIED:
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, target, ignore=ignored)
        else:
            shutil.copy(ROOT / name, target)
    (folder / ".venv").symlink_to(sys.prefix)
    path = f"{Path(sys.prefix) / 'bin'}{os.pathsep}{os.environ['PATH']}"
    os.utime(folder / "pyproject.toml", (0, 0))  # older than the environment, so make does not install it again
    # Examples and kits are compiled without optimisation, which takes a third of the time. `python -m` runs what is
    # installed, as `orchestrate` does, and not the part of it that is copied.
    return {**os.environ, "PATH": path, "COLUMNS": "200", "NO_COLOR": "1", "CFLAGS": "-O0", "PYTHONSAFEPATH": "1"}


def run(given: list[Command], folder: Path, environment: Mapping[str, str]) -> list[tuple[int, str]]:
    """Exit status and output of each command, all run by one shell in `folder`."""
    said = folder / ".said"
    said.mkdir()
    script = [
        f"{{ {command.text}\n}} >'{said}/{i}' 2>&1 </dev/null; echo $? >'{said}/{i}.status'"
        for i, command in enumerate(given)
    ]
    subprocess.run(["bash", "-c", "\n".join(script)], cwd=folder, env=dict(environment), check=False, timeout=300)
    return [(int((said / f"{i}.status").read_text()), (said / str(i)).read_text("utf-8")) for i in range(len(given))]
