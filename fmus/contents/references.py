"""The reference data that an FMU of a block carries (FMI-LS-REF), as they stand in the block's folder `reference_data`,
or `reference_data_wheels` for its set of wheels.
Tests: tests/tools/test_references.py."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from ..interface import Interface
from .description3 import names_3, parts

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
"""Where FMI-LS-REF has them in an FMU."""
_ABOUT = """\
This FMU carries reference data as FMI-LS-REF 1.0.0-beta.1 lays down: extra/org.fmi-standard.fmi-ls-ref/.

smoke-test.exp describes an experiment: parameters.ssv are set before it, then for each row of inputs.csv the inputs are
set at its time, before the step that begins there. outputs.csv has the outputs at each of these times: the first row in
initialization, each other after the step that ends there. {headers}

An output is right where it differs by no more than the annotation of its name in smoke-test.exp says.
Play it: orchestrate check FMU --as BLOCK
"""
_HEADERS = {
    2: "Headers are the variables' names, in quotation marks where they have a comma.",
    3: "A column is an array, row by row, with blanks between its\nelements; parameters.ssv names elements, x[1,2], "
    "since SSP 1.0 has no arrays.",
}


def folder_of(interface: Interface, block: Path) -> Path:
    """The folder of the reference data, of the block whose package stands in `block`."""
    return block / f"reference_data{interface.name.removeprefix(interface.code)}"


def kept_in(interface: Interface, block: Path) -> list[Path]:
    """The files of this folder; none where there is none."""
    return sorted(path for path in folder_of(interface, block).glob("*") if path.is_file())


def references(interface: Interface, block: Path, version: int = 2) -> dict[str, bytes]:
    """These files by their paths in the FMU of this version of FMI."""
    paths = kept_in(interface, block)
    found = {f"{FOLDER}/{path.name}": path.read_bytes().replace(b"\r\n", b"\n") for path in paths}
    if version == 3:
        found |= {name: _as_arrays(interface, text) for name, text in found.items() if name.endswith(".csv")}
    about = _ABOUT.format(headers=_HEADERS[version])
    return found | ({"documentation/fmi-ls-ref.txt": about.encode()} if found else {})


def _as_arrays(interface: Interface, text: bytes) -> bytes:
    """A table of elements as one of the arrays that they are in FMI 3.0, as FMPy and fmusim read them."""
    header, *rows = csv.reader(io.StringIO(text.decode()))
    place = {name: i for i, name in enumerate(header)}
    arrays = [
        (name, [place[element.name] for element in elements])
        for variable in interface.variables.values()
        for name, elements in zip(names_3(variable), parts(variable), strict=True)
        if elements[0].name in place
    ]
    table = [["time", *(name for name, _ in arrays)]]
    table += [[row[0], *(" ".join(row[i] for i in places) for _, places in arrays)] for row in rows]
    written = io.StringIO()
    csv.writer(written, lineterminator="\n").writerows(table)
    return written.getvalue().encode()
