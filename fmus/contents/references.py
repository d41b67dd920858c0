"""The reference data that an FMU of a block carries (FMI-LS-REF), as they stand in the block's folder `reference_data`,
or `reference_data_wheels` for its set of wheels.
Tests: tests/tools/test_references.py."""

from __future__ import annotations

from pathlib import Path

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


def references(folder: Path) -> dict[str, bytes]:
    """The files of a folder `reference_data` by their paths in the FMU; none where there is none."""
    paths = sorted(path for path in folder.glob("*") if path.is_file())
    found = {f"{FOLDER}/{path.name}": path.read_bytes().replace(b"\r\n", b"\n") for path in paths}
    return found | ({"documentation/fmi-ls-ref.txt": _ABOUT.encode()} if found else {})
