"""Random calls of the FMI functions of the native blocks, right and wrong, on three instances at a time
(tests/native/fuzz.c)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import click

from fmus.interface import BLOCKS

from ..native.fuzzer import compiler, fuzzer

CALLS = 20000
"""Of one process; each begins with instances of its own and a seed of its own."""
SECONDS = 300.0
"""What one process may take. Under sanitizers the planned controller takes about 15 s."""


@click.command("calls")
@click.option("--count", default=1_000_000, show_default=True, help="Calls of each block.")
@click.option("--seed", default=1, show_default=True)
@click.option("--block", "blocks", multiple=True, type=click.Choice(BLOCKS), help="Of this block only; repeatable.")
def command(count: int, seed: int, blocks: tuple[str, ...]) -> None:
    """Call the native blocks' FMI functions at random, under sanitizers."""
    with_sanitizers = compiler("system") or compiler("zig")
    assert with_sanitizers is not None
    bad = [trial(block, fuzzer(block, with_sanitizers), count, seed) for block in blocks or BLOCKS]
    sys.exit(1 if any(bad) else 0)


def trial(block: str, program: Path, count: int, seed: int) -> int:
    """Prints the counts of `count` calls; returns the number of processes that crashed, hung or found an error."""
    refusals = steps = bad = 0
    for number, done in enumerate(range(0, count, CALLS)):
        own = seed * 1_000_000 + number
        arguments = [str(own), str(min(CALLS, count - done))]
        try:
            run = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=SECONDS, check=False)
        except subprocess.TimeoutExpired:
            end = "hang"
        else:
            if run.returncode == 0:
                some, more = (int(word) for word in run.stdout.split() if word.isdigit())
                refusals, steps = refusals + some, steps + more
                continue
            end = f"status {run.returncode}: {(run.stdout + run.stderr)[-1500:]}"
        bad += 1
        print(f"{block}: fuzz {' '.join(arguments)}: {end}", flush=True)
    print(
        f"{block}: {count} calls with seed {seed}: {refusals} refusals, {steps} steps; "
        f"crashes, hangs and errors: {bad}",
        flush=True,
    )
    return bad
