"""`orchestrate check --vector` refuses a broken vector with its line. tests/fmus/kit/test_kit.py has vectors that are
played.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestration import run
from orchestration.acceptance.tables import parameters_of
from orchestration.fmu.archive import open_fmu
from tests.commands import orchestrate

from .test_check import here  # noqa: F401

VECTOR = "time,voltage,speed,steps\n0,1,0,0\n0.1,1,0.2,1\n0.2,2,0.6,2\n0.3,-1,0.4,3\n0.4,-1,0.2,4\n"
PARAMETERS = 'name,value\ninertia,0.5\nmode,2\npoles,4\naxis[2],3\ncooled,1\nlabel,"a, b"\n'


@pytest.fixture
def played(here):  # noqa: F811
    def play(table: str | None = VECTOR, parameters: str | bytes | None = PARAMETERS):
        Path("v").mkdir()
        for name, content in (("vector.csv", table), ("parameters.csv", parameters)):
            if content is not None:
                Path("v", name).write_bytes(content if isinstance(content, bytes) else content.encode())
        return orchestrate("check", "motor.fmu", "--as", "motor.fmu", "--vector", "v")

    return play


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("name,value\n", {}),
        (PARAMETERS, {"inertia": 0.5, "axis[2]": 3.0, "mode": "brake", "poles": 4, "cooled": True, "label": "a, b"}),
    ],
)
def test_parameters_are_read_and_a_header_alone_states_none(here, text, values):  # noqa: F811
    Path("parameters.csv").write_text(text)
    assert parameters_of(open_fmu(Path("motor.fmu")).model, Path()) == values


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (None, "vector.csv: there is no such file or folder; expected a test vector"),
        ("", "vector.csv: it is empty; expected a column 'time'"),
        (b"\xff\xfe", "vector.csv: expected text in UTF-8"),
        (VECTOR.replace("time", "t"), "vector.csv: expected a column 'time'"),
        ("time,voltage\n0,1\n0.1,1\n", "vector.csv:1: expected a column of an output of motor, found none"),
        (VECTOR.replace("speed", "speeed"), "vector.csv:1: motor has no input or output 'speeed'"),
        (VECTOR.replace("steps", "speed"), "vector.csv:1: the column 'speed' is there twice"),
        (VECTOR.replace("0.6", "fast"), "vector.csv:4: speed: expected a number, found 'fast'"),
        (VECTOR.replace("0.6", "nan"), "vector.csv:4: speed: expected a number, found 'nan'"),
        (VECTOR.replace("0.3,", "nan,"), "vector.csv:5: time: expected a number, found 'nan'"),
        (VECTOR.replace("0.3,", "1e9,"), "vector.csv:5: time: expected 0.3 s, after 0.2 s, found 1000000000"),
        (VECTOR.replace("0.2,2,0.6,2\n", ""), "vector.csv:4: time: expected 0.2 s, after 0.1 s, found 0.3"),
        (VECTOR.replace("0.1,1,", "0.1,"), "vector.csv:3: expected 4 values, as in the header, found 3"),
        ("time,speed\n0,1\n0,1\n", "vector.csv:3: time: expected times that rise, found 0"),
    ],
)
def test_a_broken_table_is_refused_with_its_line(played, table, message):
    told = played(table)
    assert (told.exit_code, told.stdout) == (2, "")
    assert told.stderr.startswith(f"v/{message}")


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        (None, ": there is no such file or folder; expected a test vector"),
        ("", ": it is empty; expected a header 'name,value'"),
        ("inertia,0.5\n", ":1: expected the header 'name,value', found 'inertia,0.5'"),
        (b"name,value\n\xff\xfe", ": expected text in UTF-8"),
        (PARAMETERS.replace("0.5", "abc"), ":2: inertia: expected a number, found 'abc'"),
        (PARAMETERS.replace("0.5", "inf"), ":2: inertia: expected a number, found 'inf'"),
        (PARAMETERS.replace("inertia,0.5", "inertia"), ":2: expected a name and a value, found 'inertia'"),
        (PARAMETERS.replace("inertia", "speed"), ":2: motor has no parameter 'speed'"),
        (PARAMETERS.replace("mode", "inertia"), ":3: the parameter 'inertia' is there twice"),
        (PARAMETERS.replace("poles,4", "poles,4.5"), ":4: poles: expected a whole number, found '4.5'"),
    ],
)
def test_a_broken_list_of_parameters_is_refused_with_its_line(played, parameters, message):
    told = played(parameters=parameters)
    assert (told.exit_code, told.stdout) == (2, "")
    assert told.stderr.startswith(f"v/parameters.csv{message}")


def test_a_vector_is_played_against_an_fmu_that_is_no_block_of_the_project(loop):
    """Its own outputs are as expected, others are not."""
    Path("v").mkdir()
    Path("v/parameters.csv").write_text("name,value\ngain,-1\n")
    result = run(loop)
    columns = [result.time, result["motor.speed"], result["regulator.voltage"]]
    for off, status in ((0.0, 0), (0.1, 1)):
        rows = [f"{t!r},{w!r},1,{u + off!r}" for t, w, u in zip(*(c.ravel().tolist() for c in columns), strict=True)]
        Path("v/vector.csv").write_text("\n".join(["time,speed,enabled,voltage", *rows]) + "\n")
        told = orchestrate("check", "regulator.fmu", "--as", "regulator.fmu", "--vector", "v")
        assert (told.exit_code, told.stderr) == (status, ""), told.output
        assert ("voltage: differs by at most 0.1" in told.stdout) == bool(status)


def test_an_output_that_theirs_lacks_hides_no_other_behind_it(here):  # noqa: F811
    Path("map.yaml").write_text("ports: {}\nignore: [speed]\n")
    Path("v").mkdir()
    Path("v/parameters.csv").write_text("name,value\n")
    for last, status in (("4", 0), ("5", 1)):
        Path("v/vector.csv").write_text(VECTOR[: VECTOR.rindex("4")] + last + "\n")
        told = orchestrate("check", "motor.fmu", "--as", "motor.fmu", "--map", "map.yaml", "--vector", "v")
        assert told.exit_code == status, told.output
        assert ("steps: as expected" in told.stdout) != bool(status)
