"""FMUs that are damaged or mean harm: what `check` says of them, and what of their text reaches the terminal."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import fmpy
import pytest
from click.testing import Result

import orchestration
from orchestration.errors import printable, printable_json
from tests.commands import orchestrate

from .. import fmus
from ..wrong_inputs import SCENARIO


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    fmus.write_pair(tmp_path, runnable=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def coloured(*arguments: object) -> Result:
    """As in a terminal: no code of a foreign text may reach it."""
    result = orchestrate(*arguments, color=True)
    assert result.exit_code != 70, result.output
    return result


def check(*options: str) -> Result:
    return coloured("check", "regulator.fmu", "--as", "motor.fmu", *options)


def rewritten(old: str, new: str) -> None:
    """regulator.fmu with text of its description replaced."""
    xml = fmus.description("regulator")
    assert old in xml
    fmus.write(Path("regulator.fmu"), xml.replace(old, new), fmus.library())


def test_an_archive_that_cannot_be_unpacked_does_not_fit(here: Path) -> None:
    with zipfile.ZipFile("regulator.fmu", "a") as archive:
        archive.writestr("resources", b"a file where a folder is needed")
        archive.writestr("resources/table.csv", b"")
    result = check()
    assert result.exit_code == 2
    assert "regulator.fmu cannot be unpacked: " in result.output


def test_damage_in_an_entry_that_nobody_reads_is_told(here: Path) -> None:
    with zipfile.ZipFile("regulator.fmu", "a") as archive:
        archive.writestr("resources/table.csv", b"a" * 1000, zipfile.ZIP_STORED)
    path = Path("regulator.fmu")
    path.write_bytes(path.read_bytes().replace(b"a" * 1000, b"a" * 999 + b"b"))
    result = check()
    assert result.exit_code == 2
    assert "is a damaged zip archive: Bad CRC-32 for file 'resources/table.csv'" in result.output


def test_a_library_of_another_name_is_named(here: Path) -> None:
    rewritten('modelIdentifier="probe"', 'modelIdentifier="prope"')
    folder = f"binaries/{fmpy.platform}"
    suffix = fmpy.sharedLibraryExtension
    assert f"expected {folder}/prope{suffix}, found {folder}/probe{suffix}" in check().output


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('<Real start="-1"/>', '<Real start=""/>'),
        ("UTF-8", "EBCDIC-XY"),
        ('fmiVersion="2.0" ', ""),
        ('index="5"', 'index="500"'),
        ('valueReference="1"', 'valueReference="x"'),
        ('<Real unit="V"/>', ""),
        ('<Item name="normal" value="1"/>', '<Item name="normal" value=""/>'),
    ],
)
def test_a_description_that_is_not_valid_is_an_error_and_no_crash(here: Path, old: str, new: str) -> None:
    rewritten(old, new)
    for options in ((), ("--lenient",)):
        assert check(*options).exit_code in (1, 2)


def test_a_description_in_gbk_is_read(here: Path) -> None:
    xml = fmus.description("motor").replace("UTF-8", "GBK").replace('modelName="motor"', 'modelName="电机"')
    with zipfile.ZipFile("motor.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", xml.encode("gbk"))
        archive.writestr(f"binaries/{fmpy.platform}/probe{fmpy.sharedLibraryExtension}", fmus.library())
    assert coloured("check", "motor.fmu", "--as", "motor.fmu").exit_code == 0


# ---------------------------------------------------------------- lenient


def test_a_formal_error_is_a_warning_where_the_block_says_so(here: Path) -> None:
    rewritten('<ScalarVariable name="enabled" valueReference="5" causality="input" variability="discrete">',
              '<ScalarVariable name="enabled" valueReference="5" causality="input">')  # fmt: skip
    path = Path("loop.yaml")
    path.write_text(SCENARIO)
    refused = coloured(path)
    assert refused.exit_code == 2
    assert "must have variability" in refused.output
    there = "write 'validation: lenient' in the entry of regulator under blocks in the scenario, to run it all the same"
    assert f"remedy: correct it in the exporting tool, or {there}" in refused.output
    path.write_text(SCENARIO.replace("fmu: regulator.fmu", "fmu: regulator.fmu\n    validation: lenient"))
    (warning,) = orchestration.run(path).warnings
    assert warning.startswith(
        "loop.yaml:12: blocks.regulator.validation: regulator.fmu: modelDescription.xml is not valid"
    )
    assert check().exit_code == check("--lenient").exit_code == 1


# ---------------------------------------------------------------- what reaches the terminal


def test_control_characters_are_escaped_and_other_text_stays() -> None:
    hostile = "a\x1b]0;title\x07\x9b2J\r\x7f\u202eb\udc80"
    assert printable(hostile) == r"a\x1b]0;title\x07\x9b2J\r\x7f\u202eb\udc80"
    assert json.loads(printable_json(json.dumps([hostile], ensure_ascii=False))) == [hostile]
    assert printable("Größe, ω in rad/s\n\t电机") == "Größe, ω in rad/s\n\t电机"


def test_no_escape_sequence_of_a_vendor_reaches_the_terminal(here: Path) -> None:
    with zipfile.ZipFile("regulator.fmu", "a") as archive:
        archive.writestr(f"binaries/{fmpy.platform}/\x1b]0;owned\x07.so", b"")
    rewritten_name = fmus.description("motor").replace('modelIdentifier="probe"', 'modelIdentifier="\x9b2Jprobe"')
    fmus.write(Path("motor.fmu"), rewritten_name, fmus.library())
    for arguments in (
        ("check", "motor.fmu", "--as", "regulator.fmu"),
        ("check", "motor.fmu", "--as", "regulator.fmu", "--json"),
    ):
        output = coloured(*arguments).output
        assert "2Jprobe" in output
        assert "\x9b" not in output
        assert "\x1b]" not in output


def test_a_unit_that_is_not_defined_but_has_a_display_unit_is_named(here: Path) -> None:
    xml = fmus.description("regulator")
    defined = '<Unit name="V"><BaseUnit/><DisplayUnit name="kV" factor="0.001"/></Unit>'
    xml = xml.replace("<UnitDefinitions>", f"<UnitDefinitions>{defined}").replace(
        '<Real unit="V"/>', '<Real unit="zz" displayUnit="kV"/>'
    )
    fmus.write(Path("regulator.fmu"), xml, fmus.library())
    result = check()
    assert "regulator.fmu: modelDescription.xml cannot be read: it names 'zz' and does not define it" in result.stderr
