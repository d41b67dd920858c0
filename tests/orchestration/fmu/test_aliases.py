"""FMUs of which two variables that can be set share a value reference."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestration import InputError
from orchestration.fmu.archive import open_fmu

from .. import fmus

MORE = "".join(
    f'<ScalarVariable name="{name}" valueReference="700" causality="input"><Real start="0"/></ScalarVariable>'
    for name in ("a", "b")
)


def test_an_fmu_in_which_one_value_sets_two_inputs_is_refused_and_opened_where_that_is_asked_for(
    tmp_path: Path,
) -> None:
    xml = fmus.description("motor").replace("</ModelVariables>", f"{MORE}</ModelVariables>")
    path = fmus.write(tmp_path / "motor.fmu", xml)
    told = "a and b share the value reference 700 of type Real, and a and b can be set; expected at most one that can"
    with pytest.raises(InputError, match=f"motor.fmu: modelDescription.xml is not valid:\n  {told}"):
        open_fmu(path)
    (problem,) = open_fmu(path, lenient=True).problems
    assert problem.startswith(told)
