"""Random, damaged and mixed frames at both ends of the link, under sanitizers (tests/fmus/link/fuzz_*.c)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import click

from ..fmus.link.fuzzer import ENDS, fuzzer
from ..native.fuzzer import compiler

FRAMES = 50_000
"""Of one process, which has a seed of its own."""
SECONDS = 120.0
"""What one process may take; it needs about a second."""


@click.command("links")
@click.option("--count", default=1_000_000, show_default=True, help="Frames at each end.")
@click.option("--seed", default=1, show_default=True)
def command(count: int, seed: int) -> None:
    """Feed frames to the firmware skeleton and to the link FMU, under sanitizers."""
    with_sanitizers = compiler("system") or compiler("zig")
    assert with_sanitizers is not None
    bad = [trial(end, fuzzer(end, with_sanitizers), count, seed) for end in ENDS]
    sys.exit(1 if any(bad) else 0)


def trial(end: str, program: Path, count: int, seed: int) -> int:
    """Prints what `count` frames came to; returns the number of processes that crashed, hung or found an error."""
    bad = frames = 0
    for number, done in enumerate(range(0, count, FRAMES)):
        arguments = [str(seed * 1_000_000 + number), str(min(FRAMES, count - done))]
        try:
            run = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=SECONDS, check=False)
        except subprocess.TimeoutExpired:
            ended = "hang"
        else:
            if run.returncode == 0:
                frames += int(run.stdout.split()[0])
                continue
            ended = f"status {run.returncode}: {(run.stdout + run.stderr)[-1500:]}"
        bad += 1
        print(f"{end}: fuzz_{end} {' '.join(arguments)}: {ended}", flush=True)
    print(f"{end}: {frames} frames with seed {seed}; crashes, hangs and errors: {bad}", flush=True)
    return bad
