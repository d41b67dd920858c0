"""A mapping and the options of a swap, as a user writes them: what is refused, and with which line."""

from __future__ import annotations

import pytest

from orchestration import InputError, run
from tests.commands import orchestrate

from ..swapped import swapped
from ..wrong_inputs import SCENARIO


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("ports: {speed: {theirs: rate, scale: 2, divide: 3}}", "expected at most one of scale and divide"),
        ("ports: {speed: {theirs: rate, scale: 0}}", "scale: expected a number other than 0"),
        ("ports: {speed: {theirs: rate, matrix: [[1, 0], [1]]}}", "expected rows of one length"),
        ("ports: {speed: {theirs: rate, matrix: [[.inf]]}}", "expected rows of finite numbers, found inf in one"),
        (f"ports: {{speed: {{theirs: rate, matrix: [[1{400 * '0'}]]}}}}", "of 401 digits"),
        ("ports: {speed: {theirs: rate, scale: .inf}}", "expected a finite number, found inf"),
        ("ports: {speed: {theirs: rate, divide: 1e999 kg}}", "expected a finite number, found 1e999 kg"),
        (f"ports: {{speed: {{theirs: rate, offset: [1{400 * '0'}]}}}}", "of 401 digits"),
        ("ports: {speed: {theirs: rate, inverse: true}}", "'inverse' is of a quaternion"),
        ("ports: {speed: {theirs: rate, quaternion: scalar first, scale: 2}}", "a quaternion goes without scale"),
        ("ports: {speed: {theirs: rate, unit: blorps}}", "unknown unit 'blorps'"),
        ("prots: {speed: rate}", "unknown key 'prots'; did you mean 'ports'?"),
        ("file: other.yaml", "a mapping's file holds the mapping itself"),
        ("[speed, rate]", "expected keys such as 'ports' and 'ignore', found a list"),
    ],
)
def test_a_wrong_mapping_is_refused_with_its_line(tmp_path, monkeypatch, text, message):
    swapped(tmp_path, monkeypatch)
    (tmp_path / "mapping.yaml").write_text(f"# theirs\n{text}\n")
    result = orchestrate("loop.yaml", "--swap", "regulator=vendor.fmu", "--map", "mapping.yaml")
    assert (result.exit_code, message in result.stderr) == (2, True), result.stderr
    assert "mapping.yaml:2:" in result.stderr


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('rad="1" factor="0.10471975511965977"', 'rad="1" factor="0"', "the unit 'rpm' has the factor 0.0"),
        ('rad="1" factor="0.10471975511965977"', 'rad="1" factor="-1"', "the unit 'rpm' has the factor -1.0"),
        ('rad="1" factor="0.10471975511965977"', 'rad="1" offset="NaN"', "and the offset nan; expected"),
        ('factor="9.549296585513721"', 'factor="0"', "the display unit 'rpm' of rad/s has the factor 0.0"),
        ('factor="9.549296585513721"', 'factor="INF"', "the display unit 'rpm' of rad/s has the factor inf"),
    ],
)
def test_a_unit_that_cannot_be_converted_is_refused_by_name(tmp_path, monkeypatch, old, new, message):
    path = swapped(tmp_path, monkeypatch, (old, new))
    for arguments in ((path.name, "--swap", "regulator=vendor.fmu"), ("check", "vendor.fmu", "--as", "regulator.fmu")):
        result = orchestrate(*arguments)
        assert (result.exit_code, message in result.stderr) == (2, True), result.stderr


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--swap", "regulator"), "--swap regulator: expected block=file.fmu"),
        (
            ("--swap", "regulater=vendor.fmu"),
            "--swap regulater=vendor.fmu: there is no block 'regulater'; did you mean 'regulator'?",
        ),
        (("--swap", "regulator=vendor.fmu", "--swap", "regulator=b.fmu"), "b.fmu: regulator is swapped twice"),
        (
            ("--swap", "regulator=vendor.fmu", "--map", "mapping.yaml", "--map", "regulator=b.yaml"),
            "--map regulator=b.yaml: regulator is mapped twice",
        ),
        (("--swap", "regulator=vender.fmu"), "there is no FMU vender.fmu; did you mean 'vendor.fmu'?"),
        (("--map", "mapping.yaml"), "--map mapping.yaml: expected the --swap that it belongs to"),
        (("--swap", "regulator=vendor.fmu", "--map", "motor=mapping.yaml"), "motor is not swapped"),
        (
            ("--swap", "regulator=vendor.fmu"),
            "input speed, a real scalar in rad/s, is missing; by name or unit it may be rate",
        ),
    ],
)
def test_a_wrong_swap_is_refused(tmp_path, monkeypatch, options, message):
    swapped(tmp_path, monkeypatch)
    result = orchestrate("loop.yaml", *options)
    assert (result.exit_code, message in result.stderr) == (2, True), result.stderr


def test_a_path_of_a_mapping_that_can_be_none_is_refused_with_its_line(tmp_path, monkeypatch):
    swapped(tmp_path, monkeypatch)
    text = SCENARIO.replace(
        "fmu: regulator.fmu", 'fmu: vendor.fmu\n    interface: regulator.fmu\n    map: "a\\0b.yaml"'
    )
    (tmp_path / "loop.yaml").write_text(text)
    with pytest.raises(InputError, match=r"loop\.yaml:13: blocks\.regulator\.map: .* is no path: embedded null byte$"):
        run(tmp_path / "loop.yaml")


def test_a_mapping_without_an_interface_is_refused(tmp_path, monkeypatch):
    text = SCENARIO.replace("fmu: regulator.fmu", "fmu: vendor.fmu\n    map: mapping.yaml")
    path = swapped(tmp_path, monkeypatch, scenario=text)
    with pytest.raises(InputError, match="a mapping needs to know whose ports stand on its left"):
        run(path)
