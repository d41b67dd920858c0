"""`orchestrate review`: a page for the table of a design review. Tests: tests/design/review/test_review.py."""

from __future__ import annotations

import os
from pathlib import Path

import click

from orchestration import InputError
from orchestration.cli.console import Progress, open_page, say, say_table
from orchestration.cli.help import examples
from orchestration.cli.options import OPEN, QUIET, Between, out_folder, quantity
from orchestration.cli.status import EXPECTATION_FAILED, SIGNALLED
from orchestration.quantities import SECOND, parse_unit
from orchestration.results.place import check_writable

from . import page
from .compare import compared, of_folder
from .content import Review
from .options import Options, requirements
from .run import review


class Bar:
    """A bar for each of the studies."""

    def __init__(self, wanted: bool) -> None:
        self._wanted, self._study = wanted, ""
        self._bar: Progress | None = None

    def __call__(self, study: str, done: int, of: int) -> None:
        if study != self._study:
            self.close()
            self._bar, self._study = Progress(of, self._wanted, study), study
        assert self._bar is not None
        self._bar(done)

    def announce(self, text: str) -> None:
        """Says how long it takes."""
        if self._wanted:
            say(text)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


@click.command(
    "review",
    epilog=examples(
        "orchestrate review mine/tumble.yaml",
        "orchestrate review mine/tumble.yaml --requirements mine/requirements.yaml --runs 300 --open",
        "orchestrate review mine/tumble.yaml other/tumble.yaml",
    ),
)
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FILE [OTHER]")
@out_folder("Default: results/NAME-review.")
@click.option(
    "--requirements", "asked", type=click.Path(path_type=Path), metavar="FILE", help="What is to be verified."
)
@click.option("--runs", default=100, show_default=True, type=click.IntRange(1), help="Tumbles.")
@click.option("--members", default=20, show_default=True, type=click.IntRange(1), help="Holds of the pointing budget.")
@click.option("--seed", default=1, show_default=True, help="Of all draws.")
@click.option("--confidence", default=0.95, show_default=True, type=Between(0.0, 1.0, True, True),
              help="Of the statistics of the budget.")  # fmt: skip
@click.option(
    "--window", default="60 s", show_default=True, metavar="T", help="Over which mean and relative error count."
)
@click.option("--drift", default="600 s", show_default=True, metavar="T", help="Between two windows of the drift.")
@click.option("--mass", metavar="M", help="Mass, to compare with the inertia; default: that of the file.")
@click.option("--workers", default=os.cpu_count() or 1, type=click.IntRange(0), metavar="N",
              help="Processes that fly; 0: this one. Default: one for each core.")  # fmt: skip
@OPEN
@QUIET
@click.pass_context
def command(
    ctx: click.Context,
    files: tuple[Path, ...],
    out: Path | None,
    asked: Path | None,
    runs: int,
    members: int,
    seed: int,
    confidence: float,
    window: str,
    drift: str,
    mass: str | None,
    workers: int,
    open_: bool,
    quiet: bool,
) -> None:
    """Write a page for a satellite's design review.

    Its tables stand beside it as CSV. FILE is a scenario of a satellite, such as `orchestrate new satellite` writes.
    With OTHER both are flown with the same draws, and the page has them side by side. A folder of results, of a review
    or of a run, is shown or compared as it is. The same command goes on where it was stopped.

    Exit status 1 where a requirement is not met, undecided or not verifiable.
    """
    if len(files) > 2:
        raise InputError(f"{files[2]}: expected one scenario, or two to compare")
    wanted, power = requirements(asked) if asked is not None else ((), {})
    options = Options(
        runs,
        members,
        seed,
        confidence,
        quantity("--window", window, SECOND) or 0.0,
        quantity("--drift", drift, SECOND) or 0.0,
        workers,
        quantity("--mass", mass, parse_unit("kg")),
        wanted,
        power,
    )
    names = [_name(file) for file in files]
    if len(names) == 2 and names[0] == names[1]:
        names = ["A", "B"]
    target = out or Path("results") / f"{'-'.join(names)}-review"
    check_writable(target)
    bar = Bar(not quiet)
    try:
        each = [
            _one(file, target / name if len(files) > 1 else target, options, bar)
            for file, name in zip(files, names, strict=True)
        ]
    except KeyboardInterrupt as signal:
        say("interrupted; the same command goes on from there", error=True, fg="red")
        ctx.exit(SIGNALLED + getattr(signal, "number", 2))
    finally:
        bar.close()
    found = each[0]
    if len(each) > 1:
        found = compared(each[0], each[1], (names[0], names[1]))
        found.save(target)
    path = page.write(found, target)
    if not quiet:
        _print(found)
        say(f"\nreview in {path}")
    if open_:
        open_page(path)
    if any(status != "met" for one in each for status in one.verdicts):
        ctx.exit(EXPECTATION_FAILED)


def _one(file: Path, target: Path, options: Options, bar: Bar) -> Review:
    """Returns the review of a scenario, or what a folder of results has, written with its page."""
    found = of_folder(file) if file.is_dir() else review(file, target, options, bar, bar.announce)
    found.save(target)
    page.write(found, target)
    return found


def _name(file: Path) -> str:
    if file.is_dir():
        return file.resolve().name.removesuffix("-review")
    return file.stem if file.stem != "tumble" or not file.resolve().parent.name else file.resolve().parent.name


def _print(found: Review) -> None:
    say(", ".join([found.name, *(f"{name} {value}" for name, value in found.facts.items())]), bold=True)
    for name in ("Time to settle", "Errors of pointing", "Errors of knowledge", "Expectations", "Requirements"):
        for table in (t for section in found.sections for t in section.tables if t.name == name):
            say(f"\n{name}", bold=True)
            columns = 6 if name == "Requirements" else len(table.columns)
            say_table(table.columns[:columns], [row[:columns] for row in table.rows])
