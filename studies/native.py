"""Runs of the native FMUs, each opened once a process, so that a sweep pays for little but the step loop.

A study copies its FMUs first, so that a build meanwhile changes nothing in it.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from fmus.build import Block, ensure
from fmus.interface import load as load_interface
from fmus.native import sources
from orchestration import Result, Scenario, load
from orchestration.fmu.archive import Fmu, open_fmu
from orchestration.instances.slave import Slave
from orchestration.runner.plan import Plan, plan
from orchestration.runner.run import run_blocks

from .paper import ROOT

FOLDER = ROOT / "results" / "studies"
PAPER = ("plant", "controller", "allocator")
"""The blocks of the paper's loop."""
JUDGE = "plant_judge"
"""The block outside the loop by which runs are judged."""


def pin(blocks: Iterable[str] = (*PAPER, JUDGE)) -> dict[str, Path]:
    """Builds the blocks where need be, and copies them to where no build reaches; by block, named by what they do."""
    kept = FOLDER / "fmus"
    kept.mkdir(parents=True, exist_ok=True)
    files = {}
    for block in blocks:
        content = ensure(block, "native").read_bytes()
        files[block] = kept / f"{block}-{identity(block)}.fmu"
        if not files[block].exists():
            part = files[block].with_suffix(f".{os.getpid()}")
            part.write_bytes(content)
            part.replace(files[block])
    return files


def identity(block: str) -> str:
    """What a block does, as a hash: its C and tables, and its variables but for how they are described in words."""
    folder = Block.named(block).folder
    tables = sorted(path for path in (folder / "tables").rglob("*") if path.suffix in (".py", ".csv"))
    digest = hashlib.sha256()
    for path in (*sources(folder), *tables):
        digest.update(path.name.encode() + path.read_bytes())
    for v in load_interface(block).variables.values():
        digest.update(repr(replace(v, description="")).encode())
    return digest.hexdigest()[:16]


@cache
def opened(path: Path) -> tuple[Fmu, Path]:
    """An FMU and the folder where it is unpacked."""
    fmu = open_fmu(path)
    folder = Path(tempfile.mkdtemp(prefix="study-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    fmu.extract(folder)
    return fmu, folder


@contextmanager
def instances(scenario: Scenario, fmus: Mapping[str, Path]) -> Iterator[tuple[Plan, dict[str, Any]]]:
    """A scenario's plan and the running instances of its blocks, by name."""
    parts = {name: opened(fmus[entry.fmu]) for name, entry in scenario.blocks.items()}
    ready = plan(scenario, {name: fmu.model for name, (fmu, _) in parts.items()})
    blocks: dict[str, Any] = {}
    try:
        for name, (fmu, folder) in parts.items():
            blocks[name] = Slave(name, fmu, folder)
        yield ready, blocks
    finally:
        for block in blocks.values():
            block.close()


def run(scenario: Any, fmus: Mapping[str, Path], overrides: Mapping[str, Any] | None = None) -> Result:
    """Runs a scenario (as data, or what `source.read` gives) of the project's blocks with these FMUs.

    Raises InputError where it is wrong and BlockError where a block fails.
    """
    with instances(load(scenario, overrides), fmus) as (ready, blocks):
        result = run_blocks(ready, blocks, compiled=True)
    if result.failure is not None:
        raise result.failure
    return result
