"""FMUs whose variables share a value reference: what FMI 2.0 allows (2.2.7), and what is a finding."""

from __future__ import annotations

from pathlib import Path

import pytest
from fmpy.model_description import read_model_description

from orchestration.acceptance import aliases
from orchestration.swap.findings import Finding

from .. import fmus


def findings(folder: Path, *variables: str) -> list[Finding]:
    """Of the motor with more variables; `(name, attributes, type)` in XML."""
    xml = fmus.description("motor").replace("</ModelVariables>", "".join(variables) + "</ModelVariables>")
    found: list[Finding] = []
    aliases.look(read_model_description(fmus.write(folder / "motor.fmu", xml), validate=False), found)
    return found


def variable(name: str, reference: int, attributes: str, kind: str = "<Real/>") -> str:
    return f'<ScalarVariable name="{name}" valueReference="{reference}" {attributes}>{kind}</ScalarVariable>'


LOCAL = 'causality="local"'
INPUT, OUTPUT = 'causality="input"', 'causality="output"'
CONSTANT = 'causality="local" variability="constant"'
VOLTS, TURNS = '<Real unit="V" start="0"/>', '<Real unit="rad/s"/>'


def test_references_of_different_types_are_no_aliases(tmp_path: Path) -> None:
    """The motor has a real, an integer, a boolean and a string of the reference 0."""
    variables = [variable("a", 700, LOCAL), variable("b", 700, LOCAL, "<Integer/>")]
    assert not [finding for finding in findings(tmp_path, *variables) if "700" in finding.text]


@pytest.mark.parametrize(
    ("variables", "told"),
    [
        (
            [variable("a", 700, INPUT, VOLTS), variable("b", 700, INPUT, VOLTS)],
            "a and b share the value reference 700 of type Real, and a and b can be set; expected at most one "
            "that can, "
            "since a value set for one is set for all",
        ),
        (
            [variable("a", 700, OUTPUT, TURNS), variable("b", 700, LOCAL, '<Real unit="rpm"/>')],
            "a and b share the value reference 700 of type Real, in the units rad/s, rpm; expected one unit",
        ),
        (
            [variable("a", 700, CONSTANT, '<Real start="1"/>'), variable("b", 700, LOCAL)],
            "a and b share the value reference 700 of type Real, of which a is constant; expected all of them or none",
        ),
        (
            [variable("a", 700, CONSTANT, '<Real start="1"/>'), variable("b", 700, CONSTANT, '<Real start="2"/>')],
            "a and b share the value reference 700 of type Real, constants with the start values 1, 2; expected "
            "one value",
        ),
    ],
)
def test_aliases_that_the_standard_forbids_are_errors(tmp_path: Path, variables: list[str], told: str) -> None:
    (found,) = (finding for finding in findings(tmp_path, *variables) if "700" in finding.text)
    assert (found.level, found.text) == ("error", told)


def test_an_enumeration_and_an_integer_are_of_one_type_since_one_function_sets_them(tmp_path: Path) -> None:
    enumeration = '<Enumeration declaredType="Mode" start="1"/>'
    parameter = 'causality="parameter" variability="fixed"'
    variables = [variable("a", 700, parameter, enumeration), variable("b", 700, parameter, '<Integer start="1"/>')]
    assert [f.level for f in findings(tmp_path, *variables) if "700" in f.text] == ["error"]


def test_an_output_that_has_the_value_of_an_input_or_of_a_local_variable_is_a_note(tmp_path: Path) -> None:
    """Tools leave out such copies, and they are right to."""
    variables = [variable("a", 700, INPUT, VOLTS), variable("b", 700, OUTPUT, '<Real unit="V"/>')]
    (found,) = (finding for finding in findings(tmp_path, *variables) if "700" in finding.text)
    assert found.level == "note"
    assert findings(tmp_path, variable("a", 700, LOCAL), variable("b", 700, LOCAL)) == findings(tmp_path)


def test_of_many_aliases_five_are_named(tmp_path: Path) -> None:
    variables = [variable(f"a{i}", 700, INPUT, VOLTS) for i in range(9)]
    (found,) = (finding for finding in findings(tmp_path, *variables) if "700" in finding.text)
    assert "a0, a1, a2, a3, a4 and 4 more share" in found.text
