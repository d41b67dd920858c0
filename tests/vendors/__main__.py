"""`python -m tests.vendors --count 60 --seed 1`: makes vendors' FMUs, asks the commands, and prints a table by kind.

Exit status: 1 where anything said of an FMU is false, else 0.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Iterator
from itertools import count as counting
from pathlib import Path
from random import Random
from time import perf_counter

import click

from orchestration.session.open import open_scenario
from orchestration.session.read import load, read

from . import kinds, wrapper
from .judge import Verdict, judge

SCENARIO = Path(__file__).parents[2] / "scenarios" / "paper_no_singularity.yaml"


def drawn(count: int, seed: int) -> Iterator[tuple[kinds.Case, bool]]:
    """Yields cases and whether each is of FMI 3.0: each kind alone in turn, then pairs by lot."""
    rng = Random(seed)
    alone = [[name] for name in kinds.KINDS]
    rng.shuffle(alone)
    made = 0
    for number in counting():
        if made == count:
            return
        chosen = alone.pop() if alone else rng.sample(list(kinds.KINDS), 1 if rng.random() < 0.3 else 2)
        case = kinds.make(1000 * seed + number, chosen, units=rng.random() < 0.75)
        if case is not None:
            made += 1
            yield case, rng.random() < 0.25


@click.command()
@click.option("--count", default=60, show_default=True)
@click.option("--seed", default=1, show_default=True)
@click.option("--minutes", default=10.0, show_default=True, help="No FMU is begun after so long.")
@click.option("--only", help="Kinds that hold this text only.")
@click.option("--json", "json_", type=click.Path(path_type=Path), help="Write each case there.")
@click.option("--keep", type=click.Path(path_type=Path), help="Keep the FMUs in this folder.")
def main(count: int, seed: int, minutes: float, only: str | None, json_: Path | None, keep: Path | None) -> None:
    """Ask the commands about generated FMUs of other teams."""
    ours = read(SCENARIO)
    opened = open_scenario(load(ours))
    start = perf_counter()
    rows: list[tuple[kinds.Case, Verdict, str, float]] = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = keep or Path(temporary)
        folder.mkdir(exist_ok=True, parents=True)
        for number, (case, fmi3) in enumerate(drawn(count, seed)):
            if only and not any(only in kind for kind in case.kinds):
                continue
            if perf_counter() - start > 60 * minutes:
                print(f"ended after {minutes:g} min")
                break
            block = case.vendor.block
            path = folder / f"v{seed}_{number}.fmu"
            starts = [(start.element, start.value) for start in opened.plan.starts[block]]
            wrapper.pack(path, case.vendor, opened.fmus[block], starts, fmi3)
            begun = perf_counter()
            name = f"{number} {block} FMI {3 if fmi3 else 2} {' + '.join(case.kinds)}"
            try:
                verdict = judge(case, path, ours)
            except Exception as error:  # an FMU that no command can look at counts as a miss
                verdict = Verdict(
                    said=[f"{type(error).__name__}: {error}"], proposed=False, detected=False, named=False
                )
            seconds = perf_counter() - begun
            rows.append((case, verdict, name, seconds))
            flags = {
                k: getattr(verdict, k) for k in ("proposed", "detected", "named") if getattr(verdict, k) is not None
            }
            words = "; ".join(verdict.said)
            print(
                f"{name} [{case.answer}, {seconds:.1f} s] {flags} {'FALSE ' if verdict.false else ''}{words}",
                flush=True,
            )
            if not keep:
                path.unlink()
    print(table(rows), flush=True)
    if json_ is not None:
        data = [{"name": n, "answer": c.answer, **vars(v), "seconds": s} for c, v, n, s in rows]
        json_.write_text(json.dumps(data, indent=1) + "\n", "utf-8")
    sys.exit(1 if any(verdict.false for _, verdict, _, _ in rows) else 0)


def table(rows: list[tuple[kinds.Case, Verdict, str, float]]) -> str:
    """Returns the counts by kind; a pair counts in both."""
    lines = [
        "",
        "| kind | FMUs | right mapping proposed | detected | named | false statements |",
        "|---|---|---|---|---|---|",
    ]
    groups = [(name, [r for r in rows if name in r[0].kinds]) for name in kinds.KINDS]
    for name, some in [*groups, ("all", rows)]:
        if some:
            cells = []
            for key in ("proposed", "detected", "named"):
                values = [getattr(v, key) for _, v, _, _ in some if getattr(v, key) is not None]
                cells.append(f"{sum(values)} of {len(values)}" if values else "")
            lines.append(
                f"| {name} | {len(some)} | {' | '.join(cells)} | {sum(bool(v.false) for _, v, _, _ in some)} |"
            )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
