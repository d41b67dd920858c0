"""Every command that a page shows does what the page says, in the order of the page."""

from __future__ import annotations

import doctest
import re
from importlib.util import find_spec
from pathlib import Path

import click
import pytest

from evidence.__main__ import main as studies
from fmus.build import BLOCKS, ensure
from orchestration.cli.main import main
from orchestration.cli.new import others

from .commands import PAGES, ROOT, commands, run, workspace

NOT_RUN = {
    "make check": "this test may be part of it",
    "make test": "this test is part of it",
    "python3 -m venv .venv && . .venv/bin/activate": "installs the environment that this test runs in",
    "pip install -e '.[build]'": "installs the environment that this test runs in",
    "pip install -e '.[campaign]'": "installs the environment that this test runs in",
    "orchestrate scenarios/mission_day.yaml --figures": "takes half a minute; the command above it is of the same kind",
    "pip install casadi": "installs the environment that this test runs in",
    "python -m evidence estimator": "takes half a minute and writes figures into docs/",
    "python -m evidence health --cases 50": "takes hours and writes docs/evidence/estimation.md",
    "python -m evidence optimum --cases 50": "takes minutes, needs casadi and writes docs/evidence/optimum.md",
    "python -m evidence rival --cases 50": "takes minutes; tests/evidence/flight/test_rival.py flies one",
    "python -m evidence rounding": "takes minutes; tests/evidence/rounding measures fewer samples",
    "python -m evidence single": "takes many minutes and needs QEMU; tests/evidence/single flies one block",
    "python -m plant.tables.density_fit": "writes the table plant/tables/density.csv; a test compares it with pymsis",
    "make prove": "takes an hour, needs Frama-C and writes docs/evidence/proofs.md; tests/evidence/proofs "
    "proves a block",
    "fmpy compile plant.fmu": "needs CMake; tests/native/test_carried.py compiles FMUs by FMPy",
    "make pil": "takes minutes, needs QEMU and writes docs/evidence/processor.md",
}
"""Commands that are not run, each with the reason."""

SHOWN = [page for page in PAGES if any(True for _ in commands(page))]


@pytest.mark.thorough
@pytest.mark.parametrize("page", SHOWN)
def test_the_commands_of_a_page_do_what_it_says(page: str, tmp_path: Path) -> None:
    given = [command for command in commands(page) if command.bare not in NOT_RUN]
    for block in BLOCKS:
        ensure(block)  # else a command says that it builds them
    findings = []
    for command, (status, output) in zip(given, run(given, tmp_path, workspace(tmp_path)), strict=True):
        if status != command.status:
            findings.append(f"$ {command.text}\nexit status {status}, the page says {command.status}\n{output}")
        elif command.output is not None and not matches(command.output, output):
            findings.append(f"$ {command.text}\nthe page says\n{command.output}\nfound\n{output}")
    assert not findings, "\n".join(findings)


def matches(stated: str, output: str) -> bool:
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    return doctest.OutputChecker().check_output(stated, output, flags)


def test_a_command_is_left_out_only_where_a_page_shows_it() -> None:
    shown = {command.bare for page in PAGES for command in commands(page)}
    assert set(NOT_RUN) <= shown


@pytest.mark.parametrize("page", PAGES)
def test_a_command_named_in_a_sentence_exists(page: str) -> None:
    """`make X` has its target, `orchestrate X --option` its command and options, `python -m X` its module, `studies`
    too."""
    text = re.sub(r"^```.*?^```$", "", (ROOT / page).read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
    names = ("Makefile", "fmus/kit/Makefile.template", "fmus/kit/Makefile.device.template")
    makefiles = [(ROOT / name).read_text("utf-8") for name in names]
    targets = {
        name for makefile in makefiles for line in re.findall(r"^([\w ]+):", makefile, re.M) for name in line.split()
    }
    for command in re.findall(r"`((?:make|orchestrate|python -m) [^`]+)`", text):
        tool, *words = command.replace("python -m", "python").split()
        if tool == "make":
            assert words[0] in targets, command
        elif words[0] == "evidence" and words[1:]:
            known = studies.get_command(click.Context(studies), words[1])
            assert known, command
            assert options(words) <= options_of(known), command
        elif tool == "python":
            assert find_spec(words[0].removeprefix("attitude_cosim.")), command
        else:
            context = click.Context(main)
            known = main.get_command(context, words[0]) or main.get_command(context, "run")
            while isinstance(known, click.Group) and words[1:]:
                words = words[1:]
                known = known.get_command(context, words[0])
            assert known
            if words[0] == "new" and words[1:] and words[1] in others():
                known = others()[words[1]].load()
            assert options(words) <= options_of(known), command


def options(words: list[str]) -> set[str]:
    return {word.partition("=")[0] for word in words if word.startswith("--")}


def options_of(command: click.Command) -> set[str]:
    return {name for parameter in command.params for name in parameter.opts} | {"--help"}
