"""The container's C under sanitizers: a flight, its states and their damaged bytes, without a finding or a leak."""

from __future__ import annotations

import subprocess
from pathlib import Path

import fmpy
import pytest

import orchestration
from fmus import telemetry
from fmus.native import SHELL
from orchestration.export import container
from tests.machine import lacking
from tests.native.fuzzer import compiler
from tests.once import built

from .test_container_states import paper

HOST = Path(__file__).with_name("container_host.c")


def host() -> Path:
    command = compiler("system")
    if command is None:
        lacking("the address sanitizer needs a system compiler (gcc or clang)")
    includes = (SHELL, telemetry.HERE, container.HERE, container.LOOP.parent)
    command += ["-std=gnu11", "-O1", "-g", "-Wall", "-Wextra", "-Werror", *(f"-I{folder}" for folder in includes)]
    sources = [HOST, *sorted(container.HERE.glob("*.c")), container.LOOP, *telemetry.SHARED]

    def make(path: Path) -> None:
        words = [*command, *map(str, sources), "-o", str(path), "-ldl", "-lm"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr

    return built("container_host", [*command, *sources, *(p for i in includes for p in i.glob("*.h"))], make)


@pytest.mark.parametrize("exchange", ["sequential", "parallel"])
def test_a_container_flies_saves_and_refuses_under_sanitizers(exchange: str, tmp_path: Path) -> None:
    archive = orchestration.export_loop(paper(exchange), tmp_path / "loop.fmu")
    about = fmpy.read_model_description(str(archive))
    resources = Path(fmpy.extract(str(archive), str(tmp_path / "with space"))) / "resources"
    words = [str(host()), resources.as_uri(), about.guid, "0.1", "20"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    first, back, second = map(float.fromhex, done.stdout.split())
    assert first == back == second != 0.0
