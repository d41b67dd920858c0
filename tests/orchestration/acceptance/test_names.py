"""Names of variables by the naming conventions of FMI 2.0, against FMPy's grammar; and hints among thousands of
names."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from fmpy import validation

from orchestration.acceptance.check import _misnamed
from orchestration.errors import nearest

LEGAL = ["x", "_x1", "R_NB[1,2]", "a.b[3].c", "der(x)", "der(a.b[1],2)", "'any thing (at all)'", "a.'b c'[1]", "x[10]"]
ILLEGAL = [
    "",
    "1x",
    "x y",
    "x[1, 2]",
    "x[]",
    "x[-1]",
    "a..b",
    "a.",
    "der(x",
    "der(x,)",
    "''",
    "x-y",
    "x[1][2]",
    "'a",
    "ä",
]


def described(convention: str, *names: str) -> SimpleNamespace:
    variables = [SimpleNamespace(name=name, sourceline=7) for name in names]
    return SimpleNamespace(variableNamingConvention=convention, modelVariables=variables)


@pytest.mark.parametrize("convention", ["structured", "flat"])
def test_the_names_that_are_refused_are_those_that_fmpy_refuses(convention: str) -> None:
    names = [*LEGAL, *ILLEGAL, "a\tb", "a\nb", "a\rb"]
    theirs = [problem.split('"')[1] for problem in validation._validate_variable_names(described(convention, *names))]
    ours = [problem.split('"')[1] for problem in _misnamed(described(convention, *names))]
    assert ours == list(dict.fromkeys(theirs))
    assert set(ours) == ({*ILLEGAL, "a\tb", "a\nb", "a\rb"} if convention == "structured" else {"a\tb", "a\nb", "a\rb"})


def test_a_name_that_is_refused_is_told_with_its_line() -> None:
    expected = '"x y" (line 7) is not a legal variable name for naming convention "structured".'
    assert _misnamed(described("structured", "x", "x y")) == [expected]


def test_among_thousands_of_names_the_nearest_with_the_same_letter_is_found() -> None:
    names = [f"p{i}" for i in range(9000)]
    assert nearest("omega_b", [*names, "omega_B"]) == "omega_B"
    assert nearest("tau", names) is None
