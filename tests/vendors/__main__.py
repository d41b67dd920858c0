"""`python -m tests.vendors --count 60 --seed 1`: makes vendors' FMUs, asks the commands, and prints a table by kind.

With `--rows FILE` each case is a line of JSON there, and a run that was ended goes on behind the last.
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
from typing import Any

import click

from orchestration.session.open import open_scenario
from orchestration.session.read import load, read

from . import kinds, wrapper
from .figure import draw
from .judge import Verdict, judge

Row = dict[str, Any]
"""A case, and what was said of it."""
SCENARIO = Path(__file__).parents[2] / "scenarios" / "paper_no_singularity.yaml"


def drawn(count: int, seed: int) -> Iterator[tuple[kinds.Case, str]]:
    """Yields cases and how each is packed: each kind alone in turn, then pairs by lot."""
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
            lot = rng.random()
            yield case, "FMI 3" if lot < 0.25 else "Python" if lot > 0.85 else "FMI 2"


@click.command()
@click.option("--count", default=60, show_default=True)
@click.option("--seed", default=1, show_default=True)
@click.option("--minutes", default=10.0, show_default=True, help="No FMU is begun after so long.")
@click.option("--only", help="Kinds that hold this text only.")
@click.option("--rows", "file", type=click.Path(path_type=Path), help="Add each case there; go on where it ends.")
@click.option("--figure", type=click.Path(path_type=Path), help="Draw the counts there.")
@click.option("--keep", type=click.Path(path_type=Path), help="Keep the FMUs in this folder.")
def main(
    count: int,
    seed: int,
    minutes: float,
    only: str | None,
    file: Path | None,
    figure: Path | None,
    keep: Path | None,
) -> None:
    """Ask the commands about generated FMUs of other teams."""
    ours = read(SCENARIO)
    opened = open_scenario(load(ours))
    start = perf_counter()
    rows = [json.loads(line) for line in file.read_text("utf-8").splitlines()] if file and file.exists() else []
    known = {row["name"] for row in rows}
    with tempfile.TemporaryDirectory() as temporary:
        folder = keep or Path(temporary)
        folder.mkdir(exist_ok=True, parents=True)
        for number, (case, flavour) in enumerate(drawn(count, seed)):
            block = case.vendor.block
            name = f"{seed}.{number} {block} {flavour} {' + '.join(case.kinds)}"
            if name in known or (only and not any(only in kind for kind in case.kinds)):
                continue
            if perf_counter() - start > 60 * minutes:
                print(f"ended after {minutes:g} min")
                break
            path = folder / f"v{seed}_{number}.fmu"
            starts = [(start.element, start.value) for start in opened.plan.starts[block]]
            wrapper.pack(path, case.vendor, opened.fmus[block], starts, flavour)
            begun = perf_counter()
            try:
                verdict = judge(case, path, ours)
            except Exception as error:  # an FMU that no command can look at counts as a miss
                said = [f"{type(error).__name__}: {error}"]
                verdict = Verdict(said=said, proposed=False, detected=False, named=False)
            row = {"name": name, "kinds": case.kinds, "answer": case.answer, **vars(verdict)}
            rows.append({**row, "seconds": perf_counter() - begun})
            if file is not None:
                with file.open("a", encoding="utf-8") as out:
                    out.write(json.dumps(rows[-1]) + "\n")
            print(line(rows[-1]), flush=True)
            if not keep:
                path.unlink()
    print(table(rows), flush=True)
    if figure is not None:
        draw(rows, figure)
    sys.exit(1 if any(row["false"] for row in rows) else 0)


def line(row: Row) -> str:
    """Returns a case and what was said of it."""
    flags = {key: row[key] for key in ("proposed", "detected", "named") if row[key] is not None}
    words = ("FALSE " if row["false"] else "") + "; ".join(row["said"])
    return f"{row['name']} [{row['answer']}, {row['seconds']:.1f} s] {flags} {words}"


def table(rows: list[Row]) -> str:
    """Returns the counts by kind; a pair counts in both."""
    lines = [
        "",
        "| kind | FMUs | right mapping proposed | detected | named | false statements |",
        "|---|---|---|---|---|---|",
    ]
    groups = [(name, [row for row in rows if name in row["kinds"]]) for name in kinds.KINDS]
    for name, some in [*groups, ("all", rows)]:
        if some:
            cells = []
            for key in ("proposed", "detected", "named"):
                values = [row[key] for row in some if row[key] is not None]
                cells.append(f"{sum(values)} of {len(values)}" if values else "")
            false = sum(bool(row["false"]) for row in some)
            lines.append(f"| {name} | {len(some)} | {' | '.join(cells)} | {false} |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
