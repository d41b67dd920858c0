"""Mutation testing by mutmut: `python -m tests.mutants [MODULE ...]` changes a module's code and counts what its tests
see.

Works in a copy of the tree. Prints the score of each module and the changes that no test saw; exit status 1 where there
are any. Not changed: what stands outside functions.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import click

ROOT = Path(__file__).parents[1]
TESTS: dict[str, tuple[str, ...]] = {
    "allocator/allocation.py": ("tests/allocator/test_allocation.py", "tests/allocator/test_block.py"),
    "allocator/vector.py": ("tests/allocator/test_allocation.py",),
    "allocator/hold.py": ("tests/allocator/test_block.py",),
    "allocator/bounded/allocation.py": ("tests/allocator/bounded",),
    "allocator/bounded/box.py": ("tests/allocator/bounded",),
    "controller/law.py": ("tests/controller/test_law.py", "tests/controller/test_block.py"),
    "controller/gains.py": ("tests/controller/test_gains.py",),
    "controller/errors.py": ("tests/controller/test_law.py", "tests/controller/test_reference.py"),
    "controller/reference.py": ("tests/controller/test_reference.py", "tests/controller/test_block.py"),
    "controller/morse.py": ("tests/controller/test_law.py", "tests/controller/test_block.py"),
    "controller/so3.py": ("tests/controller/test_so3.py",),
    "orchestration/expectations/checks.py": ("tests/orchestration/expectations",),
    "orchestration/expectations/span.py": ("tests/orchestration/expectations",),
    "orchestration/expectations/outcomes.py": ("tests/orchestration/expectations",),
    "orchestration/expectations/holds.py": ("tests/orchestration/expectations",),
    "orchestration/swap/conversion.py": tuple(
        f"tests/orchestration/swap/test_{name}.py" for name in ("conversion", "rotation", "mapping", "fit")
    ),
    "orchestration/quantities.py": ("tests/orchestration/test_quantities.py",),
    "fmus/units.py": ("tests/fmus/test_units.py", "tests/orchestration/test_quantities.py"),
}
"""The tests that a module is held against: quick ones, which compile nothing."""

_SETTINGS = """
[tool.mutmut]
source_paths = {packages}
only_mutate = ["{module}"]
pytest_add_cli_args = ["-p", "no:randomly", "-p", "no:xdist", "-p", "no:cacheprovider", "--import-mode=importlib"]
pytest_add_cli_args_test_selection = {tests}
also_copy = {others}
"""
_PACKAGES = ("allocator", "controller", "fmus", "orchestration", "plant", "supervisor")


@click.command()
@click.argument("modules", nargs=-1, type=click.Choice(list(TESTS)), metavar="[MODULE]...")
@click.option("--processes", default=2, show_default=True)
def main(modules: tuple[str, ...], processes: int) -> None:
    """Count what the tests see of changes to MODULE, a path such as controller/law.py; of all by default."""
    unseen = 0
    for module in modules or TESTS:
        with tempfile.TemporaryDirectory() as folder:
            unseen += _mutate(module, Path(folder), processes)
    sys.exit(1 if unseen else 0)


def _mutate(module: str, folder: Path, processes: int) -> int:
    """Prints the score of a module; returns the number of changes that no test saw."""
    copy(folder)
    others = sorted({path.name for path in folder.iterdir()} - set(_PACKAGES) - {"pyproject.toml"})
    settings = _SETTINGS.format(packages=list(_PACKAGES), module=module, tests=list(TESTS[module]), others=others)
    with (folder / "pyproject.toml").open("a", encoding="utf-8") as file:
        file.write(settings)
    run = _mutmut(folder, "run", "--max-children", str(processes))
    ends = dict(re.findall(r"^\s*(\S+__mutmut_\d+): (.+)$", _mutmut(folder, "results", "--all", "true"), re.MULTILINE))
    if not ends:
        raise click.ClickException(f"{module}: mutmut made no changes:\n{run[-3000:]}")
    lost = {name: end for name, end in ends.items() if end not in ("killed", "timeout")}
    print(f"{module}: {len(ends) - len(lost)} of {len(ends)} changes seen", flush=True)
    for name, end in lost.items():
        diff = _mutmut(folder, "show", name).splitlines()
        changed = [line for line in diff if line[:1] in "+-" and not line.startswith(("+++", "---"))]
        print("\n".join([f"  {end}: {name}", *(f"    {line}" for line in changed)]), flush=True)
    return len(lost)


def copy(folder: Path) -> None:
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, folder / name)


def _mutmut(folder: Path, *arguments: str) -> str:
    command = [sys.executable, "-m", "mutmut", *arguments]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return run.stdout + run.stderr


if __name__ == "__main__":
    main(prog_name="python -m tests.mutants")
