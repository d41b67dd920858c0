"""Runs commands on hostile inputs in processes that are kept, each with a time limit, and counts how they end."""

from __future__ import annotations

import multiprocessing
import os
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

from click.testing import CliRunner

from orchestration.cli.main import main

SECONDS = 60.0
"""What one input may take."""
_SHOWN = 5

Make = Callable[[Random, Path], list[str]]
"""Writes a hostile input into a folder and returns the arguments of the command that is given it."""


def campaign(make: Make, prepare: Callable[[Path], None], count: int, seed: int) -> int:
    """Prints the counts; returns 0 where every input ended with an exit status of the command, other than 70."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        prepare(folder)
        ends: Counter[str] = Counter()
        bad: list[str] = []
        child: _Child | None = None
        for number in range(count):
            child = child or _Child(make, folder)
            end, output = child.ask(f"{seed}.{number}")
            ends[end] += 1
            if not end.startswith("status ") or end == "status 70":
                bad.append(f"input {number}: {end}: {output}")
                child.close()
                child = None
        if child is not None:
            child.close()
    for text in bad[:_SHOWN]:
        print(text)
    counts = ", ".join(f"{end}: {n}" for end, n in sorted(ends.items()))
    print(f"{count} inputs with seed {seed}: {counts}; crashes, hangs and internal errors: {len(bad)}")
    return 1 if bad else 0


class _Child:
    """A process that takes one input after the other."""

    def __init__(self, make: Make, folder: Path) -> None:
        context: Any = multiprocessing.get_context("fork" if os.name == "posix" else "spawn")
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=_serve, args=(make, folder, other), daemon=True)
        self.process.start()
        other.close()

    def ask(self, seed: str) -> tuple[str, str]:
        self.pipe.send(seed)
        if not self.pipe.poll(SECONDS):
            return "hang", seed
        try:
            end, output = self.pipe.recv()
        except EOFError:
            self.process.join()
            return f"crash, {self.process.exitcode}", seed
        return end, output

    def close(self) -> None:
        self.process.kill()
        self.process.join()


def _serve(make: Make, folder: Path, pipe: Any) -> None:
    os.chdir(folder)
    while True:
        arguments = make(Random(pipe.recv()), folder)
        result = CliRunner().invoke(main, arguments)
        output = result.output[-500:]
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            output = "".join(traceback.format_exception(result.exception))[-1500:]
            pipe.send((f"exception {type(result.exception).__name__}", output))
        else:
            pipe.send((f"status {result.exit_code}", output))
