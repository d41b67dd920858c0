"""Thousands of random FMI calls, right and wrong, under sanitizers: no crash, no undefined behaviour, no leak."""

from __future__ import annotations

import subprocess

import pytest

from fmus.interface import BLOCKS
from tests.machine import lacking

from .fuzzer import compiler, fuzzer


def _compiler(kind: str) -> list[str]:
    command = compiler(kind)
    if command is None:
        lacking("the address sanitizer needs a system compiler (gcc or clang)")
    return command


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("kind", ["zig", "system"])
def test_random_calls_under_sanitizers(block: str, kind: str) -> None:
    program = fuzzer(block, _compiler(kind))
    # A plan takes a thousand times as long as a law; `make torture` makes a million calls of each.
    seeds, calls = (2, 5000) if block == "controller_planned" else (5, 20000)
    for seed in range(1, 1 + seeds):
        run = subprocess.run([program, str(seed), str(calls)], capture_output=True, text=True, check=False)
        assert run.returncode == 0, f"seed {seed}: {run.stdout}{run.stderr}"
        refusals, steps = (int(word) for word in run.stdout.split() if word.isdigit())
        assert refusals > 1000
        assert steps > 100
