"""The workflow of the public CI, and what it and the pre-commit hooks call."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
import yaml
from fmpy import platform

from fmus.build import blocks_of, ensure
from release import constraints

from . import smoke

ROOT = Path(__file__).parents[1]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


def test_actionlint_has_no_finding_in_the_workflows() -> None:
    beside = os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", "")))
    actionlint = shutil.which("actionlint", path=beside)
    if actionlint is None:
        pytest.skip("there is no actionlint; .ci/run installs it where Go is")
    assert WORKFLOWS
    found = subprocess.run([actionlint, *map(str, WORKFLOWS)], capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr


def test_every_action_is_pinned_by_the_hash_of_its_commit() -> None:
    for workflow in WORKFLOWS:
        steps = [step for job in yaml.safe_load(workflow.read_text("utf-8"))["jobs"].values() for step in job["steps"]]
        used = [step["uses"] for step in steps if "uses" in step]
        assert used
        for action in used:
            assert re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", action), action


def test_the_wheel_is_built_by_what_has_the_hashes_that_are_written_down() -> None:
    (workflow,) = WORKFLOWS
    steps = yaml.safe_load(workflow.read_text("utf-8"))["jobs"]["wheel"]["steps"]
    installs, builds = (step["run"] for step in steps if "run" in step)
    assert "--require-hashes" in installs
    assert (ROOT / installs.split(" -r ")[1]) == constraints.BUILDING
    assert "--no-isolation" in builds  # an isolated build installs what it likes


def test_each_local_hook_calls_a_tool_of_the_environment_that_is_there() -> None:
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text("utf-8"))
    entries = [hook["entry"] for repo in hooks["repos"] if repo["repo"] == "local" for hook in repo["hooks"]]
    assert entries
    for entry in entries:
        assert Path(sys.executable).with_name(Path(entry.split()[0]).name).exists(), entry


@pytest.mark.compile
@pytest.mark.parametrize("block", blocks_of("native"))
def test_fmpy_loads_and_steps_each_fmu_here(block: str) -> None:
    assert smoke.step(ensure(block)) > 0


@pytest.mark.compile
def test_an_fmu_without_a_library_for_this_machine_is_refused_by_the_smoke_test(tmp_path: Path) -> None:
    foreign = tmp_path / "foreign.fmu"
    with zipfile.ZipFile(ensure("allocator")) as old, zipfile.ZipFile(foreign, "w") as new:
        for name in old.namelist():
            new.writestr(name.replace(f"binaries/{platform}/", "binaries/other/"), old.read(name))
    with pytest.raises(RuntimeError, match=f"expected a library for {platform}"):
        smoke.step(foreign)


@pytest.mark.skipif(not (ROOT / ".git").exists() or not shutil.which("git"), reason="no clone")
def test_nothing_is_kept_that_git_is_to_ignore():
    words = ["git", "ls-files", "--cached", "--ignored", "--exclude-standard"]
    assert subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout == ""
