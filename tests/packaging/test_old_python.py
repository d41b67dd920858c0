"""A Python that is too old is named in a line: by make, by pip and by the package."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LINE = "attitude-cosim needs Python 3.11 or later; "


def test_make_says_it_and_makes_nothing(tmp_path):
    old = tmp_path / "python"
    old.write_text(
        f"#!/bin/sh\nexec '{sys.executable}' -c 'import sys; sys.version_info = (3, 10, 0); exec(sys.argv[2])' \"$@\"\n"
    )
    old.chmod(0o755)
    command = ["make", "run", f"PYTHON={old}", f"VENV={tmp_path / 'venv'}"]
    told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert told.returncode == 2
    assert told.stderr.splitlines()[0] == f"{LINE}{old} is Python 3.10; remedy: make PYTHON=python3.12"
    assert not (tmp_path / "venv").exists()


def test_the_package_says_it_before_it_imports_anything_of_its_own(monkeypatch):
    text = (ROOT / "orchestration" / "__init__.py").read_text("utf-8")
    monkeypatch.setattr(sys, "version_info", (3, 10, 0))
    with pytest.raises(SystemExit, match=f"{LINE}this is Python 3.10"):
        exec(compile(text, "orchestration", "exec"), {"__name__": "orchestration", "__package__": "nothing"})


@pytest.mark.parametrize("name", ["hatch_build.py", "orchestration/__init__.py"])
def test_what_an_old_python_reads_first_is_written_for_it(name):
    """pip asks the build backend for the version of Python that is needed, so that has to run on an older one."""
    tree = ast.parse((ROOT / name).read_text("utf-8"), feature_version=(3, 8))
    imported = {alias.name for node in tree.body if isinstance(node, ast.Import) for alias in node.names}
    assert "tomllib" not in imported
