"""Options and help as users expect them, and folders of results that are not the user's own files."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import webbrowser
from pathlib import Path

import click
import pytest

from orchestration import InputError, run
from orchestration.cli.main import COMMANDS, main, outside
from tests.commands import orchestrate

pytestmark = pytest.mark.isolate

ROOT = Path(__file__).parents[3]


BASE = """\
import sys
for name in ("pyarrow", "dask", "distributed", "cma", "SALib", "pandas", "xarray", "pythonfmu", "ziglang"):
    sys.modules[name] = None
from orchestration.cli.main import main
main(sys.argv[1:], prog_name="orchestrate")
"""
"""The command where none of the optional packages is installed."""


def in_the_base_install(*arguments, **variables):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **variables}
    command = [sys.executable, "-c", BASE, *arguments]
    return subprocess.run(command, capture_output=True, text=True, env=environment, check=False)


@pytest.mark.thorough
def test_help_and_completion_need_no_optional_package():
    told = in_the_base_install("--help")
    assert (told.returncode, told.stderr) == (0, "")
    assert all(f"\n  {name} " in told.stdout for name in COMMANDS)
    told = in_the_base_install("campaign", "-h")
    assert (told.returncode, told.stderr) == (0, "")
    assert "Fly a scenario many times" in told.stdout
    words = {"COMP_WORDS": "orchestrate camp", "COMP_CWORD": "1", "_ORCHESTRATE_COMPLETE": "bash_complete"}
    told = in_the_base_install(**words)
    assert (told.stdout.splitlines()[0], told.stderr) == ("plain,campaign", "")


def test_a_campaign_without_its_packages_says_how_to_install_them(loop):
    loop.with_name("toy.yaml").write_text(
        "name: toy\nscenario: loop.yaml\nruns: 2\nseed: 4\nvary: {motor.speed0: {uniform: [1 rad/s, 2 rad/s]}}\n"
        "metrics: [{name: final, signal: motor.speed, statistic: final}]\n"
    )
    told = in_the_base_install("campaign", "toy.yaml", "--workers", "0")
    wanted = "a campaign needs the package 'pyarrow'; remedy: pip install 'attitude-cosim[campaign]'\n"
    assert (told.returncode, told.stderr) == (2, wanted)


@pytest.mark.parametrize("name", [*COMMANDS, *outside()])
def test_each_help_fits_80_columns_and_has_examples_that_can_be_typed(name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    told = orchestrate(name, "-h").stdout
    assert told == orchestrate(name, "--help").stdout
    options, _, shown = told.partition("  Examples:\n")
    assert max(map(len, options.splitlines())) <= 80
    lines = [line.strip() for line in shown.splitlines() if line.strip()]
    assert lines
    above = click.Context(main, info_name="orchestrate", **main.context_settings)  # click keeps what -h is called
    for line in lines:
        _, *words = shlex.split(line.partition(" > ")[0])
        words = words[1:] if words[0] in (*COMMANDS, *outside()) else words
        command = main.get_command(above, name)
        command.make_context(name, words, parent=above)  # raises where there is no such option


def test_an_error_of_a_command_that_help_imports_is_no_traceback(monkeypatch):
    monkeypatch.setitem(COMMANDS, "view", "orchestration.cli.not_there")
    told = orchestrate("-h")
    assert told.exit_code == 70
    assert told.stderr.startswith("internal error: ModuleNotFoundError: No module named 'orchestration.cli.not_there'")


def test_no_summary_of_a_command_is_cut(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    told = orchestrate("-h").stdout
    assert told == orchestrate("--help").stdout
    assert "..." not in told.partition("Commands:")[2]
    assert all(re.search(rf"^  {name} +[A-Z].*\.$", told, re.M) for name in (*COMMANDS, *outside()))


def test_the_short_options_are_the_long_ones(loop):
    told = orchestrate(loop.name, "-q", "-o", "there")
    assert (told.exit_code, told.output) == (0, "")
    assert Path("there/manifest.json").exists()


def test_the_report_is_opened_in_the_browser_or_its_place_is_said(loop, monkeypatch):
    opened = []
    monkeypatch.setattr(webbrowser, "open", lambda address: not opened.append(address))
    monkeypatch.setenv("DISPLAY", ":0")
    orchestrate(loop.name, "-q", "--open")
    orchestrate("view", "results/loop")
    assert opened == 2 * [Path("results/loop/report.html").absolute().as_uri()]
    monkeypatch.setattr(webbrowser, "open", lambda address: False)
    told = orchestrate(loop.name, "-q", "--open")
    assert told.exit_code == 0
    assert f"there is no browser here; the page is {Path('results/loop/report.html').absolute()}" in told.stderr


@pytest.mark.parametrize(("folder", "why"), [("nowhere", "there is no such folder"), (".", "no page in it")])
def test_view_says_what_it_misses(loop, folder, why):
    told = orchestrate("view", folder)
    assert told.exit_code == 2
    assert f"{folder}: {why}; expected the folder of a run" in told.stderr


def test_the_last_of_two_values_counts_and_the_other_is_named(loop):
    told = orchestrate(loop.name, "--set", "motor.speed0=3", "--set", "motor.speed0=1")
    assert "note: --set motor.speed0=3 has no effect: --set motor.speed0=1, which follows, counts" in told.stderr
    assert "9.549 rpm at 0 s" in told.stdout
    assert orchestrate(loop.name, "--set", "motor.speed0=3", "--set", "motor.speed0=1", "-q").stderr == ""


def test_a_folder_with_files_of_others_is_refused_by_their_names(loop):
    mine = Path("mine")
    mine.mkdir()
    for name in ("a.txt", "manifest.json", "signals.csv", "z.txt", ".hidden"):
        (mine / name).write_text("{}")
    told = orchestrate(loop.name, "--out", "mine")
    assert told.exit_code == 2
    assert told.stderr.startswith(
        "mine holds files that are no results: a.txt, manifest.json, signals.csv and 1 more; expected a new or "
        "empty folder"
    )
    with pytest.raises(InputError, match="mine holds files that are no results"):
        run(loop, out="mine")
    assert (mine / "signals.csv").read_text() == "{}"
    assert orchestrate(loop.name, "--out", "mine/results").exit_code == 0


def test_results_are_replaced_and_what_a_user_put_beside_them_stays(loop):
    orchestrate(loop.name, "-q")
    Path("results/loop/notes.txt").write_text("mine")
    assert orchestrate(loop.name, "-q").exit_code == 0
    assert Path("results/loop/notes.txt").read_text() == "mine"


def test_an_archive_has_results_of_its_own(loop):
    orchestrate(loop.name, "-q")
    before = Path("results/loop/manifest.json").read_bytes()
    assert orchestrate("export", loop.name, "--ssp", "other.ssp").exit_code == 0
    told = orchestrate("other.ssp")
    assert f"results in {Path('results/other')}" in told.stdout
    assert Path("results/loop/manifest.json").read_bytes() == before


def test_results_of_another_scenario_of_the_same_name_are_not_replaced_unasked(loop):
    orchestrate(loop.name, "-q")
    Path("copy.yaml").write_text(loop.read_text())
    told = orchestrate("copy.yaml")
    assert told.exit_code == 2
    assert (
        "results/loop holds the results of another scenario, loop.yaml; remedy: --out DIR"
        in Path(told.stderr).as_posix()
    )
    assert orchestrate("copy.yaml", "-q", "-o", "results/loop").exit_code == 0, "asked for by its name"
    loop.unlink()
    assert orchestrate("copy.yaml", "-q").exit_code == 0


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("va", "plain,validate"),
        ("loop.yaml --fig", "plain,--figures"),
        ("info all", "plain,allocator"),
        ("lo", "file,lo"),
    ],
)
def test_a_shell_completes_commands_options_blocks_and_files(typed, offered):
    from click.testing import CliRunner

    words = ["orchestrate", *typed.split()]
    environment = {
        "_ORCHESTRATE_COMPLETE": "bash_complete",
        "COMP_WORDS": " ".join(words),
        "COMP_CWORD": str(len(words) - 1),
    }
    told = CliRunner(env=environment).invoke(main, [], prog_name="orchestrate")
    assert offered in told.stdout.splitlines()


@pytest.mark.parametrize(
    ("given", "remedy"),
    [("duration=3 s", "--duration '3 s'"), ("isolation=process", "a file that extends it and has 'isolation'")],
)
def test_a_key_of_the_scenario_is_no_start_value_and_what_changes_it_is_said(given, remedy):
    result = orchestrate("validate", ROOT / "scenarios" / "minimal.yaml", "--set", given)
    name = given.partition("=")[0]
    assert result.exit_code == 2
    assert f"--set {given}: {name} is no parameter but a key of the scenario; remedy: {remedy}" in result.stderr


def test_a_mistyped_key_that_has_an_option_is_told_by_it():
    for given, near, remedy in (("duraton=3", "duration", "--duration '3'"), ("stepp=1 s", "step", "--step '1 s'")):
        result = orchestrate("validate", ROOT / "scenarios" / "minimal.yaml", "--set", given)
        assert f"did you mean {near!r}?; remedy: {remedy}" in result.stderr, result.stderr
