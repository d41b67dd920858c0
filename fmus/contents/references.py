"""The reference data that an FMU of a block carries (FMI-LS-REF), as they stand in the block's folder `reference_data`,
or `reference_data_wheels` for its set of wheels.
Tests: tests/tools/test_references.py."""

from __future__ import annotations

from pathlib import Path

from ..interface import Interface

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
"""Where FMI-LS-REF has them in an FMU."""
_ABOUT = """\
This FMU carries reference data as FMI-LS-REF 1.0.0-beta.1 lays down: extra/org.fmi-standard.fmi-ls-ref/.

smoke-test.exp describes an experiment: parameters.ssv are set before it, then for each row of inputs.csv the inputs are
set at its time, before the step that begins there. outputs.csv has the outputs at each of these times: the first row in
initialization, each other after the step that ends there. x[1][2] in a header stands for the variable x[1,2].

An output is right where it differs by no more than the annotation of its name in smoke-test.exp says.
Play it: orchestrate check FMU --as BLOCK
"""


def folder_of(interface: Interface, block: Path) -> Path:
    """The folder of the reference data, of the block whose package stands in `block`."""
    return block / f"reference_data{interface.name.removeprefix(interface.code)}"


def kept_in(interface: Interface, block: Path) -> list[Path]:
    """The files of this folder; none where there is none."""
    return sorted(path for path in folder_of(interface, block).glob("*") if path.is_file())


def references(interface: Interface, block: Path) -> dict[str, bytes]:
    """These files by their paths in the FMU."""
    paths = kept_in(interface, block)
    found = {f"{FOLDER}/{path.name}": path.read_bytes().replace(b"\r\n", b"\n") for path in paths}
    return found | ({"documentation/fmi-ls-ref.txt": _ABOUT.encode()} if found else {})
