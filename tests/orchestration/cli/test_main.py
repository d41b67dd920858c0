"""The names of commands: those of `orchestrate`, and those that other packages add."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from hatch_build import entry_point
from tests.commands import orchestrate

pytestmark = pytest.mark.isolate

ROOT = Path(__file__).parents[3]
MODULE = """
import click
@click.command("size")
@click.argument("what")
def command(what):
    '''Size something.'''
    click.echo(f"sized {what}")
"""


@pytest.fixture
def installed(tmp_path):
    """A folder with a package that adds the command `size`, and one that asks for the name of ours."""
    (tmp_path / "sizes.py").write_text(MODULE)
    described = tmp_path / "sizes-1.0.dist-info"
    described.mkdir()
    (described / "METADATA").write_text("Metadata-Version: 2.1\nName: sizes\nVersion: 1.0\n")
    (described / "entry_points.txt").write_text(
        "[orchestrate.commands]\nsize = sizes:command\nview = sizes:command\nlost = not_there:command\n"
    )
    return tmp_path


def run(installed, *arguments):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join((str(ROOT), str(installed)))}
    command = [sys.executable, "-m", "orchestration", *arguments]
    done = subprocess.run(command, cwd=installed, env=environment, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def test_an_installed_package_adds_a_command_and_replaces_none_of_ours(installed):
    (installed / "size").mkdir()  # a folder of that name is no scenario
    assert run(installed, "size", "a wheel") == (0, "sized a wheel\n", "")
    assert "Open the page of a run" in run(installed, "view", "-h")[1]
    assert run(installed, "sizee") == (2, "", "sizee: there is no such command or scenario; did you mean 'size'?\n")


def test_a_command_whose_package_cannot_be_imported_is_told_without_a_traceback(installed):
    told = "lost needs the package 'not_there'; remedy: pip install 'sizes'\n"
    assert run(installed, "lost") == (2, "", told)


def test_a_run_does_not_look_for_commands_of_other_packages(loop, monkeypatch):
    monkeypatch.setattr("orchestration.cli.main.outside", lambda: pytest.fail("looked for"))
    assert orchestrate(loop.name, "--quiet").exit_code == 0


def test_a_command_whose_packages_are_not_installed_is_listed_and_says_which_extra_brings_them(tmp_path, monkeypatch):
    (tmp_path / "lacks_a_package.py").write_text("import no_such_package\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    point = EntryPoint("calibrate", "lacks_a_package:command [inflight]", "orchestrate.commands")
    monkeypatch.setattr("orchestration.cli.main.outside", lambda: {"calibrate": point})
    assert "Not installed: pip install 'attitude-cosim[inflight]'" in orchestrate("-h").stdout
    answer = orchestrate("calibrate", "gyro", "log.yaml", "--out", "x", "-h")
    assert answer.exit_code == 2
    assert (
        "calibrate needs the package 'no_such_package'; remedy: pip install 'attitude-cosim[inflight]'" in answer.stderr
    )


def test_a_plain_installation_lists_all_commands_and_says_what_campaigns_need(tmp_path):
    (tmp_path / "sitecustomize.py").write_text("import sys\nsys.modules['scipy'] = None  # as if it were not there\n")
    (tmp_path / "c.yaml").write_text("scenario: s.yaml\n")
    status, listed, told = run(tmp_path, "-h")
    assert (status, told) == (0, "")
    assert re.search(r"campaign +Not installed: pip install 'attitude-cosim\[campaign\]'", listed)
    status, _, told = run(tmp_path, "campaign", "c.yaml", "--runs", "3")
    assert status == 2
    assert "campaign needs the package 'scipy" in told
    assert run(tmp_path, "validate", "c.yaml")[2].startswith("a campaign needs the package 'scipy")


@pytest.mark.parametrize(
    ("place", "in_the_wheel"),
    [
        ("controller.commands:size", "attitude_cosim.controller.commands:size"),
        ("orchestration.cli.main:main", "orchestration.cli.main:main"),
        ("inflight.commands:identify_ [inflight]", "attitude_cosim.inflight.commands:identify_ [inflight]"),
    ],
)
def test_the_wheel_names_a_command_where_its_package_stands_there(place, in_the_wheel):
    assert entry_point(place) == in_the_wheel
