"""What an FMU may hold, each bound refused with its number before anything is read or unpacked."""

from __future__ import annotations

import os
import struct
import sys
import warnings
import zipfile
from pathlib import Path

import pytest

from orchestration.errors import InputError
from orchestration.fmu import head, zipped
from orchestration.fmu.archive import open_fmu

from .. import fmus

DESCRIPTION = fmus.description("motor")


def message(path: Path, lenient: bool = False) -> str:
    with pytest.raises(InputError) as caught:
        open_fmu(path, lenient)
    return str(caught.value)


@pytest.fixture
def motor(tmp_path: Path) -> Path:
    return fmus.write(tmp_path / "motor.fmu", DESCRIPTION)


def declared(path: Path, size: int) -> None:
    """Declares another size of the last entry, in its header and in the directory."""
    data = bytearray(path.read_bytes())
    struct.pack_into("<I", data, data.rindex(b"PK\x03\x04") + 22, size)
    struct.pack_into("<I", data, data.rindex(b"PK\x01\x02") + 24, size)
    path.write_bytes(data)


@pytest.mark.skipif(sys.platform == "win32", reason="names a device of POSIX")
def test_a_device_and_a_pipe_are_refused_without_being_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.fmu")
    (tmp_path / "zero.fmu").symlink_to("/dev/zero")
    for path in (tmp_path / "pipe.fmu", tmp_path / "zero.fmu", Path("/dev/zero")):
        assert "is a device, a pipe or a socket; expected a regular file" in message(path)


def test_a_file_larger_than_the_limit_is_refused(motor: Path) -> None:
    with motor.open("r+b") as file:
        file.truncate(zipped.ARCHIVE_MAX + 10**9)  # a hole, which takes no room on the disk
    assert "motor.fmu holds 2 GB; expected at most 1 GB" in message(motor)


def test_what_unpacks_to_more_than_the_limit_is_refused(motor: Path) -> None:
    declared(motor, 3 * 10**9)
    assert "motor.fmu would unpack to 3 GB; expected at most 2 GB" in message(motor)


def test_more_entries_than_the_limit_are_refused(motor: Path) -> None:
    with zipfile.ZipFile(motor, "a") as file:
        for i in range(zipped.ENTRIES_MAX):
            file.writestr(f"resources/{i}", b"")
    assert f"motor.fmu holds {zipped.ENTRIES_MAX + 2} entries; expected at most {zipped.ENTRIES_MAX}" in message(motor)


def test_a_directory_of_entries_larger_than_the_limit_is_refused_before_it_is_read(motor: Path) -> None:
    data = bytearray(motor.read_bytes())
    struct.pack_into("<I", data, data.rindex(b"PK\x05\x06") + 12, 3 * 10**9)
    motor.write_bytes(data)
    assert "motor.fmu lists its entries in 3 GB; expected at most 16 MB" in message(motor)


def test_a_description_larger_than_the_limit_is_refused(tmp_path: Path) -> None:
    path = fmus.write(tmp_path / "motor.fmu", DESCRIPTION + "<!--" + " " * head.XML_MAX + "-->")
    assert "modelDescription.xml holds 64 MB; expected at most 64 MB" in message(path)


def test_more_variables_than_the_limit_are_refused_before_they_are_read(tmp_path: Path) -> None:
    many = '<ScalarVariable name="x" valueReference="1"><Real/></ScalarVariable>' * head.VARIABLES_MAX
    path = fmus.write(tmp_path / "motor.fmu", DESCRIPTION.replace("</ModelVariables>", f"{many}</ModelVariables>"))
    assert "modelDescription.xml declares 100015 variables; expected at most 100000" in message(path)


def test_an_entry_without_a_name_is_refused(motor: Path) -> None:
    with zipfile.ZipFile(motor, "a") as archive:
        entry = zipfile.ZipInfo("x")
        entry.filename = ""
        archive.writestr(entry, b"1")
    assert "motor.fmu holds an entry without a name" in message(motor)


def test_encrypted_entries_and_names_twice_are_refused(motor: Path) -> None:
    data = bytearray(motor.read_bytes())
    struct.pack_into("<H", data, data.rindex(b"PK\x01\x02") + 8, 1)
    motor.write_bytes(data)
    assert "is encrypted: binaries/" in message(motor)
    fmus.write(motor, DESCRIPTION)
    with zipfile.ZipFile(motor, "a") as file, pytest.warns(UserWarning, match="Duplicate name"):
        file.writestr("modelDescription.xml", DESCRIPTION)
    assert "holds modelDescription.xml 2 times; expected each name once" in message(motor)


def test_a_folder_that_an_archive_lists_twice_is_no_error(motor: Path) -> None:
    with zipfile.ZipFile(motor, "a") as archive, warnings.catch_warnings(action="ignore"):
        archive.writestr("binaries/", b"")
        archive.writestr("binaries/", b"")
    assert open_fmu(motor).model.name == "motor"


# ---------------------------------------------------------------- descriptions


def test_the_version_is_read_in_any_encoding(tmp_path: Path) -> None:
    later = DESCRIPTION.replace('fmiVersion="2.0"', 'fmiVersion="3.1"')
    for encoding in ("utf-16", "utf-8", "gbk"):
        xml = later.replace("UTF-8", encoding.upper()).encode(encoding)
        with zipfile.ZipFile(tmp_path / "motor.fmu", "w") as file:
            file.writestr("modelDescription.xml", xml)
        assert "is an FMU of FMI 3.1; expected FMI 2.0 or 3.0" in message(tmp_path / "motor.fmu")


def test_an_encoding_that_nobody_knows_is_told(tmp_path: Path) -> None:
    path = fmus.write(tmp_path / "motor.fmu", DESCRIPTION.replace("UTF-8", "EBCDIC-XY"))
    assert "modelDescription.xml cannot be read: " in message(path)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('<Real unit="rad/s" start="1"/>', '<Real unit="rad/s" start=""/>', "speed0 has the start value ''; "
                                                                            "expected a number"),
        ('<Integer start="2" min', '<Integer start="1e999" min', "poles has the start value '1e999'; expected "
                                                                 "a number"),
        ('<Boolean start="false"/>', '<Boolean start="maybe"/>', "cooled has the start value 'maybe'; expected "
                                                                 "true or false"),
    ],
)  # fmt: skip
def test_a_start_value_of_no_value_is_told_even_where_the_schema_is_passed_over(
    tmp_path: Path, old: str, new: str, problem: str
) -> None:
    assert old in DESCRIPTION
    path = fmus.write(tmp_path / "motor.fmu", DESCRIPTION.replace(old, new))
    assert "is not valid" in message(path)
    assert problem in message(path, lenient=True)


def test_an_integer_output_as_pythonfmu_writes_it_is_passed_over_on_demand(tmp_path: Path) -> None:
    default = DESCRIPTION.replace('variability="discrete">\n      <Integer/>', "><Integer/>")
    path = fmus.write(tmp_path / "motor.fmu", default)
    assert 'is of type Integer and must have variability != "continuous"' in message(path)
    (problem,) = open_fmu(path, lenient=True).problems
    assert "must have variability" in problem


def test_a_library_of_another_name_is_named(tmp_path: Path) -> None:
    path = fmus.write(tmp_path / "motor.fmu", DESCRIPTION.replace('modelIdentifier="probe"', 'modelIdentifier="prope"'))
    told = message(path)
    assert "/prope" in told.split("found")[0]
    assert "/probe" in told.split("found")[1]
