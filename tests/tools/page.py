"""docs/use/tools.md, made by running the recipes."""

from __future__ import annotations

import re
from importlib.metadata import version
from pathlib import Path

from .measure import LOOPS, ONES, RECIPES, STEPS, Recipe, difference

TARGET = Path(__file__).parents[2] / "docs" / "use" / "tools.md"

_HEAD = """# Our FMUs in other tools

Made by `python -m tests.tools`; do not edit. Every row is also a test (`tests/tools/`).

These commands write the files that other tools read:

```sh
{orchestrate}```

An SSP archive (System Structure and Parameterization 1.0) contains the FMUs, their connections, units and start values.
`orchestrate` stores the rest of a scenario (step, expectations, figures) in an annotation, so `orchestrate adcs.ssp` gives the same results as the scenario, bit for bit.
For an archive from another tool it uses step and duration of the default experiments, or `--step` and `--duration`.

SSP has no words for rates (`every`), faults and delays, and other tools would run another system without a word. So the export refuses a scenario
that has them. `--for-orchestrate` keeps them in the annotation, for `orchestrate` alone.

What `orchestrate` reads is held against the schemas of SSP 1.0, and unpacked within bounds (1 GB, 20,000 entries, 2 GB unpacked). An annotation
decides neither over guards (`isolation`, `timeout`, `memory`, `validation`) nor over files (`fmu`, `map`, `interface`): such an archive is refused.

Both annotations stand in the system: first that of OMSimulator with the step, which its command line looks for there, then ours. None stands at the root.

## Checked

| checker | version | finding |
|---|---|---|
| `fmpy validate plant.fmu` | {fmpy} | none, all FMUs in both flavours, the container too |
| `fmutool -input plant.fmu -check` | {toolbox} | none, all FMUs in both flavours |
| schemas of SSP 1.0, as supplied with FMPy | {fmpy} | none |

## Run

The largest difference of `attitude_error` over the first {duration:g} s of the paper's manoeuvre V.B, in rad, relative to `orchestrate`: with its default exchange, and with `exchange` set as in the tool.

| tool | version | what | step, s | from the default | with the tool's exchange |
|---|---|---|---|---|---|
"""


def text(folder: Path) -> str:
    """The page; `folder` is what `measure.prepare` has filled."""
    from .measure import DURATION

    orchestrate = (RECIPES / "orchestrate.sh").read_text("utf-8")
    head = _HEAD.format(
        orchestrate=orchestrate, fmpy=version("FMPy"), toolbox=version("fmu-manipulation-toolbox"), duration=DURATION
    )
    rows = [
        f"| {recipe.tool} | {recipe.version} | {recipe.what} | {step:g} | {_number(d.sequential)} | {_number(d.same)} ({recipe.exchange}) |"
        for recipe in LOOPS
        for step in STEPS
        for d in [difference(recipe, folder, step)]
    ]
    alone = ", ".join(f"{recipe.tool} {recipe.version}" for recipe in ONES)
    single = (
        f"Plant, controller and allocator, each by itself, in {alone}: no difference beyond rounding (1e-13 relative)."
    )
    single += "\nAll three tools reproduce the reference data that these FMUs carry ([FMI-LS-REF](swap.md#reference-data)) within their tolerances."
    recipes = "\n".join(_section(recipe) for recipe in (*ONES, *LOOPS))
    words = (Path(__file__).parent / "words.md").read_text("utf-8")
    return f"{head}{chr(10).join(rows)}\n\n{single}\n\n## What to type\n\n{recipes}\n{words}"


def _number(size: float) -> str:
    return "0" if size == 0.0 else f"{size:.1e}" if size < 1e-9 else f"{size:.2g}"


def _section(recipe: Recipe) -> str:
    note = f"\n{recipe.note}\n" if recipe.note else ""
    install = f"`pip install {recipe.package}`"
    if recipe.package != "FMPy" and recipe.script.startswith("fmpy"):
        install += " for the export; the tool that runs it needs nothing more"
    return f"### {recipe.tool}: {recipe.what}\n\n{install}\n{note}\n```python\n{recipe.text}```\n"


def without_figures(page: str) -> str:
    """The page with what depends on versions and machine left out: versions, and the size of rounding."""
    page = re.sub(r"\| \d[\w.]* \|", "| # |", page)
    page = re.sub(r"(FMPy|libcosim|ecos) \d[\w.]*", r"\1 #", page)
    return re.sub(r"\| (0|\d\.\de-\d\d) \((\w+)\)", r"| rounding (\2)", page)
