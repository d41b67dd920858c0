"""`orchestrate reference`: writes the reference data that an FMU is to carry.

Tests: tests/orchestration/acceptance/test_references.py.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import click

from fmus.build import ensure
from fmus.interface import load

from ..acceptance.reference_data import write
from ..acceptance.vector import record, scenario_of
from ..errors import InputError, hint
from ..fmu.archive import examined, shown
from ..fmu.interfaces import is_path, own
from ..results.place import check_writable
from .console import notes, say
from .help import examples
from .paths import PATH


@click.command(
    "reference",
    epilog=examples("orchestrate reference allocator", "orchestrate reference vendor.fmu --vector vector -o resources"),
)
@click.argument("fmu")
@click.option("--vector", type=PATH, metavar="DIR", help="Test vector of a kit, from which the inputs are taken.")
@click.option(
    "-o", "--out", type=PATH, default=Path("reference_data"), show_default=True, metavar="DIR", help="Where to write."
)
def command(fmu: str, vector: Path | None, out: Path) -> None:
    """Write the reference data that an FMU is to carry.

    These are inputs, outputs and tolerances (FMI-LS-REF). FMU is a file with the test vector of its kit,
    or a block of this project, whose inputs are taken from one of its runs.
    """
    check_writable(out)
    if is_path(fmu):
        if vector is None:
            examined(Path(fmu))  # that it is not there is told first
            raise InputError(f"{fmu}: expected --vector DIR, the test vector of its kit")
        files = write(Path(fmu), vector, out, remark=lambda text: notes([text]))
    else:
        if fmu not in own():
            expected = f"; expected a path that ends in .fmu, or one of {', '.join(own())}"
            raise InputError(f"there is no block {fmu!r}{hint(fmu, own()) or expected}")
        flavours = [ensure(fmu, flavour) for flavour in sorted(load(fmu).flavours)]  # native before python
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder) if vector is None else vector
            if vector is None:
                record(scenario_of(fmu), fmu, source)
            files = write(flavours[0], source, out, flavours[1:])
    for path in files:
        say(str(shown(path)))
